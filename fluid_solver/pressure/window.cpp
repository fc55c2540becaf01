#include "fluid_solver/pressure/window.hpp"

#include "common/numerics/aggregates.hpp"
#include "common/numerics/multigrid.hpp"
#include "fluid_solver/discretisation/operators.hpp"
#include "fluid_solver/discretisation/unresolved_pressure.hpp"
#include "fluid_solver/numerics/pressure.hpp"
#include "fluid_solver/pressure/eisph.hpp"
#include "fluid_solver/pressure/soil_edge.hpp"

#include <algorithm>
namespace poretwin::fluid {
namespace {

/// Elimination of v_w' from a particle's two momentum equations over a backward Euler window (docs/theory/coupling.md).
struct Elimination {
  double aw = 0.0;  ///< a = n rho_w / dt, N s/m4; 0 in a problem without inertia
  double C = 0.0;   ///< drag coefficient, N s/m4: the resistance is C (v_w' - v_s') - f, with the explicit part f
  double kf = 0.0;  ///< m4/(N s), flux of the water per pressure gradient while the skeleton is at rest
  double e = 0.0;   ///< 1, flux of the mixture per velocity of the skeleton
};

/// Elimination of v_s' in particles whose skeleton responds. R: mass of the skeleton per bulk volume.
struct Response {
  double as = 0.0;  ///< R / dt, N s/m4
  double ss = 0.0;  ///< m4/(N s), mobility of the skeleton together with the water that it entrains
  double mS = 0.0;  ///< velocity of the skeleton per pressure gradient, m4/(N s)
  double M = 0.0;   ///< Pa, constrained modulus
  bool responds = false;
};

/// aw: n rho_w / dt, N s/m4.
Elimination eliminate(double aw, double n, double n_s, double C) {
  Elimination q;
  q.C = C;
  q.aw = aw;
  q.kf = n * n / (q.aw + C);
  q.e = n_s + n * C / (q.aw + C);
  return q;
}

/// Evaluated on demand; storing one per particle costs more memory traffic than recomputing it.
template <int D>
struct Eliminations {
  const WindowProblem<D>& in;
  const SoilView<D>& soil;
  Elimination operator[](std::size_t a) const {
    const double n = in.void_fraction[a];
    const bool inert = in.inertia && !(in.beds && soil.mask[a] > 0.5);  // in beds water flows by Darcy's law
    const double aw = inert ? n * in.density / in.interval : 0.0;
    return eliminate(aw, n, soil.fraction[a], soil.drag[a]);
  }
};

Response eliminate_skeleton(double dt, double density, double n, double n_s, const Elimination& q, double R, double M) {
  Response r;
  r.as = R / dt;
  r.responds = M > 0.0 && R > pressure::least_responding * density && n_s > 0.0;
  if (!r.responds) return r;
  const double det = q.aw * r.as + q.C * (q.aw + r.as);
  r.mS = (q.C * n + (q.aw + q.C) * n_s) / det;
  r.ss = (q.aw + q.C) / det;
  r.M = M;
  return r;
}

/// Data of a point for the skeleton's stiffness: constrained modulus M and amplification of its parent (both 0 where
/// the parent's skeleton does not respond); stiffness with which dry soil beside the point resists [N s/m].
struct StiffPoint {
  std::array<double, 3> x{};
  [[nodiscard]] const double* row() const { return x.data(); }
  /// Sums of a row: of all weights, of the weights of its own images behind walls that reverse the velocity, and of
  /// those of faces and dry soil.
  template <class In>
  struct Row {
    typename In::Number sum{};
    double turned = 0.0, held;
    explicit Row(const double* self) : held(self[2]) {}
  };
};

/// The operators of one window and their solution.
template <int D>
class WindowSolver {
 public:
  WindowSolver(const Stencil<D>& stencil, const SoilView<D>& soil, std::span<const Surface> flags,
               const WindowProblem<D>& problem)
      : s_(stencil),
        domain_(stencil.domain),
        soil_(soil),
        flags_(flags),
        in_(problem),
        n_(stencil.n_real),
        q_{problem, soil},
        every_row_(domain_.alone() ? 0 : n_, 1) {
    if (in_.response) {
      r_.resize(n_);
      for (std::size_t a = 0; a < n_; ++a) {
        r_[a] = eliminate_skeleton(in_.interval, in_.density, in_.void_fraction[a], soil.fraction[a], q_[a],
                                   soil.density[a], soil.modulus[a]);
        any_response_ = any_response_ || r_[a].responds;
      }
      any_response_ = domain_.any(any_response_);
    }
    if (any_response_) find_moduli();
    find_edge();
    sources_ = make_sources();  // before the matrix: their temporary arrays together with the matrix would need too
                                // much memory
    make_laplacians();
    boundary_.assign(n_, 0.0);
    cavitating_.assign(n_, false);
    open_.assign(n_, 0);
    parallel_for(n_, [&](std::size_t a) {
      const auto faces = from_faces(a, q_[a].kf);
      boundary_[a] = faces.value_or(0.0);
      add_surface(fluid_, a, q_[a].kf, &boundary_[a]);
      open_[a] = faces || flags_[a] != Surface::interior;
    });
    find_closed();
  }

  [[nodiscard]] bool responds(std::size_t a) const { return !r_.empty() && r_[a].responds; }
  /// Constrained modulus of the skeleton at a particle or copy [Pa]; 0: it does not respond.
  void find_moduli() {
    modulus_.assign(s_.n_particles, 0.0);
    for (std::size_t a = 0; a < n_; ++a) modulus_[a] = r_[a].responds ? r_[a].M : 0.0;
    fill_copies(domain_, std::span(modulus_));
  }
  /// What drives the water besides the pressure and the skeleton [N/m3]: its momentum divided by the window's length,
  /// and the explicit part of a quadratic drag.
  [[nodiscard]] Vec<D> push(std::size_t a) const { return q_[a].aw * before(a) + soil_.drag_offset[a]; }
  /// Flux of the water by its momentum and by the explicit drag alone, and the deferred flux [m/s].
  [[nodiscard]] Vec<D> carried(std::size_t a) const {
    return in_.void_fraction[a] / (q_[a].aw + q_[a].C) * push(a) +
           (in_.deferred_flux.empty() ? Vec<D>(Vec<D>::Zero()) : in_.deferred_flux[a]);
  }
  /// Flux of water and skeleton at the window's start [m/s].
  [[nodiscard]] Vec<D> flux_before(std::size_t a) const {
    return in_.void_fraction[a] * before(a) + soil_.fraction[a] * soil_.velocity[a];
  }
  [[nodiscard]] Vec<D> before(std::size_t a) const {
    return in_.velocity.empty() ? Vec<D>(Vec<D>::Zero()) : in_.velocity[a];
  }

  /// out: initial guesses on input, the complete solution on output.
  void solve(WindowSolution<D>& out) {
    out.pressure.resize(n_, 0.0);
    if (!domain_.any(n_ > 0)) return finish(out);
    const bool moves = any_response_ || domain_.any(soil_.velocity.is_allocated());
    if (!moves) out.solid_velocity = {};
    if (moves && !out.solid_velocity.is_allocated()) out.solid_velocity.allocate(n_);
    if (moves)
      parallel_for(n_, [&](std::size_t a) {
        if (!responds(a)) out.solid_velocity.set(a, soil_.velocity[a]);
      });
    if (any_response_) {
      prepare_response();
      start_ = in_.pressure.empty() ? out.pressure : ScalarArray(in_.pressure.begin(), in_.pressure.end());
    }
    // Start from the previous window's cavitating set. Starting from none would first ask the solver to close all
    // voids, and the large pressures of that first solve would set its tolerance.
    if (!in_.void_volume.empty()) {
      std::vector<bool> cavitates(n_);
      for (std::size_t a = 0; a < n_; ++a) cavitates[a] = in_.void_volume[a] > 0.0 && !pinned(a);
      if (domain_.any(cavitates != cavitating_)) fix_cavitating(std::move(cavitates), out);
    }
    for (int round = 1;; ++round) {
      ScalarArray b(n_);
      parallel_for(n_, [&](std::size_t a) { b[a] = sources_[a] + boundary_[a]; });
      if (any_response_)
        solve_response(b, out);
      else
        solve_fluid(std::move(b), out);
      if (!update_cavitating(out) || round == pressure::most_cavitation_rounds) break;
    }
    find_section_flow(out);
    // The matrices are not needed any more; freeing them here lowers the peak of memory.
    for (auto* matrix : {&fluid_, &skeleton_, &plain_}) *matrix = PairMatrix();
    finish(out);
  }

 private:
  /// Right-hand side of every row, from the divergence over the window [m^D/s].
  ScalarArray make_sources() const {
    VecArray<D> flux(n_);
    parallel_for(n_, [&](std::size_t a) { flux[a] = carried(a); });
    ScalarArray sources = divergence<D>(s_, flux, Carried::yes);
    edge_.add_to_divergence(flux, sources);
    if (!edge_.empty()) {
      parallel_for(n_, [&](std::size_t a) { flux[a] = flux_before(a); });
      edge_.add_start(flux, sources);
    }
    if (in_.sweeps > 0) parallel_for(n_, [&](std::size_t a) { sources[a] *= sweep_trust(s_, a); });
    parallel_for(n_, [&](std::size_t a) {
      sources[a] = s_.volume[a] * (in_.source[a] - sources[a]);
      if (!in_.void_volume.empty()) sources[a] -= in_.void_volume[a] / in_.interval;
    });
    return sources;
  }

