// How water flows between two points, and in from a border, at given values of the points' variables; and how much
// water a point then holds. Richards' (1931) equation has two discrete forms: with retention curves, and with a sharp
// front.
#pragma once

#include "common/case/case.hpp"
#include "pore_solver/network.hpp"

#include <memory>
#include <span>

namespace poretwin::pore {

/// A flow [m3/s, 2D: m2/s] and its derivatives by the variables of the points that it runs between.
struct Flow {
  double value = 0.0, by_a = 0.0, by_b = 0.0;
};
/// A flow in through a segment, and its derivative by the variable of its point.
struct Inflow {
  double value = 0.0, slope = 0.0;
};
/// Water at a point [m3, 2D: m2], and its derivative by the point's variable.
struct Content {
  double value = 0.0, slope = 0.0;
};

/// The pores of each point. Those of soil that moves answer to the water within a step: they are `volume` where the
/// skeleton bears a head of `at`, and more by `give` for each metre above it.
struct Pores {
  ScalarArray volume;        ///< m3 (2D: m2)
  ScalarArray at;            ///< m
  ScalarArray give;          ///< m2 (2D: m); zero in rigid soil
  ScalarArray conductivity;  ///< m/s, of the soil when full
};

/// Those of a case's soil before it has moved, as far as water can fill them.
Pores rigid_pores(const Case& scene, const Network& network);

class FlowModel {
 public:
  explicit FlowModel(Pores pores) : pores_(std::move(pores)) {}
  FlowModel(const FlowModel&) = delete;
  FlowModel& operator=(const FlowModel&) = delete;
  virtual ~FlowModel() = default;

  /// Takes the variables of all points; everything below refers to them.
  virtual void set(std::span<const double> variable) = 0;
  /// Takes the pores of all points, likewise.
  void set_pores(Pores pores) { pores_ = std::move(pores); }
  [[nodiscard]] const Pores& pores() const { return pores_; }

  /// Share of the pores that is full of water.
  [[nodiscard]] virtual Content saturation(Index a) const = 0;
  /// The part of the pressure head that the skeleton bears, m: chi psi, chi the effective saturation (Bishop 1959).
  [[nodiscard]] virtual Content borne_head(Index a) const = 0;
  [[nodiscard]] double pore_volume(Index a) const {
    return pores_.volume[a] + pores_.give[a] * (borne_head(a).value - pores_.at[a]);
  }
  [[nodiscard]] Content content(Index a) const {
    const Content s = saturation(a);
    if (pores_.give[a] == 0.0) return {pores_.volume[a] * s.value, pores_.volume[a] * s.slope};
    const double pores = pore_volume(a);
    return {pores * s.value, pores * s.slope + pores_.give[a] * borne_head(a).slope * s.value};
  }
  /// Of the water, m; where a point without capillarity is not full, of the water in its cell.
  [[nodiscard]] virtual double pressure_head(Index a) const = 0;
  /// From a to b.
  [[nodiscard]] virtual Flow through(const Link& link) const = 0;
  /// In through a border behind which still water stands up to an elevation [m]; what of the border lies above is open
  /// to the air: water only leaves there, where its pressure is that of the air.
  [[nodiscard]] virtual Inflow below_level(const Segment& segment, double level) const = 0;
  /// In through a border at which the pressure head is uniform [m].
  [[nodiscard]] virtual Inflow at_head(const Segment& segment, double pressure_head) const = 0;

  /// The variable of a point for a pressure head [m].
  [[nodiscard]] virtual double variable_at(Index a, double pressure_head) const = 0;
  /// Of a point that is full, under no pressure.
  [[nodiscard]] virtual double full(Index a) const = 0;
  /// The value of point a's variable after a Newton step from `from` to `to`: `to`, or the nearest value at which the
  /// step must halt (a corner of the curves, the end of their range). `stopped`: whether this point has already halted
  /// at a corner in this solve; set where it does now.
  [[nodiscard]] virtual double limited(Index a, double from, double to, char& stopped) const = 0;

 protected:
  [[nodiscard]] double conductivity(Index a) const { return pores_.conductivity[a]; }
  /// Of the way between two points: of its two halves in series.
  [[nodiscard]] double conductivity(Index a, Index b) const {
    const double ka = conductivity(a), kb = conductivity(b);
    return ka == kb ? ka : 2.0 * ka * kb / (ka + kb);
  }

 private:
  Pores pores_;
};

/// Of the case's soils: with retention curves, or all of them without.
std::unique_ptr<FlowModel> make_flow_model(const Case& scene, const Network& network);

}  // namespace poretwin::pore
