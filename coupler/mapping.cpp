#include "coupler/mapping.hpp"

#include "common/core/error.hpp"
#include "common/sph/kernel.hpp"
#include "common/sph/neighbours.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace poretwin::coupling {
namespace {

using Size = std::size_t;

template <int D>
Vec<D> point(std::span<const double> positions, Size i) {
  return Eigen::Map<const Vec<D>>(positions.data() + i * D);
}

template <int D>
double largest_move(std::span<const double> now, std::span<const double> then) {
  double largest = 0.0;
  for (Size i = 0; i * D < now.size(); ++i)
    largest = std::max(largest, (point<D>(now, i) - point<D>(then, i)).squaredNorm());
  return std::sqrt(largest);
}

/// Smallest eigenvalue of a symmetric matrix.
double smallest_eigenvalue(const Mat<2>& c) {
  const double half = 0.5 * (c(0, 0) - c(1, 1));
  return 0.5 * (c(0, 0) + c(1, 1)) - std::sqrt(half * half + c(0, 1) * c(0, 1));
}
double smallest_eigenvalue(const Mat<3>& c) {
  Eigen::SelfAdjointEigenSolver<Mat<3>> solver;
  solver.computeDirect(c, Eigen::EigenvaluesOnly);
  return solver.eigenvalues()[0];
}

/// Weights below this add nothing but noise: a target at the very rim of one support counts as uncovered.
constexpr double nothing = 1e-12;

/// The cell order of points, for neighbours in memory.
template <int D>
std::vector<Index> cell_order(const VecArray<D>& points, double cell) {
  sph::CellGrid<D> grid;
  grid.build(points, cell);
  return {grid.order().begin(), grid.order().end()};
}

/// Columns are summed in blocks of this many, which stay in registers.
constexpr Size block = 4;
using Block = Eigen::Array<double, static_cast<int>(block), 1>;

/// One target's neighbours with their final coefficients.
template <int D>
struct Row {
  std::vector<Index> source;
  std::vector<double> weight;
  VecArray<D> offset;
  Size n = 0;
  bool extrapolates = false;  ///< some coefficient is negative: the result may leave the neighbours' range
  // Moments of the kernel weights.
  double m0 = 0.0, mh = 0.0;  ///< sum of w; of w h
  Vec<D> m1 = Vec<D>::Zero();

  void clear(Size size) {
    n = 0;
    if (source.size() >= size) return;
    source.resize(size);
    weight.resize(size);
    offset.resize(size);
  }

  void add(Index j, double w, const Vec<D>& r) {
    source[n] = j;
    weight[n] = w;
    offset[n] = r;
    ++n;
  }

  /// From kernel weights to coefficients that sum to one; false where there is nothing.
  bool normalise(std::span<const double> h) {
    m0 = mh = 0.0;
    m1.setZero();
    Mat<D> m2 = Mat<D>::Zero();
    for (Size p = 0; p < n; ++p) {
      const double w = weight[p];
      m0 += w;
      mh += w * h[source[p]];
      m1 += w * offset[p];
      m2 += (w * offset[p]) * offset[p].transpose();
    }
    extrapolates = false;
    if (!(m0 > nothing)) return false;
    const double scale = 1.0 / m0;
    const Vec<D> mean = scale * m1;
    const Mat<D> covariance = scale * m2 - mean * mean.transpose();
    const double length = scale * mh;
    const double spread = smallest_eigenvalue(covariance) / (length * length);
    const double share = std::clamp((spread - slope_off) / (slope_full - slope_off), 0.0, 1.0);
    if (share == 0.0) {
      for (Size p = 0; p < n; ++p) weight[p] *= scale;
      return true;
    }
    const Vec<D> slope = share * (covariance.inverse() * mean);
    const double constant = 1.0 + slope.dot(mean);
    double least = 0.0;
    for (Size p = 0; p < n; ++p) {
      weight[p] *= scale * (constant - slope.dot(offset[p]));
      least = std::min(least, weight[p]);
    }
    extrapolates = least < 0.0;
    return true;
  }
};

/// One block of columns of a row's value: `n` sources with their coefficients; `packed` holds `width` columns for every
/// source.
Block sum(const Index* source, const double* coefficient, Size n, const double* packed, Size width) {
  Block total = Block::Zero();
  for (Size p = 0; p < n; ++p) total += coefficient[p] * Eigen::Map<const Block>(packed + source[p] * width);
  return total;
}
/// The same, kept within the range of the neighbours' values.
Block bounded_sum(const Index* source, const double* coefficient, Size n, const double* packed, Size width) {
  Block total = Block::Zero(), low = Block::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (Size p = 0; p < n; ++p) {
    const Eigen::Map<const Block> value(packed + source[p] * width);
    total += coefficient[p] * value;
    low = low.min(value);
    high = high.max(value);
  }
  return total.max(low).min(high);
}

}  // namespace