  /// Finds the edge of soil under free water.
  void find_edge() {
    if (!in_.inertia) return;
    edge_ = SoilEdge<D>(
        s_, soil_, [&](std::size_t a) { return q_[a].kf; }, in_.density / in_.interval,
        [&](std::size_t a) { return responds(a); }, [&](std::size_t a) { return soil_.loose[a] != 0 || is_coarse(a); });
  }
  void conduct_at_edge() {
    edge_.for_pairs([&](std::size_t a, const EdgePair& pair) {
      const double weight = fluid_.weight[pair.k];
      if (weight != 0.0)
        set_weight(a, pair.k,
                   weight * pair.mobility() / harmonic(edge_.mobility(a), edge_.mobility(s_.parent[pair.j])));
    });
    edge_.for_free_pairs([&](std::size_t a, Index k) {
      if (fluid_.weight[k] != 0.0F) set_weight(a, k, static_cast<double>(fluid_.weight[k]) * edge_.conductance(a, k));
    });
  }

  /// Sets the weight of pair k in row a, and adds the change to the diagonal, so that the row's sum remains the same.
  void set_weight(std::size_t a, std::size_t k, double weight) {
    const double before = fluid_.weight[k];
    fluid_.weight[k] = static_cast<float>(weight);
    fluid_.diagonal[a] += fluid_.weight[k] - before;
  }
  /// Makes the Laplacian with the water's mobility and, where a skeleton responds, also those with the skeleton's
  /// mobility and with mobility 1.
  void make_laplacians() {
    ScalarArray mobility(n_), of_skeleton(any_response_ ? n_ : 0);
    parallel_for(n_, [&](std::size_t a) { mobility[a] = q_[a].kf; });
    parallel_for(of_skeleton.size(), [&](std::size_t a) { of_skeleton[a] = r_[a].mS * q_[a].e; });
    if (any_response_) {
      auto matrices = laplacians<D, 3>(s_, {mobility, of_skeleton, {}});
      fluid_ = std::move(matrices[0]);
      skeleton_ = std::move(matrices[1]);
      plain_ = std::move(matrices[2]);
      conduct_at_edge();
    } else if (in_.beds) {
      conduct_in_beds(mobility);
    } else {
      fluid_ = laplacian<D>(s_, mobility);
      conduct_at_edge();
      if (domain_.all(soil_.number.empty())) return;
      find_soils();
      even_out_directions();
      free_along_borders(mobility);
    }
  }

  /// Makes the matrix where soil has beds: between the cells of the particles in the soil, and between these and
  /// particles without cells. Among the latter the weights are those of pairs.
  void conduct_in_beds(const ScalarArray& mobility) {
    if constexpr (D == 2)
      cells_ = BeddedCells<D>(
          s_, in_.walls, *in_.beds, [&](std::size_t a) { return soil_.mask[a] > 0.5 && flags_[a] != Surface::lone; },
          [&](std::size_t a) { return surface_distance(a); });
    const auto all_have_cells = domain_.all_of(n_, [&](std::size_t a) { return cells_.has_cell(a); });
    const PairMatrix pairs = all_have_cells ? PairMatrix() : laplacian<D>(s_, mobility);
    link_offset_.assign(1, 0);
    link_.clear();
    std::vector<float> weights;
    fluid_ = PairMatrix();
    fluid_.diagonal.resize(n_);
    for (std::size_t a = 0; a < n_; ++a) {
      double sum = 0.0;
      const auto add = [&](Index q, float weight) {
        link_.push_back(q);
        weights.push_back(weight);
        sum += static_cast<double>(weight);
      };
      for (const auto& side : cells_.sides(a))
        if (side.other < n_) add(side.other, static_cast<float>(side.shared * harmonic(q_[a].kf, q_[side.other].kf)));
      if (cells_.has_cell(a)) {
        for_faces(a, q_[a].kf, [&](Index, double w, double, Index) { sum += w; });
      } else {
        sum += pairs.diagonal[a];  // with the terms of faces
        for (std::size_t k = pairs.begin(a); k < pairs.end(a); ++k) {
          const Index q = pairs.column(a, k);
          sum -= static_cast<double>(pairs.weight[k]);
          if (!cells_.has_cell(q)) add(q, pairs.weight[k]);
        }
      }
      while (link_.size() % n_lanes != 0) add(static_cast<Index>(a), 0.0F);
      link_offset_.push_back(static_cast<Index>(link_.size()));
      fluid_.diagonal[a] = sum;
    }
    fluid_.weight.resize(weights.size());
    std::copy(weights.begin(), weights.end(), fluid_.weight.begin());
    fluid_.column = {link_offset_, link_, {}, {}};
  }
  /// Pressure [Pa] that the surface has where the cell of particle a ends at it.
  [[nodiscard]] double pressure_beyond(std::size_t a, const typename BeddedCells<D>::Side& surface) const {
    return s_.surface_pressure[a] - in_.weight.dot(s_.position[a] + surface.towards - in_.origin);
  }
  /// The flux that the pressure drives in soil in beds, and the gradient of the pressure.
  void flow_in_beds(WindowSolution<D>& out, VecArray<D>& flux) const {
    if (flux.empty()) {
      flux.resize(n_);
      parallel_for(n_, [&](std::size_t a) { flux[a] = q_[a].kf * out.gradient[a]; });
    }
    const auto& p = out.pressure;
    const ScalarArray slopes = face_slopes<D>(s_, p, [&](Index c) { return in_.face_pressure[c]; });
    parallel_for(n_, [&](std::size_t a) {
      if (!cells_.has_cell(a)) {
        if (soil_.mask[a] > 0.5) flux[a] = *in_.beds * flux[a];
        return;
      }
      Vec<D> sum = Vec<D>::Zero();
      for (const auto& side : cells_.sides(a)) {
        double difference = 0.0, mobility = q_[a].kf;
        const Index q = side.other;
        if (q == BeddedCells<D>::Side::surface) {
          difference = p[a] - pressure_beyond(a, side);
        } else if (q < n_) {
          difference = p[a] - p[q];
          mobility = harmonic(mobility, q_[q].kf);
        } else {
          // As in pressure_gradient(): a reflection would magnify the error of a particle that lies on the face itself.
          const auto& b = s_.buffers[q - s_.n_particles];
          difference = s_.has_slope(b.column) ? p[a] - in_.face_pressure[b.column] + slopes[b.column] * b.outside
                                              : s_.reflection(a, q) * (p[a] - pressure_at_face(a, b));
        }
        sum += mobility * side.conductance * difference * side.middle;
      }
      const Vec<D> own = cells_.flux(a, sum);
      flux[a] = -own;
      out.gradient[a] = cells_.gradient(own, q_[a].kf);
    });
  }

  /// Finds the soils of the particles and of the copies.
  void find_soils() {
    number_.assign(soil_.number.begin(), soil_.number.end());
    number_.resize(s_.n_particles);
    fill_copies(domain_, std::span(number_));
  }

  /// Corrects the conduction between points in soil that lie closer in one direction than in others, as behind a border
  /// of two porosities, where the flow changes its speed. Amplification makes the second moment of the pairs exact only
  /// on average over all directions: along the stretch too little is conducted (2.0 % at a ratio of 4/3).
  ///
  /// Pairs are scaled by 1 + e.S e with their direction e and the mean S of both particles. S = -(D + 2)/2 times the
  /// deviator of the moment cancels the error, given the mean of e e e e over all directions. S is zero within reach of
  /// another soil or a face: volumes change abruptly there, and buffers stand in rows of their own.
  void even_out_directions() {
    constexpr double most = pressure::most_stretched;
    stretch_.assign(s_.n_particles, Mat<D>::Zero());
    parallel_for(n_, [&](std::size_t a) {
      if (number_[a] < 0.0 || flags_[a] != Surface::interior || surface_distance(a) > 0.0) return;
      for (Index k = s_.offset[a]; k < s_.offset[a + 1]; ++k) {
        const Index q = s_.parent[s_.other[k]];
        if (q >= s_.n_particles || number_[q] != number_[a]) return;
      }
      const Mat<D> moment = s_.moment(a);
      const double mean = moment.trace() / D;
      if (mean <= pressure::even_from) return;
      stretch_[a] = -0.5 * (D + 2) * (moment / mean - Mat<D>::Identity());
      const double size = stretch_[a].norm();
      if (size > most) stretch_[a] *= most / size;
    });
    fill_copies(domain_, std::span(stretch_));
    parallel_for(n_, [&](std::size_t a) {
      if (number_[a] < 0.0) return;
      for (Index k = s_.offset[a]; k < s_.offset[a + 1]; ++k) {
        const Index j = s_.other[k], q = s_.parent[j];
        if (q >= s_.n_particles || fluid_.weight[k] == 0.0F) continue;
        set_weight(a, k, static_cast<double>(fluid_.weight[k]) * stretched(a, j, q));
      }
    });
  }
  /// Factor on the pair of particle a and point j with parent q.
  [[nodiscard]] double stretched(std::size_t a, Index j, Index q) const {
    const Vec<D> ba = s_.position[j] - s_.position[a];
    const Vec<D> theirs = j < s_.n_base ? ba : Vec<D>(s_.map[j - s_.n_base].transpose() * ba);
    const auto along = [&](std::size_t i, const Vec<D>& r) { return r.dot(stretch_[i] * r); };
    return 1.0 + 0.5 * (along(a, ba) + along(q, theirs)) / ba.squaredNorm();
  }

