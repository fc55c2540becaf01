// What the phases exchange, independent of any transport: fields at points, windows of time, answers.
// docs/protocol.md describes the same conversation on the wire; proto/poretwin.proto holds the messages.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace poretwin::coupling {

enum class Role { fluid, solid };
std::string_view to_string(Role role);

/// How the coupler carries a field from one point set to the other.
enum class Mapping {
  consistent,    ///< interpolation, exact for constants (and, where enough points lie around, for linear fields)
  nearest,       ///< interpolated, but at jumps the value of the nearest giving point: properties of soils
  conservative,  ///< transposed weights: the sum over receiving points equals the sum over giving points, to rounding
};

std::string_view to_string(Mapping mapping);

/// One field of the interface contract.
struct FieldSpec {
  std::string name;    ///< as in `field::`
  std::string unit;    ///< SI, as written in output metadata: "Pa", "m/s", "N s"
  int components = 1;  ///< 1, or the dimension for vectors (interleaved: x0 y0 x1 y1 ..)
  Mapping mapping = Mapping::consistent;
  std::string
      mask;  ///< optional: a one-component field of the same message, in [0,1], that multiplies the giver's weight
  /// The taker crosses a window in steps of its own and takes the value at the window's start, too (consistent fields).
  bool in_time = false;
  /// The taker repeats windows and takes the value with which the giver's last pass ended, too (consistent fields).
  bool found = false;
  bool operator==(const FieldSpec&) const = default;
};

/// Names of the standard interface (units and meaning in docs/protocol.md).
namespace field {
// fluid -> solid
inline constexpr std::string_view pore_pressure = "pore_pressure";                // Pa
inline constexpr std::string_view degree_of_saturation = "degree_of_saturation";  // water's share of the pores
inline constexpr std::string_view predicted_solid_velocity =
    "predicted_solid_velocity";  // m/s, v_s' of the fluid's solve
inline constexpr std::string_view predicted_change =
    "predicted_change";                                             // m/s, of the skeleton's velocity in the window
inline constexpr std::string_view drag_impulse = "drag_impulse";    // N s given to the solid in the window
inline constexpr std::string_view soil_fraction = "soil_fraction";  // 1 inside soil, 0 in free water: mask
inline constexpr std::string_view surface_share =
    "surface_share";  // 1 where water of moving soil is bounded by its free surface, 0 elsewhere: mask
inline constexpr std::string_view surface_gradient = "surface_gradient";  // Pa/m, of the pressure there
// solid -> fluid
inline constexpr std::string_view solid_velocity = "solid_velocity";            // m/s at the window's end
inline constexpr std::string_view mean_solid_velocity = "mean_solid_velocity";  // m/s, mean over the window
inline constexpr std::string_view volumetric_strain_rate =
    "volumetric_strain_rate";  // 1/s, mean over the window, expansion positive
inline constexpr std::string_view unbalanced_force =
    "unbalanced_force";  // N/m3: div sigma' + traction + weight + pressure and drag at the window's end
inline constexpr std::string_view solid_volume_fraction = "solid_volume_fraction";  // n_s = 1 - porosity
inline constexpr std::string_view grain_density = "grain_density";                  // kg/m3, rho_s (intrinsic)
inline constexpr std::string_view constrained_modulus = "constrained_modulus";      // Pa, M = K + 4 G / 3
inline constexpr std::string_view yielding =
    "yielding";  // plastic shear ratio: plastic over all shear strain of the last window
inline constexpr std::string_view hydraulic_conductivity = "hydraulic_conductivity";    // m/s
inline constexpr std::string_view forchheimer_coefficient = "forchheimer_coefficient";  // s2/m2, of i = U/k + b U^2
inline constexpr std::string_view returned_impulse =
    "returned_impulse";  // N s the solid absorbed beyond drag_impulse; the water has to supply it
}  // namespace field

/// What a case's water is: particles, or a field on the soil's points.
enum class WaterAs { particles, field };

/// The standard contract: what each role gives (it takes what the other gives).
std::vector<FieldSpec> standard_fields(Role giver, int dimension, WaterAs water = WaterAs::particles);

/// What both sides must agree on before the first step.
struct Contract {
  int dimension = 2;
  std::string case_digest;  ///< of the coupled part of the case file
  std::vector<FieldSpec> gives;
  std::vector<FieldSpec> takes;
  std::string case_part = {};  ///< "key = value" lines behind the digest; may be empty
};

/// Points at which a phase gives fields. The first n_active also receive; the rest are ghosts: images of active points,
/// which pass impulses on to them, or stand-ins for matter outside, which only give.
struct PointSet {
  int dimension = 2;
  std::uint64_t revision = 0;  ///< changes whenever any point, volume or length does
  std::size_t n_active = 0;
  std::vector<double> position;          ///< [n * dimension] m
  std::vector<double> volume;            ///< [n] m^D, bulk volume: the weight of the point
  std::vector<double> smoothing_length;  ///< [n] m
  /// [n] the active point that a ghost images, which receives what falls to the ghost; -1: none; of active points their
  /// own index.
  std::vector<double> owner;
  [[nodiscard]] std::size_t size() const { return volume.size(); }
};

/// Values of one field at all points of a set.
struct Field {
  std::string name;
  int components = 1;
  std::vector<double> values;  ///< [n * components]
};

inline constexpr double no_limit = std::numeric_limits<double>::infinity();

/// A phase's state at the end of its last window, as the other phase may see it.
struct Publication {
  double time = 0.0;                    ///< s
  double proposed_interval = no_limit;  ///< s, the longest window that this side considers stable and accurate now
  std::string limited_by;               ///< what sets proposed_interval, in a few words
  /// Of a solid: how far its motion departs from the predicted one: the force that is missing in its balance for that,
  /// over the weight.
  double unsettled = 0.0;
  PointSet points;
  std::vector<Field> fields;
};

/// The other phase's fields at this phase's active points.
struct Inbox {
  std::vector<double>
      coverage;  ///< [n_active] sum of V W of the other side's points: 1 inside, 0 outside, ~0.5 on a flat edge
  /// [n_active]
  /// sum V W (x_j - x)
  /// / (h sum V W): 0 inside however disordered the points, 0.47 on a flat edge, 2 at the last neighbour; 0 where
  /// coverage is 0.
  std::vector<double> asymmetry;
  std::vector<Field> fields;  ///< [n_active * components]; zero where coverage is zero
  /// Values at the window's start of the fields taken `in_time`; absent where the giver's values do not change in the
  /// window.
  std::vector<Field> at_start;
  std::vector<Field> found;  ///< of fields declared `found`, where a window is repeated: how its last pass ended
  /// The field of that name; throws PeerError naming it when it is missing.
  [[nodiscard]] const Field& at(std::string_view name) const;
  /// The field of that name in `found`; throws likewise.
  [[nodiscard]] const Field& found_at(std::string_view name) const;
  /// Values at a time within the window, linear in it: `share` 0 at its start, 1 at its end.
  [[nodiscard]] std::vector<double> between(std::string_view name, double share) const;
};

/// One exchange window.
struct Window {
  std::uint64_t step = 0;
  double time = 0.0;      ///< s, start
  double interval = 0.0;  ///< s
  unsigned pass = 0;      ///< passes through this very window so far
};

/// A phase's answer to a window.
struct Outcome {
  bool accepted = true;
  double suggested_interval = 0.0;  ///< s, when rejected: the largest it would take
  std::string reason;               ///< when rejected
  static Outcome accept() { return {}; }
  static Outcome reject(double interval, std::string why) { return {false, interval, std::move(why)}; }
};

}  // namespace poretwin::coupling
