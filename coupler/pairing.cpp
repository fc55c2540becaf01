#include "coupler/pairing.hpp"

#include "common/particles/neighbours.hpp"

#include <algorithm>

namespace poretwin::coupling {
namespace {

using Size = std::size_t;
using Partners = std::vector<Index>;

constexpr Index nobody = static_cast<Index>(-1);
/// Largest distance, in smoothing lengths, of two points that count as the same particle. Rounding and the initial
/// settlement move a point by far less; the distance between particles is most of a smoothing length.
constexpr double close = 0.2;

template <int D>
VecArray<D> active(const PointSet& set) {
  VecArray<D> points(set.n_active);
  for (Size i = 0; i < points.size(); ++i) points[i] = Eigen::Map<const Vec<D>>(set.position.data() + i * D);
  return points;
}

template <int D>
class PairedMapping final : public SpatialMapping {
 public:
  Inbox map(Role giver, const PointSet& giver_points, const std::vector<Field>& giver_fields,
            std::span<const FieldSpec> specs, const PointSet& receiver_points) override {
    const bool from_fluid = giver == Role::fluid;
    if (of_fluid_.empty())
      find_partners(from_fluid ? giver_points : receiver_points, from_fluid ? receiver_points : giver_points);
    const Partners& partner = from_fluid ? of_solid_ : of_fluid_;
    const auto shared_out = [](const FieldSpec& spec) { return spec.mapping == coupling::Mapping::conservative; };
    if (!same_ || partner.size() != receiver_points.n_active || std::any_of(specs.begin(), specs.end(), shared_out))
      return clouds_->map(giver, giver_points, giver_fields, specs, receiver_points);
    ++mapped_;
    Inbox inbox;
    inbox.coverage.assign(partner.size(), 1.0);
    inbox.asymmetry.assign(partner.size(), 0.0);
    inbox.spread.assign(partner.size(), 1.0);
    for (const auto& spec : specs) {
      const Field& field = field_named(giver_fields, spec.name);
      const auto components = static_cast<Size>(spec.components);
      Field out{spec.name, spec.components, ScalarArray(partner.size() * components)};
      for (Size i = 0; i < partner.size(); ++i)
        for (Size c = 0; c < components; ++c)
          out.values[i * components + c] = field.values[partner[i] * components + c];
      inbox.fields.push_back(std::move(out));
    }
    return inbox;
  }

  MappingCounts counts() const override {
    MappingCounts counts = clouds_->counts();
    counts.reuses += mapped_;
    return counts;
  }
  const std::vector<Account>& accounts() const override { return clouds_->accounts(); }
  void set_accounts(std::vector<Account> accounts) override { clouds_->set_accounts(std::move(accounts)); }
  void archive(Archive& archive) override { archive(*clouds_, of_fluid_, of_solid_, same_); }

 private:
  void find_partners(const PointSet& fluid, const PointSet& solid) {
    const auto waters = active<D>(fluid), soils = active<D>(solid);
    of_fluid_.assign(waters.size(), nobody);
    of_solid_.assign(soils.size(), nobody);
    if (waters.empty() || soils.empty()) return;
    const double length = *std::max_element(fluid.smoothing_length.begin(), fluid.smoothing_length.end());
    sph::CellGrid<D> grid;
    grid.build(waters, length);
    const auto nearest = [&](const Vec<D>& x, double reach) {
      Index found = nobody;
      double least = reach * reach;
      grid.for_each_within(x, reach, [&](Index j, double squared) {
        if (squared >= least) return;
        least = squared;
        found = j;
      });
      return found;
    };
    for (Size i = 0; i < soils.size(); ++i)
      if (const Index j = nearest(soils[i], close * length); j != nobody && of_fluid_[j] == nobody) {
        of_fluid_[j] = static_cast<Index>(i);
        of_solid_[i] = j;
      }
    same_ = std::find(of_fluid_.begin(), of_fluid_.end(), nobody) == of_fluid_.end();
    for (Size i = 0; i < soils.size() && same_; ++i)
      for (double reach = length; of_solid_[i] == nobody; reach *= 2.0) of_solid_[i] = nearest(soils[i], reach);
  }

  std::unique_ptr<SpatialMapping> clouds_ = make_mapping(D);
  Partners of_fluid_, of_solid_;  ///< for each active point, its partner's index in the other set
  bool same_ = false;
  std::uint64_t mapped_ = 0;
};

}  // namespace

std::unique_ptr<SpatialMapping> make_paired_mapping(int dimension) {
  if (dimension == 2) return std::make_unique<PairedMapping<2>>();
  return std::make_unique<PairedMapping<3>>();
}

}  // namespace poretwin::coupling