  /// Corrects the conduction along borders between soils. The harmonic mean of a pair's mobilities is right across a
  /// border. Along it, the rows beside it lose mobility (that of a third of a spacing) in the more permeable soil and
  /// gain as much in the other: a lens would act as if it were thicker, a drain as if it were thinner.
  ///
  /// Pairs within each soil are scaled by 1 + s (t^2 - q n^2), with the components n and t of their unit vector across
  /// and along the border. q (`still`) leaves the flux across the border unchanged. s is the mean of both particles'
  /// values, and gives the flux along the border the mobility of the soil itself.
  void free_along_borders(std::span<const double> own_mobility) {
    const double first = domain_.max(n_ == 0 ? -1.0 : number_[0]);
    if (domain_.all_of(n_, [&](std::size_t a) { return number_[a] == first; })) return;
    constexpr double still = (D - 1) / 3.0;  // mean of t^2 n^2 over that of n^4
    constexpr double least = -pressure::most_stretched, most = pressure::most_stretched / still;
    const auto mobility = s_.with_copies(own_mobility);
    const std::size_t count = s_.n_particles;
    VecArray<D> across(count, Vec<D>::Zero());
    ScalarArray lacks(n_, 0.0), scale(count, 0.0), next(count, 0.0);
    const auto within = [&](std::size_t a, Index q) { return q < count && number_[q] == number_[a]; };
    parallel_for(n_, [&](std::size_t a) {
      if (number_[a] < 0.0) return;
      Mat<D> missing = Mat<D>::Zero();
      for (Index k = s_.offset[a]; k < s_.offset[a + 1]; ++k) {
        const Index j = s_.other[k], q = s_.parent[j];
        if (q >= count || number_[q] < 0.0 || number_[q] == number_[a] || mobility[q] == mobility[a]) continue;
        const Vec<D> ba = s_.position[j] - s_.position[a], w = static_cast<double>(s_.gradient_factor[k]) * ba;
        across[a] += (mobility[q] - mobility[a]) * w;
        missing += (1.0 - harmonic(1.0, mobility[q] / mobility[a])) * w * ba.transpose();
      }
      if (across[a].isZero(0.0)) return;
      across[a].normalize();
      lacks[a] = missing.trace() - across[a].dot(missing * across[a]);
    });
    fill_copies(domain_, std::span(across));
    // t^2 - q n^2 of a pair at distance ba, with the normal n of the border at one of its particles.
    const auto shape = [&](const Vec<D>& ba, const Vec<D>& n) {
      const double part = n.dot(ba), square = part * part / ba.squaredNorm();
      return 1.0 - square - still * square;
    };
    const auto normal_at = [&](Index j, Index q) {
      return j < s_.n_base ? across[q] : Vec<D>(s_.map[j - s_.n_base] * across[q]);
    };
    for (int round = 0; round < pressure::border_rounds; ++round) {
      parallel_for(n_, [&](std::size_t a) {
        if (across[a].isZero(0.0)) return;
        double own = 0.0, others = 0.0;
        for (Index k = s_.offset[a]; k < s_.offset[a + 1]; ++k) {
          const Index j = s_.other[k], q = s_.parent[j];
          if (j == a || !within(a, q)) continue;
          const Vec<D> ba = s_.position[j] - s_.position[a];
          const double part = across[a].dot(ba), along = 0.5 * s_.gradient_factor[k] * (ba.squaredNorm() - part * part);
          own += along * shape(ba, across[a]);
          if (scale[q] != 0.0) others += along * scale[q] * shape(ba, normal_at(j, q));
        }
        next[a] = own > 0.0 ? std::clamp(0.5 * (scale[a] + (lacks[a] - others) / own), least, most) : 0.0;
      });
      scale = next;
      fill_copies(domain_, std::span(scale));
    }
    parallel_for(n_, [&](std::size_t a) {
      if (number_[a] < 0.0) return;
      for (Index k = s_.offset[a]; k < s_.offset[a + 1]; ++k) {
        const Index j = s_.other[k], q = s_.parent[j];
        if (fluid_.weight[k] == 0.0F || q == a || !within(a, q) || (scale[a] == 0.0 && scale[q] == 0.0)) continue;
        const Vec<D> ba = s_.position[j] - s_.position[a];
        double changed = 1.0;
        if (scale[a] != 0.0) changed += 0.5 * scale[a] * shape(ba, across[a]);
        if (scale[q] != 0.0) changed += 0.5 * scale[q] * shape(ba, normal_at(j, q));
        set_weight(a, k, changed * static_cast<double>(fluid_.weight[k]));
      }
    });
  }

  /// Updates the set of cavitating particles; returns whether it has changed. Water cavitates instead of sustaining a
  /// pressure below the cavitation pressure. At the window's end, neither the excess over that pressure nor the void
  /// volume is negative, and at least one is zero (complementarity). An active set solves this: cavitating particles
  /// have a fixed pressure, and the residual of their continuity equation is the rate at which voids open.
  bool update_cavitating(WindowSolution<D>& out) {
    const auto below = [&](std::size_t a) {
      return out.pressure[a] < cavitation_pressure(a) + pressure::cavitation_tolerance * in_.cavitation && !pinned(a);
    };
    out.void_volume = {};
    if (!any_cavitating_ && domain_.all_of(n_, [&](std::size_t a) { return !below(a); })) return false;
    out.void_volume.allocate(n_);
    std::vector<bool> cavitates(n_);
    for (std::size_t a = 0; a < n_; ++a) cavitates[a] = below(a);
    if (any_cavitating_) {
      const ScalarArray missed = imbalance(sources_, free_boundary_, out);
      for (std::size_t a = 0; a < n_; ++a) {
        if (!cavitating_[a]) continue;
        const double opening = (free_diagonal_[a] - fluid_.diagonal[a]) * out.pressure[a] - missed[a];
        cavitates[a] = opening > pressure::cavitation_tolerance * std::abs(in_.cavitation) * free_diagonal_[a];
        out.void_volume.set(a, std::max(0.0, in_.interval * opening));
      }
    }
    if (domain_.all(cavitates == cavitating_)) return false;
    fix_cavitating(std::move(cavitates), out);
    return true;
  }
  /// Fixes the pressure of these rows at the cavitation pressure, and releases all others.
  void fix_cavitating(std::vector<bool> cavitates, WindowSolution<D>& out) {
    if (free_diagonal_.empty()) {
      free_diagonal_ = fluid_.diagonal;
      free_boundary_ = boundary_;
    }
    cavitating_ = std::move(cavitates);
    any_cavitating_ = domain_.any(std::find(cavitating_.begin(), cavitating_.end(), true) != cavitating_.end());
    find_closed();
    fluid_.diagonal = free_diagonal_;
    boundary_ = free_boundary_;
    for (std::size_t a = 0; a < n_; ++a) {
      if (!cavitating_[a]) continue;
      const double h = s_.length(a),
                   weight = pressure::cavitating_weight * (fluid_.diagonal[a] + s_.volume[a] * q_[a].kf / (h * h));
      fluid_.diagonal[a] += weight;
      boundary_[a] += weight * cavitation_pressure(a);
      out.pressure[a] = cavitation_pressure(a);
    }
  }

  /// Residual of the continuity equation [m^D/s].
  ScalarArray imbalance(std::span<const double> sources, std::span<const double> boundary,
                        const WindowSolution<D>& out) const {
    ScalarArray row(n_), rest(n_);
    fluid_.apply(s_.template with_copies<double>(out.pressure), std::span<double>(row));
    const ScalarArray squeeze = squeezed(out.solid_velocity);
    for (std::size_t a = 0; a < n_; ++a) rest[a] = sources[a] + boundary[a] - row[a] - squeeze[a];
    if (any_response_ && (any_cavitating_ || domain_.any(!in_.pressure.empty()))) {
      ScalarArray change(n_);
      for (std::size_t a = 0; a < n_; ++a) change[a] = out.pressure[a] - start_[a];
      const ScalarArray held_back = stabilised(change);
      for (std::size_t a = 0; a < n_; ++a) rest[a] -= held_back[a];
    }
    stabilise_flow(start_, rest);
    return rest;
  }

  /// Stabilisation for a change of pressure, times the volume (docs/theory/water.md): st (Lp + D.G), the Laplacian
  /// minus the wide Laplacian; in water of moving soil st S(p), which is zero for linear pressures. st: stabilisation_.
  ScalarArray stabilised(std::span<const double> change) const {
    return stabilised(change, plain_gradient(change, true));
  }
  ScalarArray stabilised(std::span<const double> change, std::span<const Vec<D>> gradient) const {
    ScalarArray result(n_);
    plain_.apply(s_.template with_copies<double>(change), std::span<double>(result));
    const ScalarArray wide = divergence<D>(s_, gradient);
    for (std::size_t a = 0; a < n_; ++a) result[a] = stabilisation_[a] * (result[a] + s_.volume[a] * wide[a]);
    if (unresolved_.empty()) return result;
    const ScalarArray alternating = unresolved_(change);
    for (std::size_t a = 0; a < n_; ++a)
      if (in_.in_seepage[a] == 0) result[a] = stabilisation_[a] * alternating[a];
    return result;
  }
  double cavitation_pressure(std::size_t a) const {
    return in_.cavitation - in_.weight.dot(s_.position[a] - in_.origin);
  }