template <int D>
void PairWeights<D>::update(const PointSet& source, const PointSet& target) {
  receivers_ = source.n_active;
  if (!lists_hold(source, target)) {
    search(source, target);
    ++counts_.rebuilds;
    gather(source, target);
  } else if (gather(source, target)) {
    ++counts_.reuses;
  } else {
    ++counts_.unchanged;
    return;
  }
  weigh();
}

template <int D>
bool PairWeights<D>::lists_hold(const PointSet& source, const PointSet& target) const {
  if (skin_ <= 0.0 || source.position.size() != source_then_.size() || target.n_active * D != target_then_.size())
    return false;
  double growth = 0.0;
  for (Size j = 0; j < h_then_.size(); ++j) growth = std::max(growth, source.smoothing_length[j] - h_then_[j]);
  const std::span<const double> active(target.position.data(), target.n_active * D);
  const double moved = largest_move<D>(source.position, source_then_) + largest_move<D>(active, target_then_);
  return moved + sph::support_radius * growth <= skin_;
}

template <int D>
void PairWeights<D>::search(const PointSet& source, const PointSet& target) {
  const Size n = source.size(), m = target.n_active;
  source_then_ = source.position;
  target_then_.assign(target.position.begin(), target.position.begin() + static_cast<std::ptrdiff_t>(m * D));
  h_then_ = source.smoothing_length;
  first_.assign(m + 1, 0);
  index_.clear();
  source_order_.clear();
  target_order_.resize(m);
  for (Size i = 0; i < m; ++i) target_order_[i] = static_cast<Index>(i);
  skin_ = 0.0;
  if (n == 0 || m == 0) return;

  const double largest = sph::support_radius * *std::max_element(h_then_.begin(), h_then_.end());
  skin_ = relative_skin * largest;
  const double reach = largest + skin_;
  VecArray<D> x(n), y(m);
  for (Size j = 0; j < n; ++j) x[j] = point<D>(source.position, j);
  for (Size i = 0; i < m; ++i) y[i] = point<D>(target.position, i);
  source_order_ = cell_order<D>(x, reach);
  target_order_ = cell_order<D>(y, reach);
  VecArray<D> sorted(n);
  std::vector<double> radius(n);
  for (Size j = 0; j < n; ++j) {
    sorted[j] = x[source_order_[j]];
    radius[j] = sph::support_radius * h_then_[source_order_[j]] + skin_;
  }
  sph::CellGrid<D> grid;
  grid.build(sorted, reach);
  for (Size i = 0; i < m; ++i) {
    grid.for_each_within(y[target_order_[i]], reach, [&](Index j, double r2) {
      if (r2 < radius[j] * radius[j]) index_.push_back(j);
    });
    first_[i + 1] = static_cast<Index>(index_.size());
  }
}

template <int D>
bool PairWeights<D>::gather(const PointSet& source, const PointSet& target) {
  const Size n = source_order_.size(), m = target_order_.size();
  bool changed = source_.size() != n || target_.size() != m;
  source_.resize(n);
  volume_.resize(n);
  h_.resize(n);
  owner_.resize(n);
  target_volume_.resize(m);
  target_.resize(m);
  auto set = [&changed](auto& kept, const auto& now) {
    changed = changed || kept != now;
    kept = now;
  };
  for (Size j = 0; j < n; ++j) {
    const Size k = source_order_[j];
    set(source_[j], point<D>(source.position, k));
    set(volume_[j], source.volume[k]);
    set(h_[j], source.smoothing_length[k]);
    set(owner_[j], static_cast<std::int64_t>(source.owner[k]));
  }
  for (Size i = 0; i < m; ++i) {
    set(target_[i], point<D>(target.position, target_order_[i]));
    set(target_volume_[i], target.volume[target_order_[i]]);
  }
  return changed;
}

