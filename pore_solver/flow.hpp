// Flow of water between two points and through the soil's border, and the volume of water at a point, as functions of
// the points' variables. Richards' (1931) equation has two discrete forms here: with retention curves, and with a sharp
// front.
#pragma once

#include "common/case/case.hpp"
#include "pore_solver/network.hpp"

#include <memory>
#include <span>

namespace poretwin::pore {

/// A flow [m3/s, 2D: m2/s] from point a to point b, and its derivatives with respect to the two points' variables.
struct Flow {
  double value = 0.0, by_a = 0.0, by_b = 0.0;
};
/// An inflow through a segment [m3/s, 2D: m2/s], and its derivative with respect to the variable of its point.
struct Inflow {
  double value = 0.0, slope = 0.0;
};
/// Volume of water at a point [m3, 2D: m2] and its derivative with respect to the point's variable.
struct Content {
  double value = 0.0, slope = 0.0;
};

/// The pores of each point. In soil that moves, they respond to the water within a step: their volume is `volume` where
/// the head that the skeleton bears is `at`, and increases by `give` per metre by which that head exceeds `at`.
struct Pores {
  ScalarArray volume;        ///< m3 (2D: m2)
  ScalarArray at;            ///< m
  ScalarArray give;          ///< m2 (2D: m); zero in rigid soil
  ScalarArray conductivity;  ///< m/s, of saturated soil
};

/// The pores of a case's soil before it has moved: the part of them that water can fill.
Pores rigid_pores(const Case& scene, const Network& network);

class FlowModel {
 public:
  explicit FlowModel(Pores pores) : pores_(std::move(pores)) {}
  FlowModel(const FlowModel&) = delete;
  FlowModel& operator=(const FlowModel&) = delete;
  virtual ~FlowModel() = default;

  /// Sets the variables of all points. The functions below use these variables.
  virtual void set(std::span<const double> variable) = 0;
  /// Sets the pores of all points. The functions below use these pores.
  void set_pores(Pores pores) { pores_ = std::move(pores); }
  [[nodiscard]] const Pores& pores() const { return pores_; }

  /// Fraction of a point's pores that is filled with water.
  [[nodiscard]] virtual Content saturation(Index a) const = 0;
  /// The part of the pressure head that the skeleton bears [m]: chi psi with the effective saturation chi (Bishop
  /// 1959).
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
  /// Pressure head of the water at a point [m]. Without capillarity it is the level of the water in the point's cell
  /// (or, where the cell is full, the hydraulic head) minus the point's elevation. It is negative where that level lies
  /// below the point.
  [[nodiscard]] virtual double pressure_head(Index a) const = 0;
  /// The flow from a to b.
  [[nodiscard]] virtual Flow through(const Link& link) const = 0;
  /// Inflow through a segment behind which still water stands up to an elevation `level` [m]. The part of the segment
  /// above this level is open to the air: there water only leaves, at the pressure of the air.
  [[nodiscard]] virtual Inflow below_level(const Segment& segment, double level) const = 0;
  /// Inflow through a segment along which the pressure head is uniform [m].
  [[nodiscard]] virtual Inflow at_head(const Segment& segment, double pressure_head) const = 0;

  /// The variable of a point at a pressure head [m].
  [[nodiscard]] virtual double variable_at(Index a, double pressure_head) const = 0;
  /// The variable of a point that is full at zero pressure.
  [[nodiscard]] virtual double full(Index a) const = 0;
  /// Whether a point's variable is at the lower end of its range: the point has no water and cannot lose any.
  [[nodiscard]] virtual bool is_empty(Index a) const = 0;
  /// The value of point a's variable after a Newton step from `from` to `to`: `to`, or the nearest value at which the
  /// step must halt (a corner of the curves or the end of their range). `stopped`: whether this point has halted at a
  /// corner earlier in this solve; it is set where the point halts now.
  [[nodiscard]] virtual double limited(Index a, double from, double to, char& stopped) const = 0;

 protected:
  [[nodiscard]] double conductivity(Index a) const { return pores_.conductivity[a]; }
  /// Conductivity between two points: that of the two halves of their distance in series.
  [[nodiscard]] double conductivity(const Link& link) const {
    const double ka = link.of_a * conductivity(link.a), kb = link.of_b * conductivity(link.b);
    return ka == kb ? ka : 2.0 * ka * kb / (ka + kb);
  }
  /// Conductivity across the border times the transmissibility of a segment, m2/s (2D: m/s).
  [[nodiscard]] double conductance(const Segment& segment) const {
    return segment.across * conductivity(segment.point) * segment.transmissibility;
  }

 private:
  Pores pores_;
};

/// The flow model for the case's soils: either all soils have retention curves, or none has.
std::unique_ptr<FlowModel> make_flow_model(const Case& scene, const Network& network);

}  // namespace poretwin::pore