  /// Piezometric pressure [Pa] of the face in front of a buffer, for particle a.
  [[nodiscard]] double pressure_at_face(std::size_t a, const Buffer<D>& b) const {
    // Where water leaves soil at rest, a row that has passed the face continues the pressure's slope at the face.
    const double beyond = std::min(0.0, b.inside(s_.position[a]));
    const double slope = any_response_ ? 0.0 : std::max(0.0, in_.face_slope[b.column]);
    return in_.face_pressure[b.column] + beyond * slope;
  }

  /// Calls take(column, weight, pressure, buffer) for every term weight (p - pressure) that faces add to row a of a
  /// Laplacian with this mobility. buffer: index of the buffer particle for which the term stands.
  template <class Take>
  void for_faces(std::size_t a, double mobility, const Take& take) const {
    if (cells_.has_cell(a)) {
      for (const auto& side : cells_.sides(a)) {
        const Index q = side.other;
        if (q < n_ || q == BeddedCells<D>::Side::surface) continue;
        const auto& b = s_.buffers[q - s_.n_particles];
        take(b.column, mobility * side.conductance * s_.reflection(a, q), pressure_at_face(a, b), q);
      }
      return;
    }
    for_buffers(a, mobility, take);
  }
  /// for_faces with the weights of pairs, for particles with cells, too.
  template <class Take>
  void for_buffers(std::size_t a, double mobility, const Take& take) const {
    for (Index k = s_.offset[a]; s_.n_base > s_.n_particles && k < s_.offset[a + 1]; ++k) {
      const Index j = s_.other[k], q = s_.parent[j];
      if (j < s_.n_particles || !s_.is_buffer(j)) continue;
      const double w = 2.0 * s_.volume[a] * mobility * s_.gradient_factor[k] * s_.amplified(a, q) * s_.reflection(a, q);
      const auto& b = s_.buffers[q - s_.n_particles];
      take(b.column, w, pressure_at_face(a, b), q);
    }
  }

  /// Sum of the terms of faces on the right-hand side of row a; empty if no face is within reach.
  std::optional<double> from_faces(std::size_t a, double mobility) const {
    std::optional<double> sum;
    for_faces(a, mobility, [&](Index, double w, double pressure, Index) { sum = sum.value_or(0.0) + w * pressure; });
    return sum;
  }

  /// Computes the flow through each column: the sum of the terms with which its pressure enters the rows of the matrix.
  /// Where a surface is within reach of the face, the pairs beyond it are missing and the sum is too small (by 7 %
  /// under a front that has advanced by a few spacings): the flow there is set to NaN.
  void find_face_flow(WindowSolution<D>& out) const {
    const std::size_t count = in_.face_pressure.size();
    out.face_flow.assign(count, 0.0);
    out.face_carry.assign(count, 0.0);
    if (count == 0) return;
    for (std::size_t a = 0; s_.n_base > s_.n_particles && a < n_; ++a) {
      if (cells_.has_cell(a)) {
        add_face_flow_of_cell(a, out);
        continue;
      }
      if (s_.beyond[a] == 0) continue;
      const bool whole = flags_[a] != Surface::lone && !(surface_distance(a) > 0.0);
      // Only columns of the particle's own soil count, since adjacent soils have separate flows.
      double flow = 0.0, all = 0.0, own = 0.0;
      const auto is_own = [&](Index column) {
        return !soil_.number.empty() && in_.face_soil[column] == soil_.number[a];
      };
      for_faces(a, q_[a].kf, [&](Index column, double w, double pressure, Index) {
        flow += w * (pressure - out.pressure[a]);
        all += w;
        if (is_own(column)) own += w;
      });
      for_faces(a, q_[a].kf, [&](Index column, double w, double pressure, Index) {
        if (!whole)
          out.face_flow[column] = std::nan("");
        else if (own == all || own == 0.0)
          out.face_flow[column] += w * (pressure - out.pressure[a]);
        else if (is_own(column))
          out.face_flow[column] += w / own * flow;
      });
    }
    VecArray<D> normal(count, Vec<D>::Zero());
    for (const auto& b : s_.buffers) normal[b.column] = b.normal;
    ScalarArray sum(count, 0.0);
    for (std::size_t c = 0; c < s_.fitted.size(); ++c)
      for (Index k = s_.fit_offset[c]; k < s_.fit_offset[c + 1]; ++k) {
        const Index a = s_.fit_index[k];
        sum[c] += s_.fit_weight[k];
        out.face_carry[c] += s_.fit_weight[k] * in_.void_fraction[a] / (q_[a].aw + q_[a].C) * normal[c].dot(push(a));
      }
    for (auto* of : {&out.face_flow, &out.face_carry, &sum}) domain_.sum(*of);
    for (std::size_t c = 0; c < count; ++c) out.face_carry[c] = sum[c] > 0.0 ? out.face_carry[c] / sum[c] : 0.0;
  }

  /// Adds the flow through the sides of a cell towards buffers. It is divided among the columns of the same straight
  /// piece of the face by the weights of pairs. If each column had the flow through the sides towards its own buffers,
  /// a buffer ahead of others would expose more of its cell, and so get ahead of them further.
  void add_face_flow_of_cell(std::size_t a, WindowSolution<D>& out) const {
    for_faces(a, q_[a].kf, [&](Index column, double w, double pressure, Index q) {
      const Buffer<D>& through = s_.buffers[q - s_.n_particles];
      const auto beside = [&](const Buffer<D>& b) {
        return in_.face_soil[b.column] == in_.face_soil[column] && b.normal.dot(through.normal) > 1.0 - 1e-9 &&
               std::abs(through.normal.dot(b.foot - through.foot)) < 1e-6 * s_.length(a);
      };
      double all = 0.0;
      for_buffers(a, 1.0, [&](Index, double part, double, Index i) {
        all += beside(s_.buffers[i - s_.n_particles]) ? part : 0.0;
      });
      const double flow = w * (pressure - out.pressure[a]);
      if (all == 0.0) out.face_flow[column] += flow;
      for_buffers(a, 1.0, [&](Index other, double part, double, Index i) {
        if (all > 0.0 && beside(s_.buffers[i - s_.n_particles])) out.face_flow[other] += part / all * flow;
      });
    });
  }

  /// Computes the flow through each section. A term of the matrix is a flow from one particle to another along the
  /// straight line between them; flows whose lines cross the section pass it. With them, continuity holds in any part
  /// of the soil (Irving & Kirkwood 1950 define the flow of momentum in this way): as much passes a section as faces on
  /// either side let in. For a sum of the particles' velocities this is not so: beside another soil it depends on the
  /// number of rows of particles in the soil. The flow by inertia is added, in the same form, to the flow that the
  /// pressure drives.
  void find_section_flow(WindowSolution<D>& out) const {
    out.section_flow.assign(in_.sections.size(), 0.0);
    if constexpr (D == 2)
      for (std::size_t i = 0; i < in_.sections.size(); ++i) out.section_flow[i] = flow_through(in_.sections[i], out);
  }
  /// All ranks call this.
  [[nodiscard]] double flow_through(const Section<2>& section, const WindowSolution<D>& out) const {
    const Vec<D> along = section.to - section.from, left(-along[1], along[0]);
    // 1 if the line from x to y crosses the section from right to left, -1 the other way, 0 if it does not cross.
    const auto crossed = [&](const Vec<D>& x, const Vec<D>& y) {
      const double here = left.dot(x - section.from), there = left.dot(y - section.from);
      if ((here < 0.0) == (there < 0.0)) return 0.0;
      const double place = along.dot(x + here / (here - there) * (y - x) - section.from);
      return place < 0.0 || place > along.squaredNorm() ? 0.0 : here < 0.0 ? 1.0 : -1.0;
    };
    VecArray<D> by_inertia(n_);
    parallel_for(n_, [&](std::size_t a) { by_inertia[a] = in_.void_fraction[a] / (q_[a].aw + q_[a].C) * push(a); });
    const auto carried = s_.template with_copies<Vec<D>>(by_inertia);
    const auto pressure = s_.template with_copies<double>(out.pressure);
    const std::size_t n = s_.n_particles;
    double flow = 0.0;
    for (std::size_t a = 0; a < n_; ++a) {
      const Vec<D>& x = s_.position[a];
      const double reach = cells_.empty() ? 2.0 * sph::support_radius * s_.length(a) : HUGE_VAL;
      if (std::abs(left.dot(x - section.from)) > reach * left.norm()) continue;
      const Vec<D>& own = carried[a];
      for (Index k = s_.offset[a]; k < s_.offset[a + 1]; ++k) {
        // An image behind a wall stands for its original, to which the flow goes.
        const Index j = s_.other[k], q = s_.parent[j];
        const double sign = crossed(x, s_.position[q]) * (q < n ? 0.5 : 1.0);  // a pair of particles is met twice
        if (sign == 0.0) continue;
        const Vec<D> theirs = q >= n ? own : j < s_.n_base ? carried[q] : Vec<D>(s_.map[j - s_.n_base] * carried[q]);
        flow +=
            sign * s_.volume[a] * s_.gradient_factor[k] * s_.amplified(a, q) * (own + theirs).dot(s_.position[j] - x);
        if (q < n && cells_.empty()) flow += sign * static_cast<double>(fluid_.weight[k]) * (pressure[a] - pressure[q]);
      }
      for (std::size_t k = fluid_.begin(a); !cells_.empty() && k < fluid_.end(a); ++k)
        flow += 0.5 * crossed(x, s_.position[link_[k]]) * static_cast<double>(fluid_.weight[k]) *
                (out.pressure[a] - out.pressure[link_[k]]);
      if (s_.beyond[a] == 0 && !cells_.has_cell(a)) continue;
      for_faces(a, q_[a].kf, [&](Index, double w, double at_face, Index q) {
        flow += crossed(x, s_.position[q]) * w * (pressure[a] - at_face);
      });
    }
    return domain_.sum(flow);
  }