template <int D>
void PairWeights<D>::weigh() {
  weight_.resize(index_.size());
  near_.resize(index_.size());
  coefficient_.resize(index_.size());
  n_near_.assign(target_.size(), 0);
  extrapolates_.assign(target_.size(), 0);
  coverage_.assign(target_.size(), 0.0);
  asymmetry_.assign(target_.size(), 0.0);
  // V W(r, h) = V / h^D W(r / h, 1): the divisions are the source's, not the pair's.
  const Size n = source_.size();
  std::vector<double> per_length(n), amplitude(n);
  for (Size j = 0; j < n; ++j) {
    per_length[j] = 1.0 / h_[j];
    amplitude[j] = volume_[j];
    for (int d = 0; d < D; ++d) amplitude[j] *= per_length[j];
  }
  Row<D> row;
  for (Size i = 0; i < target_.size(); ++i) {
    const Vec<D> x = target_[i];
    row.clear(first_[i + 1] - first_[i]);
    for (Index p = first_[i]; p < first_[i + 1]; ++p) {
      const Index j = index_[p];
      const Vec<D> r = source_[j] - x;
      const double w = amplitude[j] * sph::WendlandC2<D>::value(r.norm() * per_length[j], 1.0);
      weight_[p] = w;
      if (w > 0.0) row.add(j, w, r);
    }
    if (!row.normalise(h_)) continue;
    coverage_[target_order_[i]] = row.m0;
    asymmetry_[target_order_[i]] = row.m1.norm() / row.mh;
    std::copy_n(row.source.begin(), row.n, near_.begin() + static_cast<std::ptrdiff_t>(first_[i]));
    std::copy_n(row.weight.begin(), row.n, coefficient_.begin() + static_cast<std::ptrdiff_t>(first_[i]));
    n_near_[i] = static_cast<Index>(row.n);
    extrapolates_[i] = row.extrapolates;
  }
}

template <int D>
std::vector<Field> PairWeights<D>::consistent(std::span<const Field* const> fields,
                                              std::span<const double> mask) const {
  const Size n = source_.size(), m = target_.size();
  Size width = 0;
  std::vector<Field> out;
  for (const Field* field : fields) {
    out.push_back({field->name, field->components, std::vector<double>(m * static_cast<Size>(field->components), 0.0)});
    width += static_cast<Size>(field->components);
  }
  width = (width + block - 1) / block * block;
  // All fields of one source point side by side: one cache line serves them all.
  std::vector<double> packed(n * width, 0.0);
  Size column = 0;
  for (const Field* field : fields) {
    const Size components = static_cast<Size>(field->components);
    for (Size j = 0; j < n; ++j)
      for (Size c = 0; c < components; ++c)
        packed[j * width + column + c] = field->values[source_order_[j] * components + c];
    column += components;
  }
  std::vector<double> share;
  if (!mask.empty()) {
    share.resize(n);
    for (Size j = 0; j < n; ++j) share[j] = mask[source_order_[j]];
  }
  Row<D> row;
  std::vector<double> total(width);
  for (Size i = 0; i < m; ++i) {
    const Index* near = near_.data() + first_[i];
    const double* coefficient = coefficient_.data() + first_[i];
    Size count = n_near_[i];
    bool extrapolates = extrapolates_[i] != 0;
    if (!share.empty()) {  // other weights, other moments
      row.clear(first_[i + 1] - first_[i]);
      for (Index p = first_[i]; p < first_[i + 1]; ++p)
        if (const double w = weight_[p] * share[index_[p]]; w > 0.0)
          row.add(index_[p], w, source_[index_[p]] - target_[i]);
      count = row.normalise(h_) ? row.n : 0;
      near = row.source.data();
      coefficient = row.weight.data();
      extrapolates = row.extrapolates;
    }
    if (count == 0) continue;
    for (Size b = 0; b < width; b += block)
      Eigen::Map<Block>(total.data() + b) = extrapolates
                                                ? bounded_sum(near, coefficient, count, packed.data() + b, width)
                                                : sum(near, coefficient, count, packed.data() + b, width);
    const Size target = target_order_[i];
    Size from = 0;
    for (auto& field : out) {
      const Size components = static_cast<Size>(field.components);
      std::copy_n(total.begin() + static_cast<std::ptrdiff_t>(from), components,
                  field.values.begin() + static_cast<std::ptrdiff_t>(target * components));
      from += components;
    }
  }
  return out;
}

