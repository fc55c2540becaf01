// The edge of soil under free water. The flux of the skeleton ends there, between two particles, and the mobility of
// the water changes by orders of magnitude.
#pragma once

#include "fluid_solver/discretisation/operators.hpp"
#include "fluid_solver/exchange/soil_view.hpp"
#include "fluid_solver/numerics/pressure.hpp"

#include <algorithm>
#include <vector>

namespace poretwin::fluid {

/// Of a pair of particles at the soil's edge, seen from one of them.
struct EdgePair {
  std::size_t k;       ///< index of the pair in the stencil
  Index j;             ///< the other point
  double own, theirs;  ///< N s/m4, resistance of the pair's part on this and on the other side, per length of the pair
  double inside;       ///< 1, part of the pair that lies in the soil
  bool ends;           ///< the other one or this one is free water: the flux of the skeleton ends at the edge
  /// m4/(N s), flux per pressure gradient: both parts in series.
  [[nodiscard]] double mobility() const { return 1.0 / (own + theirs); }
  /// Part of the difference of both sides' fluxes, -1 to 1, by which the flux through the edge departs from their mean,
  /// doubled. Positive on the more mobile side: the flux through the edge is that of the less mobile one.
  [[nodiscard]] double lead() const { return ends ? (theirs - own) / (own + theirs) : 0.0; }
};

/// The pairs at the edge of soil under free water (docs/theory/coupling.md). In coarse soil, where inertia dominates,
/// water is treated as free water: it has no edge. Where the flux is continuous through the edge, flux and pressure
/// there follow from the two halves of each pair:
///
///   F = [R_a U_a + R_q U_q - (p_q - p_a)/r] / (R_a + R_q),      p_e = p_a + r R_a (U_a - F)
///
/// with the flux U of water and skeleton without the pressure's, the resistances R per length of the pair, and its
/// length r. The operators inside the soil and the free water take the mean of both sides instead. All ranks call the
/// constructor and what takes a field, or the edge is empty on all.
template <int D>
class SoilEdge {
 public:
  SoilEdge() = default;
  /// mobility [n]: kf, m4/(N s). free_resistance: of free water per length, rho / dt [N s/m4]. presses(a): whether the
  /// skeleton at a responds. coarse(a): whether inertia dominates there.
  template <class Mobility, class Presses, class Coarse>
  SoilEdge(const Stencil<D>& s, const SoilView<D>& soil, const Mobility& mobility, double free_resistance,
           const Presses& presses, const Coarse& coarse) {
    const std::size_t real = s.n_real, n = s.n_particles;
    std::vector<char> meet(real, 0);
    if (soil.outside.is_allocated())
      parallel_for(real, [&](std::size_t a) { meet[a] = soil.mask[a] < 1.0 && soil.coverage[a] > 0.0 ? 1 : 0; });
    if (!s.domain.any_of(real, [&](std::size_t a) { return meet[a] != 0; })) return;
    s_ = &s;
    meet = s.flags_with_copies(meet);
    std::vector<char> near(real, 0);
    for (std::size_t a = 0; a < real; ++a)
      for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k) {
        const Index q = s.parent[s.other[k]];
        if (meet[a] != 0 && q < real) near[q] = 1;
        if (meet[a] != 0 || (q >= real && q < n && meet[q] != 0)) near[a] = 1;
      }
    for (std::size_t a = 0; a < real; ++a)
      if (near[a] != 0) particles_.push_back(a);
    ScalarArray own_outside(real), own_mobility(real);
    std::vector<char> own_coarse(real), own_free(real);
    parallel_for(real, [&](std::size_t a) {
      own_outside[a] = soil.outside[a];
      own_mobility[a] = mobility(a);
      own_coarse[a] = coarse(a) ? 1 : 0;
      own_free[a] = soil.fraction[a] <= 0.0 ? 1 : 0;
    });
    const auto mask = s.template with_copies<double>(soil.mask), outside = s.template with_copies<double>(own_outside);
    const std::vector<char> is_coarse = s.flags_with_copies(own_coarse);
    mobility_ = std::move(own_mobility);
    mobility_.resize(n);
    fill_copies(s.domain, std::span(mobility_));
    free_ = s.flags_with_copies(own_free);
    into_soil_.assign(n, Vec<D>::Zero());
    missing_along_.assign(real, 0.0);
    more_along_.assign(n, 0.0);
    parallel_for(particles_.size(), [&](std::size_t i) {
      const std::size_t a = particles_[i];
      Vec<D> normal = Vec<D>::Zero();
      for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k)
        if (const Index q = s.parent[s.other[k]]; q < n) normal += (mask[q] - mask[a]) * weight(a, k);
      if (!normal.isZero(0.0)) into_soil_[a] = normal.normalized();
    });
    fill_copies(s.domain, std::span(into_soil_));
    pairs_.resize(particles_.size());
    push_.assign(real, 0.0);
    steeper_.assign(real, 1.0);
    parallel_for(particles_.size(), [&](std::size_t i) {
      const std::size_t a = particles_[i];
      for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k) {
        const Index j = s.other[k], q = s.parent[j];
        if (q >= n || (mask[a] >= 1.0 && mask[q] >= 1.0) || (free_[a] != 0 && free_[q] != 0) ||
            is_coarse[mask[a] > mask[q] ? a : q] != 0)
          continue;
        pairs_[i].push_back(made(a, k, mask, outside, free_resistance));
      }
      if (presses(a)) find_push(a, pairs_[i]);
      // Only beside soil's points: then all that pair with a are in particles_, and the matrix stays symmetric.
      if (free_[a] != 0 && meet[a] != 0) find_missing(a, pairs_[i]);
    });
    fill_copies(s.domain, std::span(more_along_));
  }

  [[nodiscard]] bool empty() const { return s_ == nullptr; }
  /// The given mobility, also at a copy.
  [[nodiscard]] double mobility(std::size_t a) const { return mobility_[a]; }
  /// Whether the pressure at the edge presses the skeleton of this particle.
  [[nodiscard]] bool presses(std::size_t a) const { return !push_.empty() && push_[a] > 0.0; }
  /// N s/m4 per length: gradient of the pressure on the skeleton per change of the flux towards the free water, which
  /// must accelerate with it.
  [[nodiscard]] double push(std::size_t a) const { return push_[a]; }
  /// That gradient, for a change of flux [m/s].
  [[nodiscard]] Vec<D> pushed_by(std::size_t a, const Vec<D>& change) const {
    if (!presses(a)) return Vec<D>::Zero();
    return push_[a] * into_soil_[a].dot(change) * into_soil_[a];
  }

  /// Calls take(a, pair) for every pair.
  template <class Take>
  void for_pairs(const Take& take) const {
    parallel_for(particles_.size(), [&](std::size_t i) {
      for (const auto& pair : pairs_[i]) take(particles_[i], pair);
    });
  }

  /// Adds to the divergence of a flux, formed with the means of both sides, that the flux through the edge is the one
  /// of the less mobile side. Along the edge water slips past the soil: a flux there counts on its own side only.
  void add_to_divergence(std::span<const Vec<D>> flux, std::span<double> divergence) const {
    if (empty()) return;
    const auto all = s_->with_copies(flux);
    for_pairs([&](std::size_t a, const EdgePair& pair) {
      if (!pair.ends) return;
      const Vec<D> w = s_->correction_open(a) * weight(a, pair.k), jump = seen(pair.j, all) - flux[a];
      divergence[a] += w.dot((1.0 + pair.lead()) * across(a, jump) - jump);
    });
    parallel_for(particles_.size(), [&](std::size_t i) {
      const std::size_t a = particles_[i];
      if (missing_along_[a] <= 0.0) return;
      double sum = 0.0;
      for_free_pairs(i, [&](Index k, Index j) {
        const Vec<D> jump = seen(j, all) - flux[a];
        sum += (s_->correction_open(a) * weight(a, k)).dot(jump - across(a, jump));
      });
      divergence[a] += missing_along_[a] * sum;
    });
  }
  /// Adds to the divergence of the flux that the water carries that the flux at the window's start is continuous
  /// through the edge: the free water there moved with the soil. before [n]: flux at the window's start [m/s].
  void add_start(std::span<const Vec<D>> before, std::span<double> divergence) const {
    if (empty()) return;
    const auto all = s_->with_copies(before);
    for_pairs([&](std::size_t a, const EdgePair& pair) {
      if (!pair.ends) return;
      const Vec<D> jump = across(a, seen(pair.j, all) - before[a]);
      const double part = pair.lead() > 0.0 ? 1.0 - pair.lead() : -1.0 - pair.lead();
      divergence[a] += part * (s_->correction_open(a) * weight(a, pair.k)).dot(jump);
    });
  }
  /// Adds to the gradient of a pressure, formed with the means of both sides, that the pressure at the edge acts on the
  /// skeleton, at the edge's distance: exact for a pressure that is linear in the soil.
  void add_to_gradient(std::span<const double> own, std::span<Vec<D>> gradient) const {
    if (empty()) return;
    const auto p = s_->with_copies(own);
    parallel_for(particles_.size(), [&](std::size_t i) {
      const std::size_t a = particles_[i];
      if (!presses(a)) return;
      for (const auto& pair : pairs_[i])
        if (pair.ends)
          gradient[a] += (pair.own * pair.mobility() - 1.0) * (p[s_->parent[pair.j]] - p[a]) *
                         (s_->correction[a] * weight(a, pair.k));
      gradient[a] += (steeper_[a] - 1.0) * across(a, gradient[a]);
    });
  }
  /// Adds to the flux that the pressure drives what the pairs conduct beyond the harmonic mean of their mobilities, and
  /// what pairs with the soil do not conduct along the edge.
  void add_to_flux(std::span<const double> own, std::span<Vec<D>> flux) const {
    if (empty()) return;
    const auto p = s_->with_copies(own);
    parallel_for(particles_.size(), [&](std::size_t i) {
      const std::size_t a = particles_[i];
      for (const auto& pair : pairs_[i]) {
        const Index q = s_->parent[pair.j];
        const double beyond = pair.mobility() - harmonic(mobility_[a], mobility_[q]);
        flux[a] += beyond * (p[q] - p[a]) * (s_->correction[a] * weight(a, pair.k));
      }
      if (missing_along_[a] <= 0.0) return;
      Vec<D> sum = Vec<D>::Zero();
      for_free_pairs(i,
                     [&](Index k, Index j) { sum += (p[s_->parent[j]] - p[a]) * (s_->correction[a] * weight(a, k)); });
      flux[a] += missing_along_[a] * mobility_[a] * (sum - across(a, sum));
    });
  }
  /// Factor on the conductance of a pair of particles of free water, of which pairs with the soil leave a part out
  /// along the edge.
  [[nodiscard]] double conductance(std::size_t a, Index k) const {
    const Index j = s_->other[k], q = s_->parent[j];
    if (more_along_[a] == 0.0 && more_along_[q] == 0.0) return 1.0;
    const Vec<D> ba = s_->position[j] - s_->position[a];
    const Vec<D> theirs = j < s_->n_base ? ba : Vec<D>(s_->map[j - s_->n_base].transpose() * ba);
    return 1.0 +
           0.5 * (more_along_[a] * along_square(a, ba) + more_along_[q] * along_square(q, theirs)) / ba.squaredNorm();
  }
  /// Calls take(a, k) for every pair of particles of free water beside the edge.
  template <class Take>
  void for_free_pairs(const Take& take) const {
    parallel_for(particles_.size(),
                 [&](std::size_t i) { for_free_pairs(i, [&](Index k, Index) { take(particles_[i], k); }); });
  }
  /// Adds to the flux of free water that it follows a change of the soil's flux [m/s].
  void follow(std::span<const Vec<D>> change, std::span<Vec<D>> flux) const {
    if (empty()) return;
    const auto all = s_->with_copies(change);
    for_pairs([&](std::size_t a, const EdgePair& pair) {
      if (!(pair.lead() > 0.0)) return;
      const Vec<D>& n = into_soil_[a];
      const Vec<D> r = s_->position[pair.j] - s_->position[a];
      flux[a] += pair.lead() * n.dot(seen(pair.j, all)) * n.dot(r) * (s_->correction[a] * weight(a, pair.k));
    });
  }

 private:
  /// Part of a vector across the edge at particle a.
  [[nodiscard]] Vec<D> across(std::size_t a, const Vec<D>& x) const { return into_soil_[a].dot(x) * into_soil_[a]; }
  [[nodiscard]] double along_square(std::size_t a, const Vec<D>& x) const { return (x - across(a, x)).squaredNorm(); }
  template <class Take>
  void for_free_pairs(std::size_t i, const Take& take) const {
    const std::size_t a = particles_[i];
    if (free_[a] == 0) return;
    for (Index k = s_->offset[a]; k < s_->offset[a + 1]; ++k) {
      const Index j = s_->other[k], q = s_->parent[j];
      if (q < s_->n_particles && free_[q] != 0 && j != a) take(k, j);
    }
  }
  /// What the pairs of free water at a with the soil leave out of the moment along the edge.
  void find_missing(std::size_t a, const std::vector<EdgePair>& pairs) {
    double all = 0.0, left = 0.0, shape = 0.0;
    for (Index k = s_->offset[a]; k < s_->offset[a + 1]; ++k) {
      const Index j = s_->other[k], q = s_->parent[j];
      if (q >= s_->n_particles || j == a) continue;
      const Vec<D> r = s_->position[j] - s_->position[a];
      const double along = along_square(a, r), factor = s_->gradient_factor[k];
      all += factor * along;
      if (free_[q] != 0) shape += factor * along * along / r.squaredNorm();
    }
    for (const auto& pair : pairs)
      if (pair.ends)
        left +=
            static_cast<double>(s_->gradient_factor[pair.k]) * along_square(a, s_->position[pair.j] - s_->position[a]);
    if (!(left > 0.0) || !(all > left) || !(shape > 0.0)) return;
    missing_along_[a] = std::min(left / (all - left), 1.0);
    more_along_[a] = std::min(left / shape, 1.0);
  }
  [[nodiscard]] Vec<D> weight(std::size_t a, std::size_t k) const {
    return static_cast<double>(s_->gradient_factor[k]) * (s_->position[s_->other[k]] - s_->position[a]);
  }
  [[nodiscard]] Vec<D> seen(Index j, std::span<const Vec<D>> f) const {
    return j < s_->n_base ? f[s_->parent[j]] : Vec<D>(s_->map[j - s_->n_base] * f[s_->parent[j]]);
  }
  EdgePair made(std::size_t a, Index k, std::span<const double> mask, std::span<const double> outside,
                double free) const {
    const Index j = s_->other[k], q = s_->parent[j];
    const bool own = mask[a] >= mask[q];  // this particle is the one farther in the soil
    const std::size_t in = own ? a : q, out = own ? q : a;
    double inside = 0.0;
    if (mask[in] >= 1.0) {
      const Vec<D> ba = s_->position[j] - s_->position[a];
      const Vec<D> r = !own ? ba : j < s_->n_base ? Vec<D>(-ba) : Vec<D>(-(s_->map[j - s_->n_base].transpose() * ba));
      const double across = into_soil_[out].dot(r);
      inside = across > 0.0 ? 1.0 - outside[out] / across : 0.0;
    } else {
      const double from = outside[in], to = outside[out];
      inside = to > from ? -from / (to - from) : mask[in];
    }
    inside = std::clamp(inside, pressure::least_inside, 1.0);
    // Where the soil covers a particle in part, its drag counts the covered part only (mapped_soil).
    const double in_soil = inside / (mobility_[in] * mask[in]), in_water = (1.0 - inside) * free;
    return {static_cast<std::size_t>(k), j,      own ? in_soil : in_water,
            own ? in_water : in_soil,    inside, free_[a] != 0 || free_[q] != 0};
  }
  /// How free water presses the skeleton of particle a: between the edge and the other particles it moves with the
  /// soil.
  void find_push(std::size_t a, const std::vector<EdgePair>& pairs) {
    const Vec<D>& n = into_soil_[a];
    double sum = 0.0, beyond = 0.0;  // beyond: part of the moment across the edge that lies beyond the edge
    for (const auto& pair : pairs) {
      if (!pair.ends) continue;
      const double distance = n.dot(s_->position[pair.j] - s_->position[a]),
                   moment = n.dot(s_->correction[a] * weight(a, pair.k)) * distance;
      beyond += (1.0 - pair.inside) * moment;
      sum += moment * pair.own * pair.theirs * pair.mobility();
    }
    steeper_[a] = 1.0 / (1.0 - std::clamp(beyond, 0.0, 0.5));
    push_[a] = std::max(0.0, sum) * steeper_[a];
  }

  const Stencil<D>* s_ = nullptr;
  std::vector<std::size_t> particles_;        ///< within reach of the edge
  std::vector<std::vector<EdgePair>> pairs_;  ///< of each of them
  ScalarArray mobility_;                      ///< [particles] as given
  VecArray<D> into_soil_;                     ///< [particles] unit vector into the soil; zero far from its edge
  ScalarArray push_;                          ///< [n]
  ScalarArray steeper_;                       ///< [n] factor on the gradient across the edge: pairs end there
  std::vector<char> free_;                    ///< [particles] whether no soil covers the particle
  /// [n], [particles] What pairs of free water with the soil leave out of the moment along the edge, over what is left;
  /// and the factor on the squared direction cosine along the edge that conducts it.
  ScalarArray missing_along_, more_along_;
};

}  // namespace poretwin::fluid
