// The data that phases exchange, independent of any transport: fields at points, time windows, answers. The page
// docs/protocol.md describes the exchange as messages, which proto/poretwin.proto defines.
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
  consistent,    ///< interpolation; exact for constants and, inside the points, for linear fields
  nearest,       ///< interpolation, but the nearest point's value where the field jumps: for soil properties
  conservative,  ///< transposed weights: sums over giving and over receiving points are equal to rounding
};

std::string_view to_string(Mapping mapping);

/// One field of the interface contract.
struct FieldSpec {
  std::string name;    ///< one of the names in `field::`
  std::string unit;    ///< SI, as written in output metadata: "Pa", "m/s", "N s"
  int components = 1;  ///< 1, or the dimension for vectors (interleaved: x0 y0 x1 y1 ..)
  Mapping mapping = Mapping::consistent;
  /// Optional: a one-component field of the same message, in [0, 1]. It multiplies the weights of the giving points.
  std::string mask;
  /// The receiver takes several steps per window and also needs the value at the window's start (only for consistent
  /// fields).
  bool in_time = false;
  /// The receiver repeats windows and also needs the value after the giver's last pass (only for consistent fields).
  bool found = false;
  bool operator==(const FieldSpec&) const = default;
};

/// Names of the standard interface. docs/protocol.md contains the meaning of each field.
namespace field {
// fluid -> solid
inline constexpr std::string_view pore_pressure = "pore_pressure";                // Pa
inline constexpr std::string_view degree_of_saturation = "degree_of_saturation";  // filled part of the pores
inline constexpr std::string_view predicted_solid_velocity =
    "predicted_solid_velocity";  // m/s, v_s' at the window's end
inline constexpr std::string_view predicted_change =
    "predicted_change";                                             // m/s, of the skeleton's velocity over the window
inline constexpr std::string_view drag_impulse = "drag_impulse";    // N s, on the solid during the window
inline constexpr std::string_view soil_fraction = "soil_fraction";  // mask: 1 inside soil, 0 in free water
inline constexpr std::string_view surface_share =
    "surface_share";  // mask: 1 at the free surface of water in moving soil, else 0
inline constexpr std::string_view surface_gradient = "surface_gradient";  // Pa/m, pressure gradient there
inline constexpr std::string_view spreading_rate =
    "spreading_rate";  // 1/s, expansion of the mixture that strains no skeleton
inline constexpr std::string_view basin_level =
    "basin_level";  // m, of the water behind the nearest face with a basin (only in cases with such faces)
inline constexpr std::string_view free_velocity =
    "free_velocity";                                          // m/s, of free water (only in cases whose soil erodes)
inline constexpr std::string_view free_share = "free_share";  // mask: 1 in free water, 0 inside soil (likewise)
// solid -> fluid
inline constexpr std::string_view solid_velocity = "solid_velocity";            // m/s at the window's end
inline constexpr std::string_view mean_solid_velocity = "mean_solid_velocity";  // m/s, mean over the window
inline constexpr std::string_view volumetric_strain_rate =
    "volumetric_strain_rate";  // 1/s, mean over the window, expansion positive
inline constexpr std::string_view unbalanced_force =
    "unbalanced_force";  // N/m3: div sigma' + traction + weight + pressure and drag at the window's end
inline constexpr std::string_view solid_volume_fraction = "solid_volume_fraction";  // n_s = 1 - porosity
inline constexpr std::string_view grain_density = "grain_density";                  // kg/m3, rho_s, of the grains
inline constexpr std::string_view constrained_modulus = "constrained_modulus";      // Pa, M = K + 4 G / 3
inline constexpr std::string_view yielding =
    "yielding";  // plastic shear ratio: plastic over total shear strain of the window
inline constexpr std::string_view hydraulic_conductivity = "hydraulic_conductivity";    // m/s
inline constexpr std::string_view forchheimer_coefficient = "forchheimer_coefficient";  // s2/m2, b in i = U/k + b U^2
inline constexpr std::string_view returned_impulse =
    "returned_impulse";  // N s, absorbed by the solid beyond drag_impulse; the water supplies it
}  // namespace field

/// Representation of the water: particles, or a field on the soil's points.
enum class WaterAs { particles, field };

/// Fields of the standard contract that a role gives. The role takes the fields that the other role gives.
std::vector<FieldSpec> standard_fields(Role giver, int dimension, WaterAs water = WaterAs::particles);