  /// Distance to the water's surface [m]; 0 if it is out of reach.
  double surface_distance(std::size_t a) const {
    if (s_.ghost_distance[a] > 0.0) return s_.ghost_distance[a];
    return flags_[a] == Surface::surface ? s_.surface_distance(a) : s_.front_distance[a];
  }

  /// Whether the pressure of a particle is prescribed: particles with too few neighbours, and particles at a front in
  /// coarse soil, where inertia dominates. There the weaker condition of a wetting front, without a ghost in the
  /// gradient, would add energy to splashes.
  bool pinned(std::size_t a) const {
    if (flags_[a] == Surface::lone) return true;
    return flags_[a] == Surface::surface && s_.ghost_distance[a] == 0.0 && is_coarse(a);
  }
  /// Whether inertia dominates at a particle: in free water and in coarse soil.
  bool is_coarse(std::size_t a) const {
    return inertia_rules(in_.void_fraction[a], in_.density, q_[a].C, spacing_of<D>(s_.volume[a]),
                         in_.weight.norm() / in_.density);
  }
  double pinned_pressure(std::size_t a) const {
    if (flags_[a] == Surface::lone) return -in_.weight.dot(s_.position[a] - in_.origin);
    return surface_row(s_, a, s_.surface_distance(a), 1.0, in_.weight, in_.origin).pressure;
  }

  bool is_known(std::size_t a) const { return cavitating_[a] || pinned(a); }
  double known_pressure(std::size_t a) const { return cavitating_[a] ? cavitation_pressure(a) : pinned_pressure(a); }

  void add_surface(PairMatrix& m, std::size_t a, double mobility, double* rhs) const {
    SurfaceRow row;
    if (pinned(a)) {
      const double h = s_.length(a);
      row = {pressure::pinned_weight * (m.diagonal[a] + s_.volume[a] * mobility / (h * h)), pinned_pressure(a)};
    } else if (cells_.has_cell(a)) {
      for (const auto& side : cells_.sides(a))
        if (side.other == BeddedCells<D>::Side::surface) row = {mobility * side.conductance, pressure_beyond(a, side)};
    } else if (const double distance = surface_distance(a); distance > 0.0) {
      row = surface_row(s_, a, distance, mobility, in_.weight, in_.origin);
      if (s_.ghost_distance[a] == 0.0) row.coefficient *= s_.amplification[a];
    } else {
      return;
    }
    m.diagonal[a] += row.coefficient;
    if (rhs) *rhs += row.coefficient * row.pressure;
  }

  /// V D(e s): volume times the divergence of e times the skeleton's velocity s [m^D/s].
  template <class Velocity>
  ScalarArray squeezed(const Velocity& s) const {
    VecArray<D> f(n_);
    parallel_for(n_, [&](std::size_t a) { f[a] = q_[a].e * s[a]; });
    ScalarArray d = divergence<D>(s_, f);
    edge_.add_to_divergence(f, d);
    parallel_for(n_, [&](std::size_t a) { d[a] *= s_.volume[a]; });
    return d;
  }

  /// Finds the bodies of water whose mean pressure nothing prescribes.
  void find_closed() {
    const auto body = [&](std::size_t a) { return in_.closed_body.empty() ? 1 : in_.closed_body[a]; };
    const double most = in_.closed_body.empty() ? 1.0 : *std::ranges::max_element(in_.closed_body);
    std::vector<std::vector<std::size_t>> bodies(static_cast<std::size_t>(domain_.max(most)) + 1);
    std::vector<char> open(bodies.size(), 0);
    for (std::size_t a = 0; a < n_; ++a) {
      const auto b = static_cast<std::size_t>(body(a));
      if (open_[a] != 0 || cavitating_[a]) open[b] = 1;
      if (b > 0 && open[b] == 0) bodies[b].push_back(a);
    }
    closed_.clear();
    for (std::size_t b = 1; b < bodies.size(); ++b) {
      const double count = domain_.sum(static_cast<double>(bodies[b].size()));
      if (count > 0.0 && !domain_.any(open[b] != 0)) closed_.push_back({std::move(bodies[b]), count});
    }
    all_closed_ = closed_.size() == 1 && domain_.all(closed_[0].rows.size() == n_);
  }

  /// Subtracts from the values of each closed body their mean, since the matrix is singular there.
  void remove_means(std::span<double> x) const {
    for (const auto& body : closed_) {
      const auto& of = body.rows;
      const double mean = domain_.sum_over(of.size(), [&](std::size_t i) { return x[of[i]]; }) / body.count;
      parallel_for(of.size(), [&](std::size_t i) { x[of[i]] -= mean; });
    }
  }

  void between_iterations() const {
    if (in_.between_iterations != nullptr) in_.between_iterations();
  }

  /// Solves for water with rigid soil, free water, or water with a skeleton of known velocity: one symmetric system.
  void solve_fluid(ScalarArray b, WindowSolution<D>& out) {
    if (domain_.any(out.solid_velocity.is_allocated())) {
      const ScalarArray squeeze = squeezed(out.solid_velocity);
      parallel_for(n_, [&](std::size_t a) { b[a] -= squeeze[a]; });
    }
    const double rounding = 1e-12 * domain_.norm(b);
    // The datum is subtracted, so that the tolerance refers to the pressures that drive flow.
    double reference = 0.0;
    remove_means(b);
    if (!all_closed_) {
      ScalarArray row(n_);
      parallel_for(n_, [&](std::size_t a) { row[a] = fluid_.row_sum(a); });
      const double num = domain_.sum_over(n_, [&](std::size_t a) { return boundary_[a]; });
      const double den = domain_.sum_over(n_, [&](std::size_t a) { return row[a]; });
      reference = den > 0.0 ? num / den : 0.0;
      parallel_for(n_, [&](std::size_t a) { b[a] -= reference * row[a]; });
    }
    parallel_for(
        n_, [&](std::size_t a) { out.pressure[a] = (is_known(a) ? known_pressure(a) : out.pressure[a]) - reference; });
    if (in_.sweeps > 0) {
      ScalarArray relaxation(n_);
      for (std::size_t a = 0; a < n_; ++a) relaxation[a] = relaxation_in(in_.interval_over_proposed, q_[a].aw, q_[a].C);
      relaxed_sweeps(fluid_, b, relaxation, out.pressure, in_.sweeps);
      out.pressure_iterations += in_.sweeps;
      for (auto& p : out.pressure) p += reference;
      return;
    }
    // If all pressures are fixed or equal, nothing drives flow: rounding is then the lower bound of the tolerance.
    const double tolerance = std::max(in_.tolerance * drive(b, reference), rounding);
    const auto apply = [&](std::span<const double> x, std::span<double> y) {
      between_iterations();
      fluid_.apply(x, y);
    };
    SolveReport report;
    report.converged = false;
    if (!out.multigrid) {
      ScalarArray inverse(n_);
      parallel_for(n_, [&](std::size_t a) { inverse[a] = fluid_.diagonal[a] > 0.0 ? 1.0 / fluid_.diagonal[a] : 0.0; });
      std::optional<Aggregates<D>> aggregates;
      int calls = 0;
      const auto by_diagonal = [&](std::span<const double> r, std::span<double> z) {
        parallel_for(n_, [&](std::size_t a) { z[a] = inverse[a] * r[a]; });
        if (calls++ == pressure::iterations_without_aggregates) aggregates.emplace(pressure_aggregates());
        if (aggregates) aggregates->template correct<1>(r, z);
        remove_means(z);
      };
      report = conjugate_gradients(domain_, apply, by_diagonal, b, out.pressure, tolerance, pressure::patience);
      out.pressure_iterations += report.iterations;
      out.multigrid = !report.converged;
    }
    if (!report.converged) {
      // Each rank makes its own, as with aggregates.
      const bool shared = !domain_.alone();
      const PairMatrix own = shared ? among_real(fluid_) : PairMatrix();
      std::optional<Multigrid> multigrid;
      if (n_ > 0) multigrid.emplace(shared ? own : fluid_);
      const auto by_cycle = [&](std::span<const double> r, std::span<double> z) {
        if (multigrid) multigrid->cycle(r, z);
        remove_means(z);
      };
      report = conjugate_gradients(domain_, apply, by_cycle, b, out.pressure, tolerance, 2000);
      out.multigrid_cycles += report.iterations;
      out.multigrid = report.iterations > pressure::few_cycles;
    }
    out.converged = report.converged;
    out.in_doubt = !report.converged &&
                   report.residual > std::max(1.0, pressure::free_water_tolerance / in_.tolerance) * tolerance;
    out.outer = 1;
    parallel_for(n_, [&](std::size_t a) { out.pressure[a] += reference; });
  }