/// Factors on the receivers' weights under which an even giving arrives evenly however disordered the points are: what
/// reaches a receiver from the giving volumes is to be its own volume (Sinkhorn 1967). Only receivers inside the cloud
/// of those that give are balanced; at its edge the shares stay as the kernel has them.
template <int D>
std::vector<double> PairWeights<D>::balance(const Field& amounts) const {
  const Size components = static_cast<Size>(amounts.components);
  std::vector<double> scale(receivers_, 1.0), load(receivers_), weight(receivers_, 0.0), own(receivers_, 0.0);
  VecArray<D> moment(receivers_, Vec<D>::Zero());
  // The pairs that count, giver by giver: every round walks through them twice.
  struct Share {
    Index receiver;
    double weight;
  };
  std::vector<Share> shares;
  std::vector<Size> last;
  std::vector<double> volume;
  for (Size i = 0; i < target_.size(); ++i) {
    const double* amount = amounts.values.data() + target_order_[i] * components;
    if (std::all_of(amount, amount + components, [](double a) { return a == 0.0; })) continue;
    for (Index p = first_[i]; p < first_[i + 1]; ++p) {
      const Index k = index_[p];
      if (owner_[k] < 0 || weight_[p] == 0.0) continue;
      const Size j = static_cast<Size>(owner_[k]);
      weight[j] += weight_[p] * h_[k];
      moment[j] += weight_[p] * (target_[i] - source_[k]);
      shares.push_back({static_cast<Index>(j), weight_[p]});
    }
    last.push_back(shares.size());
    volume.push_back(target_volume_[i]);
  }
  for (Size k = 0; k < source_.size(); ++k)
    if (source_order_[k] < receivers_) own[source_order_[k]] = volume_[k];
  for (int round = 0; round < balancing_rounds; ++round) {
    std::fill(load.begin(), load.end(), 0.0);
    for (Size i = 0, first = 0; i < last.size(); first = last[i++]) {
      double total = 0.0;
      for (Size p = first; p < last[i]; ++p) total += shares[p].weight * scale[shares[p].receiver];
      if (!(total > nothing)) continue;
      const double part = volume[i] / total;
      for (Size p = first; p < last[i]; ++p)
        load[shares[p].receiver] += part * shares[p].weight * scale[shares[p].receiver];
    }
    double worst = 0.0;
    for (Size j = 0; j < receivers_; ++j) {
      if (!(load[j] > 0.0) || moment[j].norm() > inside_asymmetry * weight[j]) continue;
      const double ratio = own[j] / load[j];
      worst = std::max(worst, std::abs(ratio - 1.0));
      scale[j] = std::clamp(scale[j] * ratio, 0.25, 4.0);
    }
    if (worst < balancing_tolerance) break;
  }
  return scale;
}

template <int D>
typename PairWeights<D>::Delivery PairWeights<D>::conservative(const Field& amounts,
                                                               std::span<const double> carried) const {
  const Size components = static_cast<Size>(amounts.components);
  Delivery out;
  out.values.assign(receivers_ * components, 0.0);
  out.given.assign(components, 0.0);
  out.delivered.assign(components, 0.0);
  out.undelivered.assign(components, 0.0);
  const auto scale = balance(amounts);
  // How much of the giving each receiver takes part in: the key by which carried amounts are shared out.
  std::vector<double> part(receivers_, 0.0);
  double parts = 0.0;
  for (Size i = 0; i < target_.size(); ++i) {
    const double* amount = amounts.values.data() + target_order_[i] * components;
    double size = 0.0, total = 0.0;
    for (Size c = 0; c < components; ++c) {
      out.given[c] += amount[c];
      size += std::abs(amount[c]);
    }
    if (size == 0.0) continue;
    for (Index p = first_[i]; p < first_[i + 1]; ++p)
      if (owner_[index_[p]] >= 0) total += weight_[p] * scale[static_cast<Size>(owner_[index_[p]])];
    if (!(total > nothing)) {
      for (Size c = 0; c < components; ++c) out.undelivered[c] += amount[c];
      continue;
    }
    for (Index p = first_[i]; p < first_[i + 1]; ++p) {
      if (owner_[index_[p]] < 0 || weight_[p] == 0.0) continue;
      const Size j = static_cast<Size>(owner_[index_[p]]);
      const double share = weight_[p] * scale[j] / total;
      for (Size c = 0; c < components; ++c) out.values[j * components + c] += share * amount[c];
      part[j] += share * size;
    }
    parts += size;
  }
  for (Size c = 0; c < components; ++c) {
    const double rest = c < carried.size() ? carried[c] : 0.0;
    if (rest == 0.0) continue;
    if (!(parts > 0.0)) {
      out.undelivered[c] += rest;
      continue;
    }
    for (Size j = 0; j < receivers_; ++j) out.values[j * components + c] += rest * part[j] / parts;
  }
  for (Size j = 0; j < receivers_; ++j)
    for (Size c = 0; c < components; ++c) out.delivered[c] += out.values[j * components + c];
  return out;
}

template class PairWeights<2>;
template class PairWeights<3>;