/// The level of basins behind faces, which a field of pore water gives in addition in a case with basins.
inline FieldSpec basin_level_field() { return {std::string(field::basin_level), "m", 1, Mapping::consistent, {}}; }

/// The velocity of free water and its mask, which water as particles gives in addition where the soil erodes.
std::vector<FieldSpec> free_water_fields(int dimension);

/// The properties on which both sides must agree before the first window.
struct Contract {
  int dimension = 2;
  std::string case_digest;  ///< of the part of the case on which both agree
  std::vector<FieldSpec> gives;
  std::vector<FieldSpec> takes;
  std::string case_part = {};  ///< the "key = value" lines from which the digest is computed; may be empty
};

/// Points at which a phase gives fields. The first n_active points also receive fields; the others are ghosts. A ghost
/// is an image of an active point, to which it passes impulses, or stands for matter outside the domain and only gives.
struct PointSet {
  int dimension = 2;
  std::uint64_t revision = 0;  ///< changes whenever any position, volume or smoothing length changes
  std::size_t n_active = 0;
  std::vector<double> position;          ///< [n * dimension] m
  std::vector<double> volume;            ///< [n] m^D, bulk volume that the point represents
  std::vector<double> smoothing_length;  ///< [n] m
  /// [n] For a ghost: index of the active point of which it is an image, and which receives the ghost's impulses; -1:
  /// no such point. For an active point: its own index.
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

/// A phase's state at the end of its last window: the part that the other phase receives.
struct Publication {
  double time = 0.0;                    ///< s
  double proposed_interval = no_limit;  ///< s, longest window that this side considers stable and accurate now
  std::string limited_by;               ///< what determines proposed_interval, in a few words
  /// From a solid: departure of its motion from the predicted motion. It is given as the force that such a departure
  /// requires, over the weight.
  double unsettled = 0.0;
  PointSet points;
  std::vector<Field> fields;
};

/// The other phase's fields at this phase's active points.
struct Inbox {
  /// [n_active] sum of V W over the other side's points, with their volumes V and the kernel W: 1 inside the other
  /// side's matter, 0 outside, about 0.5 on a flat edge.
  std::vector<double> coverage;
  /// [n_active] |sum V W (x_j - x)| / (h sum V W) over the other side's points x_j: the distance of their centre from
  /// x, in smoothing lengths h. It is 0 inside (0.3 at most for disordered points), 0.47 on a flat edge, 2 at the last
  /// neighbour, and 0 where coverage is 0.
  std::vector<double> asymmetry;
  /// [n_active] square root of the trace of the covariance of the other side's points, weighted by V W, in smoothing
  /// lengths: 0 beside a single point, 0.6 on a flat edge. Empty if the coupler does not say it.
  std::vector<double> spread;
  std::vector<Field> fields;  ///< [n_active * components]; zero where coverage is zero
  /// Values at the window's start of the fields taken `in_time`; absent where they do not change during the window.
  std::vector<Field> at_start;
  std::vector<Field> found;  ///< fields declared `found`, after the giver's last pass; only in repeated windows
  /// The field of that name. Throws PeerError with the name if it is missing.
  [[nodiscard]] const Field& at(std::string_view name) const;
  /// The field of that name in `found`. Throws PeerError with the name if it is missing.
  [[nodiscard]] const Field& found_at(std::string_view name) const;
  /// Values at a time within the window, interpolated linearly between its start (share 0) and its end (share 1).
  [[nodiscard]] std::vector<double> between(std::string_view name, double share) const;
};

/// One time window of the exchange.
struct Window {
  std::uint64_t step = 0;
  double time = 0.0;      ///< s, start
  double interval = 0.0;  ///< s
  unsigned pass = 0;      ///< number of earlier passes through this window
  bool saved = false;     ///< the state at its start is saved, so that the phase may give it up (WindowGivenUp)
};

/// A phase's answer to a window.
struct Outcome {
  bool accepted = true;
  double suggested_interval = 0.0;  ///< s, if rejected: longest window that the phase would accept
  std::string reason;               ///< reason of a rejection
  static Outcome accept() { return {}; }
  static Outcome reject(double interval, std::string why) { return {false, interval, std::move(why)}; }
};

}  // namespace poretwin::coupling