  /// Aggregates for the pressure, as many as each has particles: then solving the coarse system takes about as long as
  /// summing over aggregates.
  Aggregates<D> pressure_aggregates() const {
    // Each rank makes its own, since they only speed up the solve.
    const double whole = one_rank::sum_over(n_, [&](std::size_t a) { return s_.volume[a]; });
    Aggregates<D> aggregates(std::span<const Vec<D>>(s_.position).first(n_),
                             spacing_of<D>(whole / std::sqrt(static_cast<double>(n_))),
                             [&](std::size_t a) { return !is_known(a) && fluid_.diagonal[a] > 0.0; });
    // Where nothing prescribes the mean pressure the matrix is singular: a small value is added to its diagonal.
    aggregates.factorise([&](std::size_t a, const auto& add) {
      add(a, (1.0 + pressure::regularisation) * fluid_.diagonal[a]);
      for (std::size_t k = fluid_.begin(a); k < fluid_.end(a); ++k)
        if (const Index b = fluid_.column(a, k); b < n_) add(b, -static_cast<double>(fluid_.weight[k]));
    });
    return aggregates;
  }
  /// A matrix without the weights of copies, which stay in its diagonal: as if their values were zero.
  PairMatrix among_real(const PairMatrix& matrix) const {
    PairMatrix own = matrix;
    for (std::size_t a = 0; a < n_; ++a)
      for (std::size_t k = own.begin(a); k < own.end(a); ++k)
        if (matrix.column(a, k) >= n_) own.weight[k] = 0.0F;
    own.column.count = n_;
    own.column.beyond = every_row_;
    return own;
  }

  /// Drive of the flow, to which the tolerance refers: the norm of the residual when prescribed pressures are in place
  /// and all other pressures are at the datum.
  double drive(const ScalarArray& b, double reference) const {
    const auto is_unknown = [&](std::size_t a) { return !is_known(a); };
    if (domain_.all_of(n_, is_unknown)) return domain_.norm(b);
    ScalarArray known(n_), residual(n_);
    parallel_for(n_, [&](std::size_t a) { known[a] = is_known(a) ? known_pressure(a) - reference : 0.0; });
    fluid_.apply(s_.template with_copies<double>(known), std::span<double>(residual));
    parallel_for(n_, [&](std::size_t a) { residual[a] = is_known(a) ? 0.0 : b[a] - residual[a]; });
    return domain_.norm(residual);
  }

  void prepare_response() {
    const double dt = in_.interval;
    storage_.assign(n_, 0.0);
    stabilisation_.assign(n_, 0.0);
    for (std::size_t a = 0; a < n_; ++a) {
      const auto& r = r_[a];
      if (!r.responds) continue;
      const double dx2 = std::pow(s_.volume[a], 2.0 / D), e = q_[a].e;
      stabilisation_[a] = 1.0 / (r.ss / (r.mS * r.mS) + dt * r.M * 4.0 / dx2);
      storage_[a] = s_.volume[a] * e * e / (dt * r.M);
    }
    // Vectors change at a reflection, so that each image needs a weight of its own.
    build_vector_stiffness();
    // The solve for the skeleton's velocity may end once the power e.H e of its error e is at most the squared
    // tolerance times the power of `dragged`, the change of velocity that drag would cause without any stiffness.
    const double power = domain_.sum_over(n_, [&](std::size_t a) {
      if (!responds(a)) return 0.0;
      const Vec<D> dragged = (1.0 - r_[a].as * r_[a].ss) * (before(a) - soil_.velocity[a]);
      return s_.volume[a] / r_[a].ss * dragged.squaredNorm();
    });
    negligible_power_ = pressure::skeleton_tolerance * pressure::skeleton_tolerance * power;
    prepare_flow();
    for (std::size_t a = 0; a < n_; ++a)
      if (responds(a)) add_surface(skeleton_, a, r_[a].mS * q_[a].e, nullptr);
    for (std::size_t a = 0; a < n_; ++a) add_surface(plain_, a, 1.0, nullptr);
    if (domain_.any(std::find(in_.in_seepage.begin(), in_.in_seepage.end(), char{0}) != in_.in_seepage.end()))
      unresolved_ = UnresolvedPressure<D>(s_, plain_);
  }

  void build_vector_stiffness() {
    const double dt = in_.interval;
    image_weight_.assign(s_.other.size(), 0.0F);
    H_diagonal_.assign(n_, 1.0);
    ScalarArray preconditioner(n_, 1.0);
    std::vector<StiffPoint> points(s_.size());
    for (std::size_t j = 0; j < s_.size(); ++j)
      if (const Index b = s_.parent[j]; b < s_.n_particles && modulus_[b] > 0.0)
        points[j].x = {modulus_[b], s_.amplification[b], j < n_ ? dry_skeleton_stiffness(j) : 0.0};
    const bool buffers = s_.n_base > s_.n_particles;
    for_pairs<StiffPoint::Row>(
        s_.rows(), PairInputs{points.data()},
        [&](const auto& pair, auto& own) __attribute__((always_inline)) {
          const std::size_t a = pair.i;
          if (!responds(a)) return;
          NumberOf<decltype(pair)> M, amplification, w;
          gather_one(pair.rows(), 0, M);
          gather_one(pair.rows(), 1, amplification);
          take(&s_.gradient_factor[pair.m], w);
          w *= s_.volume[a] * dt * (pair.self[1] + amplification) * (2.0 * pair.self[0] * M / (pair.self[0] + M));
          put(w, &image_weight_[pair.m]);
          take(&image_weight_[pair.m], w);  // as stored, so that the skeleton can move as a whole without force
          own.sum += w;
          pair.for_each([&](Index j, std::size_t k) {
            const Index b = s_.parent[j];
            if (b == a) own.turned += static_cast<double>(image_weight_[k]);
            if (buffers && b >= s_.n_particles && in_.face_holds[s_.buffers[b - s_.n_particles].column])
              own.held += 2.0 * s_.volume[a] * dt * r_[a].M * static_cast<double>(s_.gradient_factor[k]) *
                          s_.amplified(a, b) * s_.reflection(a, b);
          });
        },
        [&](std::size_t a, const auto& own) __attribute__((always_inline)) {
          if (!responds(a)) return;
          H_diagonal_[a] = s_.volume[a] / r_[a].ss;
          H_diagonal_[a] += sum_of_lanes(own.sum) + own.held;
          preconditioner[a] = H_diagonal_[a] - own.turned;
          if (edge_.presses(a)) preconditioner[a] += inertia_at_edge(a) * edge_.push(a) / D;
        });
    double spacing = 0.0;
    for (std::size_t a = 0; a < n_; ++a)
      if (responds(a)) spacing = std::max(spacing, spacing_of<D>(s_.volume[a]));
    spacing = domain_.max(spacing);
    aggregates_.emplace(std::span<const Vec<D>>(s_.position).first(n_), pressure::aggregate_width * spacing,
                        [&](std::size_t a) { return responds(a); });
    aggregates_->factorise([&](std::size_t a, const auto& add) {
      add(a, preconditioner[a]);
      for (Index k = s_.offset[a]; k < s_.offset[a + 1]; ++k)
        if (const Index b = s_.parent[s_.other[k]]; b != a && b < n_) add(b, -static_cast<double>(image_weight_[k]));
    });
    H_inverse_.resize(n_);
    for (std::size_t a = 0; a < n_; ++a) H_inverse_[a] = 1.0 / preconditioner[a];
  }

  /// Computes the force on every particle [N] that cancels the stiffness of the present motion. Where soil yields, its
  /// present shear continues at constant stress, and stiffness may resist only a departure from the present motion.
  /// Without this force, yielding soil would flow like a liquid of viscosity Dt M.
  void prepare_flow() {
    flow_.assign(n_, Vec<D>::Zero());
    // In a repeated window, stiffness resists only a departure from the last pass's velocity, whose force is known.
    if (domain_.any(soil_.found_velocity.is_allocated())) {
      const ScalarArray held = apply_H(soil_.found_velocity.values());
      for (std::size_t a = 0; a < n_; ++a)
        if (responds(a))
          flow_[a] = Eigen::Map<const Vec<D>>(held.data() + a * D) - s_.volume[a] / r_[a].ss * soil_.found_velocity[a] -
                     pushed_back(a, soil_.found_velocity[a]);
      return;
    }
    for (std::size_t a = 0; a < n_; ++a) flow_[a] = dry_skeleton_stiffness(a) * soil_.velocity[a];
    if (domain_.all(std::all_of(soil_.plastic_shear_ratio.begin(), soil_.plastic_shear_ratio.end(),
                                [](double y) { return y <= 0.0; })))
      return;
    const VecArray<D> going = skeleton_extended(soil_.velocity.values());
    const auto yielding = s_.template with_copies<double>(soil_.plastic_shear_ratio.values());
    for (std::size_t a = 0; a < n_; ++a)
      for (Index k = s_.offset[a]; k < s_.offset[a + 1]; ++k) {
        if (image_weight_[k] == 0.0F) continue;
        const Index j = s_.other[k];
        const double share = 0.5 * (yielding[a] + yielding[s_.parent[j]]);
        if (share > 0.0) flow_[a] += share * static_cast<double>(image_weight_[k]) * (going[a] - going[j]);
      }
  }

  /// Subtracts the stabilisation of the whole pressure from the residual, in water of moving soil. Elsewhere the
  /// stabilisation acts only on the change of pressure in the window, since consolidation damps the modes of pressure
  /// that the wide gradient does not see. In short windows of moving soil nothing damps them: there it acts on the
  /// whole pressure, as in free water, whose projection is compact.
  void stabilise_flow(const ScalarArray& pressure, ScalarArray& residual) const {
    if (unresolved_.empty()) return;
    const ScalarArray alternating = unresolved_(pressure);
    for (std::size_t a = 0; a < n_; ++a)
      if (in_.in_seepage[a] == 0) residual[a] -= stabilisation_[a] * alternating[a];
  }