namespace {

template <int D>
class CloudMapping final : public SpatialMapping {
 public:
  Inbox map(Role giver, const PointSet& giver_points, const std::vector<Field>& giver_fields,
            std::span<const FieldSpec> specs, const PointSet& receiver_points) override {
    auto& forward = giver == Role::fluid ? fluid_to_solid_ : solid_to_fluid_;
    auto& backward = giver == Role::fluid ? solid_to_fluid_ : fluid_to_solid_;
    forward.update(giver_points, receiver_points);
    Inbox inbox;
    inbox.coverage = forward.coverage();
    inbox.asymmetry = forward.asymmetry();
    map_consistent(forward, giver_fields, specs, inbox);
    bool ready = false;
    for (const auto& spec : specs) {
      if (spec.mapping != coupling::Mapping::conservative) continue;
      auto& account = account_of(giver, spec);
      const Field& amounts = find(giver_fields, spec.name);
      if (all_zero(amounts.values) && all_zero(account.undelivered)) {
        inbox.fields.push_back(
            {spec.name, spec.components,
             std::vector<double>(receiver_points.n_active * static_cast<Size>(spec.components), 0.0)});
        continue;
      }
      if (!ready) backward.update(receiver_points, giver_points);
      ready = true;
      auto delivery = backward.conservative(amounts, account.undelivered);
      for (Size c = 0; c < delivery.given.size(); ++c) {
        account.given[c] += delivery.given[c];
        account.delivered[c] += delivery.delivered[c];
      }
      account.undelivered = std::move(delivery.undelivered);
      inbox.fields.push_back({spec.name, spec.components, std::move(delivery.values)});
    }
    return inbox;
  }

  MappingCounts counts() const override {
    const auto &a = fluid_to_solid_.counts(), &b = solid_to_fluid_.counts();
    return {a.rebuilds + b.rebuilds, a.reuses + b.reuses, a.unchanged + b.unchanged};
  }
  const std::vector<Account>& accounts() const override { return accounts_; }
  void set_accounts(std::vector<Account> accounts) override { accounts_ = std::move(accounts); }
  void archive(Archive& archive) override { archive(fluid_to_solid_, solid_to_fluid_, accounts_); }

 private:
  static bool is_fraction(std::string_view name) {
    return name == field::soil_fraction || name == field::solid_volume_fraction;
  }
  static bool all_zero(const std::vector<double>& values) {
    return std::all_of(values.begin(), values.end(), [](double v) { return v == 0.0; });
  }

  static const Field& find(const std::vector<Field>& fields, const std::string& name) {
    const auto found = std::find_if(fields.begin(), fields.end(), [&](const Field& f) { return f.name == name; });
    if (found == fields.end()) throw PeerError("field '" + name + "' is missing from the publication to be mapped");
    return *found;
  }

  /// Fields with one mask share their moments: one pass per mask.
  static void map_consistent(const PairWeights<D>& pairs, const std::vector<Field>& fields,
                             std::span<const FieldSpec> specs, Inbox& inbox) {
    std::vector<std::string> masks;
    for (const auto& spec : specs)
      if (spec.mapping == coupling::Mapping::consistent &&
          std::find(masks.begin(), masks.end(), spec.mask) == masks.end())
        masks.push_back(spec.mask);
    for (const auto& mask : masks) {
      std::vector<const Field*> group;
      for (const auto& spec : specs)
        if (spec.mapping == coupling::Mapping::consistent && spec.mask == mask)
          group.push_back(&find(fields, spec.name));
      std::span<const double> weights;
      if (!mask.empty()) weights = find(fields, mask).values;
      for (auto& mapped : pairs.consistent(group, weights)) {
        // A mean of fractions may leave [0, 1] by a rounding; nobody should have to think of that.
        if (is_fraction(mapped.name))
          for (auto& value : mapped.values) value = std::clamp(value, 0.0, 1.0);
        inbox.fields.push_back(std::move(mapped));
      }
    }
  }

  Account& account_of(Role giver, const FieldSpec& spec) {
    for (auto& account : accounts_)
      if (account.giver == giver && account.field == spec.name) return account;
    const std::vector<double> zero(static_cast<Size>(spec.components), 0.0);
    accounts_.push_back({spec.name, spec.unit, giver, zero, zero, zero});
    return accounts_.back();
  }

  PairWeights<D> fluid_to_solid_, solid_to_fluid_;
  std::vector<Account> accounts_;
};

}  // namespace

std::unique_ptr<SpatialMapping> make_mapping(int dimension) {
  if (dimension == 2) return std::make_unique<CloudMapping<2>>();
  if (dimension == 3) return std::make_unique<CloudMapping<3>>();
  throw Error(ExitCode::bad_case, "mapping: expected dimension 2 or 3, got " + std::to_string(dimension));
}

}  // namespace poretwin::coupling
