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

/// The pairs at the edge of soil that rests or moves slowly (docs/theory/coupling.md). Where the flux is continuous
/// through the edge, flux and pressure there follow from the two halves of each pair:
///
///   F = [R_a U_a + R_q U_q - (p_q - p_a)/r] / (R_a + R_q),      p_e = p_a + r R_a (U_a - F)
///
/// with the flux U of water and skeleton without the pressure's, the resistances R per length of the pair, and its
/// length r. The operators inside the soil and the free water take the mean of both sides instead.
template <int D>
class SoilEdge {
 public:
  SoilEdge() = default;
  /// mobility [n]: kf, m4/(N s). moves [n]: soil that moves as a whole with its water, whose edge is treated otherwise.
  /// free_resistance: of free water per length, rho / dt [N s/m4]. presses(a): whether the skeleton at a responds.
  template <class Mobility, class Presses>
  SoilEdge(const Stencil<D>& s, const SoilView<D>& soil, const Mobility& mobility, std::span<const char> moves,
           double free_resistance, const Presses& presses)
      : s_(&s) {
    if (!soil.outside.is_allocated()) return;
    const std::size_t n = s.n_real;
    const auto meets = [&](std::size_t a) { return soil.mask[a] < 1.0 && soil.coverage[a] > 0.0; };
    std::vector<char> near;
    for (std::size_t a = 0; a < n; ++a) {
      if (!meets(a)) continue;
      near.resize(n, 0);
      near[a] = 1;
      for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k)
        if (const Index q = s.parent[s.other[k]]; q < n) near[q] = 1;
    }
    if (near.empty()) return;
    for (std::size_t a = 0; a < n; ++a)
      if (near[a] != 0) particles_.push_back(a);
    into_soil_.assign(n, Vec<D>::Zero());
    parallel_for(particles_.size(), [&](std::size_t i) {
      const std::size_t a = particles_[i];
      Vec<D> normal = Vec<D>::Zero();
      for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k)
        if (const Index q = s.parent[s.other[k]]; q < n) normal += (soil.mask[q] - soil.mask[a]) * weight(a, k);
      if (!normal.isZero(0.0)) into_soil_[a] = normal.normalized();
    });
    pairs_.resize(particles_.size());
    push_.assign(n, 0.0);
    parallel_for(particles_.size(), [&](std::size_t i) {
      const std::size_t a = particles_[i];
      for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k) {
        const Index j = s.other[k], q = s.parent[j];
        if (q >= n || moves[a] != 0 || moves[q] != 0 || (soil.mask[a] >= 1.0 && soil.mask[q] >= 1.0) ||
            (soil.fraction[a] <= 0.0 && soil.fraction[q] <= 0.0))
          continue;
        const auto& pair = pairs_[i].emplace_back(made(a, k, soil, mobility, free_resistance));
        if (pair.ends && presses(a)) push_[a] += pushed(a, pair);
      }
    });
  }

  [[nodiscard]] bool empty() const { return particles_.empty(); }
  /// Whether the pressure at the edge presses the skeleton of this particle.
  [[nodiscard]] bool presses(std::size_t a) const { return !push_.empty() && push_[a] > 0.0; }
  /// Unit vector into the soil; zero far from its edge.
  [[nodiscard]] const Vec<D>& into_soil(std::size_t a) const { return into_soil_[a]; }
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
  /// of the less mobile side.
  void add_to_divergence(std::span<const Vec<D>> flux, std::span<double> divergence) const {
    for_pairs([&](std::size_t a, const EdgePair& pair) {
      if (pair.ends)
        divergence[a] += pair.lead() * (s_->correction_open(a) * weight(a, pair.k)).dot(seen(pair.j, flux) - flux[a]);
    });
  }
  /// Adds to the gradient of a pressure, formed with the means of both sides, that the pressure at the edge acts on the
  /// skeleton.
  void add_to_gradient(std::span<const double> p, std::span<Vec<D>> gradient) const {
    for_pairs([&](std::size_t a, const EdgePair& pair) {
      if (!presses(a) || !pair.ends) return;
      const double share = pair.own * pair.mobility() / std::max(0.5, pair.inside);
      gradient[a] += (share - 1.0) * (p[s_->parent[pair.j]] - p[a]) * (s_->correction[a] * weight(a, pair.k));
    });
  }
  /// Adds to the flux that the pressure drives what the pairs conduct beyond the harmonic mean of their mobilities.
  template <class Mobility>
  void add_to_flux(std::span<const double> p, const Mobility& mobility, std::span<Vec<D>> flux) const {
    for_pairs([&](std::size_t a, const EdgePair& pair) {
      const Index q = s_->parent[pair.j];
      const double beyond = pair.mobility() - harmonic(mobility(a), mobility(q));
      flux[a] += beyond * (p[q] - p[a]) * (s_->correction[a] * weight(a, pair.k));
    });
  }
  /// Adds to the flux of free water that it follows a change of the soil's flux [m/s].
  void follow(std::span<const Vec<D>> change, std::span<Vec<D>> flux) const {
    for_pairs([&](std::size_t a, const EdgePair& pair) {
      if (!(pair.lead() > 0.0)) return;
      const Vec<D>& n = into_soil_[a];
      const Vec<D> r = s_->position[pair.j] - s_->position[a];
      flux[a] += pair.lead() * n.dot(seen(pair.j, change)) * n.dot(r) * (s_->correction[a] * weight(a, pair.k));
    });
  }

 private:
  [[nodiscard]] Vec<D> weight(std::size_t a, std::size_t k) const {
    return static_cast<double>(s_->gradient_factor[k]) * (s_->position[s_->other[k]] - s_->position[a]);
  }
  [[nodiscard]] Vec<D> seen(Index j, std::span<const Vec<D>> f) const {
    return j < s_->n_base ? f[s_->parent[j]] : Vec<D>(s_->map[j - s_->n_base] * f[s_->parent[j]]);
  }
  template <class Mobility>
  EdgePair made(std::size_t a, Index k, const SoilView<D>& soil, const Mobility& mobility, double free) const {
    const Index j = s_->other[k], q = s_->parent[j];
    const bool own = soil.mask[a] >= soil.mask[q];  // this particle is the one farther in the soil
    const std::size_t in = own ? a : q, out = own ? q : a;
    double inside = 0.0;
    if (soil.mask[in] >= 1.0) {
      const Vec<D> ba = s_->position[j] - s_->position[a];
      const Vec<D> r = !own ? ba : j < s_->n_base ? Vec<D>(-ba) : Vec<D>(-(s_->map[j - s_->n_base].transpose() * ba));
      const double across = into_soil_[out].dot(r);
      inside = across > 0.0 ? 1.0 - soil.outside[out] / across : 0.0;
    } else {
      const double from = soil.outside[in], to = soil.outside[out];
      inside = to > from ? -from / (to - from) : soil.mask[in];
    }
    inside = std::clamp(inside, pressure::least_inside, 1.0);
    // Where the soil covers a particle in part, its drag counts the covered part only (mapped_soil).
    const double in_soil = inside / (mobility(in) * soil.mask[in]), in_water = (1.0 - inside) * free;
    return {static_cast<std::size_t>(k), j,      own ? in_soil : in_water,
            own ? in_water : in_soil,    inside, soil.fraction[a] <= 0.0 || soil.fraction[q] <= 0.0};
  }
  /// A pair's part of `push`: the free water between the edge and the other particle moves with the soil.
  [[nodiscard]] double pushed(std::size_t a, const EdgePair& pair) const {
    const Vec<D>& n = into_soil_[a];
    const double across = n.dot(s_->position[pair.j] - s_->position[a]);
    return n.dot(s_->correction[a] * n) * static_cast<double>(s_->gradient_factor[pair.k]) * across * across *
           pair.own * pair.theirs * pair.mobility() / std::max(0.5, pair.inside);
  }

  const Stencil<D>* s_ = nullptr;
  std::vector<std::size_t> particles_;        ///< within reach of the edge
  std::vector<std::vector<EdgePair>> pairs_;  ///< of each of them
  VecArray<D> into_soil_;                     ///< [n]
  ScalarArray push_;                          ///< [n]
};

}  // namespace poretwin::fluid