  /// A velocity of the skeleton, extended to all points; it is reversed behind walls that fix the soil.
  VecArray<D> skeleton_extended(std::span<const Vec<D>> f) const {
    return extended<D>(s_, f, Carried::no, in_.fixed_soil);
  }

  /// Stiffness [N s/m] of the Robin condition for the resistance of the dry soil beyond a wetting front against the wet
  /// skeleton: traction Dt M (s - v_s) / distance.
  ///
  /// The dry soil is assumed to keep its velocity v_s at that distance. Beside the front, it is half a spacing (a small
  /// wet zone is supported over its own width, Saint-Venant); above the front, the distance that a compression wave
  /// travels in the window. A column of wet soil of length L below dry soil responds to a load with rho c tanh(L / (c
  /// Dt)). The stiffness is within 5 % of that from 10 ms to 1 s.
  double dry_skeleton_stiffness(std::size_t a) const {
    if (!responds(a) || flags_[a] == Surface::interior || soil_.mask[a] < 0.5) return 0.0;
    const double spacing = spacing_of<D>(s_.volume[a]);
    const double amount = std::max(s_.normal[a].norm(), flags_[a] == Surface::lone ? 1.0 / spacing : 0.0);
    const double up = std::max(0.0, in_.weight.dot(s_.normal[a]) / (in_.weight.norm() * s_.normal[a].norm() + 1e-300));
    const double beside = 0.5 * spacing;
    const double above = std::max(beside, in_.interval * std::sqrt(r_[a].M / soil_.density[a]));
    const double per_length = (1.0 - up * up) / beside + up * up / above;
    return s_.volume[a] * 2.0 * in_.interval * r_[a].M * amount * per_length;
  }

  /// Factor [m^D] on what presses the skeleton per change of the mixture's flux, in H.
  [[nodiscard]] double inertia_at_edge(std::size_t a) const {
    const double e = q_[a].e;
    return s_.volume[a] * e * e;
  }
  /// Force times the window's length with which free water resists a velocity of the skeleton at the soil's edge [N]:
  /// the part of H that is no stiffness.
  Vec<D> pushed_back(std::size_t a, const Vec<D>& velocity) const {
    if (!edge_.presses(a)) return Vec<D>::Zero();
    return inertia_at_edge(a) * edge_.pushed_by(a, velocity);
  }

  /// (V/ss) H s for particles that respond, s itself for others; a symmetric operator [n * D].
  void apply_H(std::span<const double> s, std::span<double> y) const {
    const VecArray<D> all = skeleton_extended(as_vectors(s));
    for_each_in_lanes(
        n_, s_.worth_threads, [&](std::size_t a) __attribute__((always_inline)) {
          VectorSum<D> sum;
          Lanes w;
          if (responds(a))
            for (std::size_t k = s_.offset[a]; k < s_.offset[a + 1]; k += n_lanes) {
              const Index* const c = &s_.other[k];
              take(&image_weight_[k], w);
              sum.add(w, {all[c[0]].data(), all[c[1]].data(), all[c[2]].data(), all[c[3]].data()});
            }
          const Vec<D> pushed = pushed_back(a, all[a]);
          for (std::size_t d = 0; d < D; ++d)
            y[a * D + d] = H_diagonal_[a] * all[a][static_cast<int>(d)] - sum.total(d) + pushed[static_cast<int>(d)];
        });
  }
  ScalarArray apply_H(std::span<const Vec<D>> s) const {
    ScalarArray y(n_ * D);
    apply_H(as_numbers(s), y);
    // Particles that do not respond have no equation: their entries are zero.
    for (std::size_t a = 0; a < n_; ++a)
      if (!responds(a)) std::fill_n(y.begin() + static_cast<std::ptrdiff_t>(a * D), D, 0.0);
    return y;
  }
  static std::span<const Vec<D>> as_vectors(std::span<const double> x) {
    static_assert(sizeof(Vec<D>) == D * sizeof(double));
    return {reinterpret_cast<const Vec<D>*>(x.data()), x.size() / D};
  }
  static std::span<const double> as_numbers(std::span<const Vec<D>> x) { return {x.data()->data(), x.size() * D}; }
  static std::span<double> as_numbers(std::span<Vec<D>> x) { return {x.data()->data(), x.size() * D}; }

  /// Corrects s until the residual [n * D] of H s is below the tolerance times `size`, or the power of its error is
  /// negligible. Returns the number of iterations.
  int solve_H(ScalarArray residual, double size, double negligible_power, std::span<Vec<D>> s) const {
    const auto apply = [&](std::span<const double> u, std::span<double> y) {
      between_iterations();
      apply_H(u, y);
    };
    const auto precondition = [&](std::span<const double> r, std::span<double> z) {
      for (std::size_t a = 0; a < n_; ++a)
        for (std::size_t d = 0; d < D; ++d) z[a * D + d] = H_inverse_[a] * r[a * D + d];
      aggregates_->correct(r, z);
    };
    return reduce_residual(domain_, apply, precondition, std::move(residual), as_numbers(s),
                           pressure::skeleton_tolerance * size, 3000, negligible_power)
        .iterations;
  }

  double surface_pressure(std::size_t a) const {
    return surface_row(s_, a, s_.ghost_distance[a], 1.0, in_.weight, in_.origin).pressure;
  }

  VecArray<D> plain_gradient(std::span<const double> p, bool homogeneous) const {
    const Vec<D> unresolved = homogeneous ? Vec<D>(Vec<D>::Zero()) : Vec<D>(-in_.weight);
    return pressure_gradient<D>(
        s_, p, [&](Index c) { return homogeneous ? 0.0 : in_.face_pressure[c]; }, {}, unresolved,
        [&](std::size_t a) { return homogeneous ? 0.0 : surface_pressure(a); }, homogeneous);
  }

  /// The gradient that presses the skeleton.
  VecArray<D> pressing_gradient(std::span<const double> p, bool homogeneous) const {
    VecArray<D> gradient = plain_gradient(p, homogeneous);
    edge_.add_to_gradient(p, gradient);
    return gradient;
  }

  /// Right-hand side of the equation for H s under a pressure field p: V/ss (sb - mS G p) [n * D].
  ScalarArray skeleton_drive(std::span<const double> p) const {
    VecArray<D> G = pressing_gradient(p, false);
    parallel_for(n_, [&](std::size_t a) {
      if (edge_.presses(a)) G[a] += edge_.pushed_by(a, carried(a) - flux_before(a));
    });
    ScalarArray drive(n_ * D, 0.0);
    for (std::size_t a = 0; a < n_; ++a) {
      const auto& q = q_[a];
      const auto& skeleton = r_[a];
      if (!skeleton.responds) continue;
      // The exchanged force contains the full weight of the soil; with a piezometric pressure the buoyant part acts.
      const Vec<D>& force = soil_.found_force.is_allocated() ? soil_.found_force[a] : soil_.force[a];
      const Vec<D> r = force - soil_.fraction[a] * in_.weight - soil_.drag_offset[a];
      const Vec<D> velocity =
          skeleton.ss / (q.aw + q.C) * (q.C * push(a) + (q.aw + q.C) * (skeleton.as * soil_.velocity[a] + r)) -
          skeleton.mS * G[a] + skeleton.ss / s_.volume[a] * flow_[a];
      set_drive(drive, a, velocity);
    }
    return drive;
  }
  void set_drive(ScalarArray& drive, std::size_t a, const Vec<D>& velocity) const {
    for (std::size_t d = 0; d < D; ++d) drive[a * D + d] = s_.volume[a] / r_[a].ss * velocity[static_cast<int>(d)];
  }

  /// Solves for the skeleton's velocity under a pressure field p. The tolerance is relative to the change since the
  /// window's start, where H s was `at_start`, and is at least rounding. The iteration begins at the velocity with H s
  /// equal to `now`.
  void skeleton_velocity(std::span<const double> p, const ScalarArray& at_start, const ScalarArray& now,
                         WindowSolution<D>& out) const {
    ScalarArray residual = skeleton_drive(p);
    const double rounding = 1e-9 * domain_.norm(residual);
    double change = 0.0;
    for (std::size_t i = 0; i < residual.size(); ++i) {
      change += (residual[i] - at_start[i]) * (residual[i] - at_start[i]);
      residual[i] -= now[i];
    }
    change = domain_.sum(change);
    out.skeleton_iterations += solve_H(std::move(residual), std::max(std::sqrt(change), rounding), negligible_power_,
                                       out.solid_velocity.values());
  }

  void solve_response(const ScalarArray& b, WindowSolution<D>& out) {
    const std::span<Vec<D>> velocity = out.solid_velocity.values();
    const ScalarArray at_start = apply_H(velocity);
    skeleton_velocity(out.pressure, at_start, at_start, out);
    ScalarArray residual = imbalance(b, ScalarArray(n_, 0.0), out);
    remove_means(residual);
    const double size = domain_.norm(residual);  // norm of what the search directions must sum to
    std::vector<VecArray<D>> answers;            // response of the skeleton to each search direction
    const auto apply = [&](std::span<const double> x, std::span<double> y) {
      VecArray<D> G = plain_gradient(x, true);
      const ScalarArray held_back = stabilised(x, G);
      edge_.add_to_gradient(x, G);
      ScalarArray drive(n_ * D, 0.0);
      for (std::size_t a = 0; a < n_; ++a)
        if (responds(a)) set_drive(drive, a, -r_[a].mS * G[a]);
      answers.emplace_back(n_, Vec<D>::Zero());
      const double whole = domain_.norm(drive);
      // The skeleton's response is computed even if its power is negligible. Without it, the pressure that closes the
      // volume balance in tight soil would be far too large.
      out.skeleton_iterations += solve_H(std::move(drive), whole, 0.0, answers.back());
      const ScalarArray squeeze_x = squeezed(answers.back());
      fluid_.apply(x, y);
      for (std::size_t a = 0; a < n_; ++a) y[a] += squeeze_x[a] + held_back[a];
      remove_means(y);
    };
    const auto precondition = [&](std::span<const double> r, std::span<double> z) {
      out.pressure_iterations += two_fields(r, z, pressure::preconditioner_tolerance);
      remove_means(z);
    };
    ScalarArray dp(n_, 0.0);
    const double scale = pressure::response_tolerance * size;
    const auto report = flexible_gmres(domain_, apply, precondition, residual, dp, scale, 12);
    out.outer += report.iterations;
    out.converged = report.converged;
    for (std::size_t a = 0; a < n_; ++a) out.pressure[a] += dp[a];
    for (Eigen::Index k = 0; k < report.shares.size(); ++k)
      for (std::size_t a = 0; a < n_; ++a) velocity[a] += report.shares[k] * answers[static_cast<std::size_t>(k)][a];
    skeleton_velocity(out.pressure, at_start, apply_H(velocity), out);
  }

  /// Preconditioner: solves for water and skeleton as two potentials z = [p; tau], coupled by the storage S = e^2/(M
  /// dt): [[-div kf grad + S, -S], [-S, S - div mS e grad]] [p; tau] = [r; 0]. Returns p as `z`, and the number of
  /// iterations.
  int two_fields(std::span<const double> r, std::span<double> z, double tolerance) const {
    ScalarArray b(2 * n_, 0.0), x(2 * n_, 0.0);
    std::copy(r.begin(), r.end(), b.begin());
    // The two fields stand one behind the other, so that each fetches its copies here.
    const auto apply = [&](std::span<const double> u, std::span<double> y) {
      between_iterations();
      fluid_.apply(s_.template with_copies<double>(u.first(n_)), y.first(n_));
      skeleton_.apply(s_.template with_copies<double>(u.last(n_)), y.last(n_));
      for (std::size_t a = 0; a < n_; ++a) {
        const double t = storage_[a] * (u[a] - u[n_ + a]);
        y[a] += t;
        y[n_ + a] -= t;
        if (!responds(a)) y[n_ + a] = u[n_ + a];
      }
    };
    const auto precondition = [&](std::span<const double> u, std::span<double> y) {
      for (std::size_t a = 0; a < n_; ++a) {
        const double d0 = fluid_.diagonal[a] + storage_[a], d1 = skeleton_.diagonal[a] + storage_[a], o = storage_[a];
        if (!responds(a)) {
          y[a] = d0 > 0.0 ? u[a] / d0 : 0.0;
          y[n_ + a] = u[n_ + a];
          continue;
        }
        const double det = d0 * d1 - o * o;
        if (!(det > 0.0)) {
          y[a] = d0 > 0.0 ? u[a] / d0 : 0.0;
          y[n_ + a] = d1 > 0.0 ? u[n_ + a] / d1 : 0.0;
          continue;
        }
        y[a] = (d1 * u[a] + o * u[n_ + a]) / det;
        y[n_ + a] = (o * u[a] + d0 * u[n_ + a]) / det;
      }
    };
    const double whole = domain_.norm(b);
    const auto report =
        reduce_residual(domain_.of_sums(), apply, precondition, std::move(b), x, tolerance * whole, 2000);
    std::copy(x.begin(), x.begin() + static_cast<std::ptrdiff_t>(n_), z.begin());
    return report.iterations;
  }

  /// Completes the solution: gradients, flows through faces, and the water's velocity from the flux n v' = n aw v/(aw +
  /// C) + n C/(aw + C) s - kf G p, in which kf is the mobility of pairs as in the solve.
  void finish(WindowSolution<D>& out) const {
    out.velocity.resize(n_);
    out.gradient = pressing_gradient(out.pressure, false);
    find_face_flow(out);
    VecArray<D> flux;  // empty if the mobility is uniform
    const double mobility = domain_.max(n_ == 0 ? 0.0 : q_[0].kf);
    if (!domain_.all_of(n_, [&](std::size_t a) { return q_[a].kf == mobility; })) {
      ScalarArray own(n_);
      parallel_for(n_, [&](std::size_t a) { own[a] = q_[a].kf; });
      flux = pressure_gradient<D>(
          s_, out.pressure, [&](Index c) { return in_.face_pressure[c]; }, own, Vec<D>(-in_.weight),
          [&](std::size_t a) { return surface_pressure(a); });
      if (!any_response_) free_along_interfaces<D>(s_, own, soil_.mask, flux);
      if (!edge_.empty()) flow_past_edge(out, flux);
    }
    if (!cells_.empty()) flow_in_beds(out, flux);
    parallel_for(n_, [&](std::size_t a) {
      const auto& q = q_[a];
      const Vec<D> driven = flux.empty() ? Vec<D>(mobility * out.gradient[a]) : flux[a];
      out.velocity[a] = (push(a) + q.C * out.solid_velocity[a]) / (q.aw + q.C) - driven / in_.void_fraction[a];
    });
  }

  /// At the soil's edge: completes the flux that the pressure drives, and the gradient that presses the skeleton.
  void flow_past_edge(WindowSolution<D>& out, VecArray<D>& flux) const {
    VecArray<D> change(n_), followed(n_, Vec<D>::Zero());
    parallel_for(n_, [&](std::size_t a) { change[a] = carried(a) + q_[a].e * out.solid_velocity[a] - flux_before(a); });
    edge_.add_to_flux(out.pressure, flux);
    edge_.follow(change, followed);
    out.at_edge.assign(n_, 0);
    parallel_for(n_, [&](std::size_t a) {
      const Vec<D> pushed = edge_.pushed_by(a, change[a]);
      out.gradient[a] += pushed;
      flux[a] += q_[a].kf * pushed - followed[a];
      out.at_edge[a] = edge_.presses(a) ? 1 : 0;
    });
  }

  const Stencil<D>& s_;
  const Domain& domain_;
  const SoilView<D>& soil_;
  std::span<const Surface> flags_;
  const WindowProblem<D>& in_;
  std::size_t n_;
  Eliminations<D> q_;
  SoilEdge<D> edge_;         ///< empty where no soil lies under free water
  std::vector<Response> r_;  ///< empty if no skeleton responds
  ScalarArray modulus_;      ///< [particles] Pa, see find_moduli
  std::vector<char> open_;   ///< [n] 1 where a surface or a face is within reach
  /// A body of water whose mean pressure nothing prescribes: its particles on this rank, and their number on all ranks.
  struct ClosedBody {
    std::vector<std::size_t> rows;
    double count;
  };
  std::vector<ClosedBody> closed_;
  bool any_response_ = false, all_closed_ = false, any_cavitating_ = false;
  std::vector<bool> cavitating_;              ///< [n] whether the pressure is fixed at the cavitation pressure
  VecArray<D> flow_;                          ///< [n] N, see prepare_flow
  BeddedCells<D> cells_;                      ///< empty where the soil has no beds
  std::vector<Index> link_offset_{0}, link_;  ///< pairs of the matrix where the soil has beds
  PairMatrix fluid_, skeleton_, plain_;
  ScalarArray number_;   ///< [particles] as SoilView::number; empty where no soil is at rest
  MatArray<D> stretch_;  ///< [particles] S of even_out_directions
  ScalarArray sources_;
  ScalarArray start_, free_diagonal_, free_boundary_;  ///< pressure at the start; diagonal and right-hand side without
                                                       ///< cavitation
  double negligible_power_ = 0.0;     ///< power below which an error of the skeleton's velocity is negligible [N m/s]
  UnresolvedPressure<D> unresolved_;  ///< empty where no soil moves
  ScalarArray boundary_, stabilisation_, storage_, H_diagonal_;
  ScalarArray H_inverse_;                    ///< [n] inverse diagonal of the preconditioner
  std::vector<char> every_row_;              ///< [n] 1; empty where one rank has all particles
  std::optional<Aggregates<D>> aggregates_;  ///< coarse space for the skeleton's stiffness
  std::vector<float> image_weight_;          ///< [pairs] N s/m, weights of the skeleton's stiffness
};

}  // namespace

template <int D>
void solve_window(const Stencil<D>& stencil, const SoilView<D>& soil, std::span<const Surface> flags,
                  const WindowProblem<D>& problem, WindowSolution<D>& solution) {
  WindowSolver<D>(stencil, soil, flags, problem).solve(solution);
}

#define PORETWIN_INSTANTIATE(D)                                                                  \
  template void solve_window<D>(const Stencil<D>&, const SoilView<D>&, std::span<const Surface>, \
                                const WindowProblem<D>&, WindowSolution<D>&);
PORETWIN_INSTANTIATE(2)
PORETWIN_INSTANTIATE(3)
#undef PORETWIN_INSTANTIATE

}  // namespace poretwin::fluid
