// The case: what a person wrote in case.toml, checked, in SI units. One struct per section; every key is declared once,
// in case.cpp.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace poretwin {

/// Case geometry is three-dimensional throughout; 2D cases leave z = 0.
using Point3 = Eigen::Vector3d;

class Solid;  // common/geometry/solid.hpp

/// How a shape is scaled, then turned, then moved from where its other keys draw it.
struct Placement {
  double scale = 1.0;
  double turn = 0.0;              ///< degrees, about the origin
  Point3 axis = Point3::UnitZ();  ///< of the turn (3D)
  Point3 move = Point3::Zero();   ///< m
};

/// A region of space; which of the numbers count follows from its kind.
struct Shape {
  enum class Kind { box, polygon, ball, cylinder, cone, mesh, terrain };
  Kind kind = Kind::box;
  Point3 min = Point3::Zero(), max = Point3::Zero();
  /// Polygon corners, in order; in 3D of the cross-section of an extrusion, or of a body of revolution as distance from
  /// the axis and place along it.
  std::vector<Point3> points;
  std::vector<int> along, around;  ///< axis of an extrusion, of a revolution (3D): one of them, one axis
  double from = 0.0, to = 0.0;     ///< m, ends of an extrusion along its axis
  std::vector<Point3> ends;        ///< of the axis of a cylinder or cone
  Point3 centre = Point3::Zero();
  double radius = 0.0;                 ///< m
  double end_radius = 0.0;             ///< m, of a cone at the second of its ends
  std::string file;                    ///< of a mesh or terrain, relative to the case file
  double bottom = 0.0;                 ///< m, how far down the body below a terrain reaches
  std::optional<Placement> placement;  ///< absent: as drawn
  std::vector<Shape> within, without;  ///< only what lies in all of `within` and in none of `without` (3D)
  std::shared_ptr<const Solid> solid;  ///< 3D: all but boxes and balls along the axes; made by read_case
};

/// A line of straight pieces (2D, "points"; the domain lies on the LEFT of the walk) or a plane ("point", "normal" into
/// the domain).
struct Face {
  std::vector<Point3> points;
  Point3 point = Point3::Zero(), normal = Point3::Zero();
};

/// A number, or a table [[t, value], ...] interpolated linearly and held constant outside.
struct Series {
  std::vector<std::pair<double, double>> knots;
  [[nodiscard]] double at(double t) const;
  /// From t0 to t1, exact.
  [[nodiscard]] double integral(double t0, double t1) const;
};

/// [case]
struct General {
  std::string title;
  int dimension = 2;
  Point3 gravity{0.0, -9.81, 0.0};  ///< m/s2; default downwards along the last axis of the dimension
  double central_force = 0.0;       ///< 1/s2: acceleration of the water towards the origin, per distance
  double end_time = 0.0;            ///< s
  Point3 domain_min = Point3::Zero(), domain_max = Point3::Zero();  ///< m, needed only with periodic sides
  std::vector<int> periodic;                                        ///< axes
  /// m: taken off all places on reading, and added again to those of the output. Where a scene lies far from the
  /// origin (UTM), its particles would lose the digits that their distances need.
  Point3 origin = Point3::Zero();
};

/// [water]
struct Water {
  double density = 1000.0;              ///< kg/m3
  double kinematic_viscosity = 1.0e-6;  ///< m2/s
  double cavitation_pressure = -98986;  ///< Pa over the air's: of vapour at 20 degrees, 2339, less 101325
};

namespace porous {
struct SeepageLaw;
struct RetentionLaw;
}  // namespace porous

/// Name of a material (materials.hpp), or `rigid`: soil that does not move.
struct MaterialName {
  std::string_view name;
  bool operator==(const MaterialName&) const = default;
  static const MaterialName rigid, elastic, drucker_prager, drucker_prager_rate, mohr_coulomb;
};
inline constexpr MaterialName MaterialName::rigid{"rigid"}, MaterialName::elastic{"elastic"},
    MaterialName::drucker_prager{"drucker_prager"}, MaterialName::drucker_prager_rate{"drucker_prager_rate"},
    MaterialName::mohr_coulomb{"mohr_coulomb"};

/// [soil.retention]: how much water the soil keeps under suction, and how well it then conducts.
struct RetentionCase {
  const porous::RetentionLaw* law = nullptr;           ///< none: the first of `porous::retention_laws`
  double residual_water_content = 0.0;                 ///< theta_r, volume of water per volume that no suction removes
  std::map<std::string, double, std::less<>> numbers;  ///< parameters of the laws, by key
  std::optional<Series> saturation, permeability;      ///< S_e and k_r against pressure head [m], of `table`
};

/// [[soil]]: a region of soil and its material. With solid.model = "rigid" only shape, porosity and the law of seepage
/// matter.
struct Soil {
  /// How the Drucker-Prager cone is fitted to Coulomb's cohesion and friction (docs/theory/materials.md).
  enum class Cone {
    paper,         ///< Eq. (32): plane strain with associated flow (psi = phi)
    plane_strain,  ///< plane strain with any dilation angle
    repose,        ///< sqrt(J2) / p = tan(phi) when sheared at constant volume: phi is the angle of repose
    outer,         ///< 3D, through Coulomb's compression edges
    inner,         ///< 3D, through Coulomb's extension edges
  };
  std::string name;
  Shape shape;
  std::optional<MaterialName> model;                ///< absent: solid.model
  double porosity = 0.4;                            ///< n = n_w
  double grain_density = 2600.0;                    ///< kg/m3, intrinsic rho_s
  const porous::SeepageLaw* seepage_law = nullptr;  ///< none: the first of `porous::seepage_laws`
  std::optional<RetentionCase> retention;           ///< absent: no capillarity
  double hydraulic_conductivity = 1e-4;             ///< k at `porosity`, m/s
  double youngs_modulus = 3.0e6;                    ///< Pa
  double poissons_ratio = 0.3;
  double cohesion = 0.0;                         ///< Pa, at the initial saturation
  double friction_angle = 30.0;                  ///< degrees
  double dilation_angle = 0.0;                   ///< degrees
  std::optional<double> earth_pressure_at_rest;  ///< K0; absent: what elastic loading by gravity gives
  Cone cone = Cone::paper;
  std::optional<double> tensile_strength;    ///< Pa, see docs/case-file.md; absent: that of the cone's apex
  std::optional<double> maximum_void_ratio;  ///< e at which dilation ends; absent: never
  double initial_saturation = 0.0;           ///< s_r0, of soil that the water has not reached
  double suction_head = 0.0;                 ///< m, capillary, at a wetting front
  std::optional<double> saturated_cohesion;  ///< Pa, at s_r = 1, Eq. (36); absent: as `cohesion`
  std::optional<double> undrained_strength;  ///< Pa, s_u; read_case makes it the cohesion of soil without friction
  /// What is left of the strength after slip; absent: all of it.
  std::optional<double> residual_cohesion, residual_friction_angle, residual_dilation_angle;
  std::optional<double> softening_slip;    ///< m, across a shear band, until then
  double band_width = 0.0;                 ///< m, of a shear band: the spacing of the particles, no key of its own
  double stiffness_exponent = 0.0;         ///< of the mean effective pressure
  double reference_pressure = 1e5;         ///< Pa, at which Young's modulus is as given
  double least_pressure = 1e3;             ///< Pa, below which the stiffness falls no further
  std::optional<double> largest_pressure;  ///< Pa, for which the substep is chosen; absent: by the weight and loads
  std::string library;                     ///< a user's own model (umat): path of the shared library
  std::vector<double> properties;          ///< its constants
  std::int64_t state_variables = 0;        ///< how many numbers it remembers of a point
  std::map<std::string, double, std::less<>>
      own_numbers;  ///< by key, of materials and laws of seepage that have keys of their own
  [[nodiscard]] double own(std::string_view key) const { return own_numbers.at(std::string(key)); }
};

/// [[wall]]: one wall, its meaning for either phase.
struct Wall {
  enum class ForWater { none, free_slip, no_slip };
  enum class ForSoil { none, roller, fixed, frictional, rough };
  /// On which side of a wall's shape water and soil are: in a container, or around an obstacle.
  enum class Domain { inside, outside };
  std::string name;
  Face face;
  std::optional<Shape> shape;  ///< in place of the face (3D)
  Domain domain = Domain::inside;
  ForWater water = ForWater::free_slip;
  ForSoil soil = ForSoil::roller;
  double friction_angle = 0.0;  ///< degrees, between a frictional wall and the soil
};

/// [[water_face]]: a face through which water comes and goes. Behind it stands water of a prescribed head or pressure
/// (pond, reservoir, drain), or a basin whose level follows from what is poured in and what leaves through the face, or
/// nothing: water only leaves. A face that no soil touches lets particles of water in and out: by discharge, or to keep
/// a head.
struct WaterFace {
  std::string name;
  Face face;
  std::optional<Series> head;        ///< m: elevation (along -gravity) of the free surface behind; of a basin: at first
  std::optional<Series> pressure;    ///< Pa, uniform on the face
  std::optional<Series> discharge;   ///< m3/s (2D: m2/s) poured into the basin, or let in
  std::optional<Series> basin_area;  ///< m2 (2D: m), horizontal, against elevation [m]: from the bottom up
  bool outlet = false;               ///< nothing behind it
  std::optional<Series> wave_amplitude;         ///< Pa: a standing wave on top of `pressure`
  double wave_length = 0.0, wave_period = 0.0;  ///< m, s
  /// Pressure of that wave at a place and time [Pa]: A cos(2 pi x / L) cos(2 pi t / T).
  [[nodiscard]] double wave(double x, double t) const;
};

/// [[rain]]: water that falls on the soil's surface along a face, or evaporates from it.
struct Rain {
  std::string name;
  Face face;
  std::optional<Series> rate;    ///< m/s, per horizontal area; below zero: evaporation
  double ponding_depth = 0.0;    ///< m, of water that stays on the surface; what is more runs off
  double limit_suction = 150.0;  ///< m, at the surface: drier soil gives no more vapour
};

/// [[load]]: traction on the soil's surface near a face.
struct Load {
  std::string name;
  Face face;
  Point3 traction = Point3::Zero();  ///< Pa
  std::optional<double> start;  ///< s; applied from then on. Absent: there from the beginning, part of the initial rest
  std::optional<Series> factor;  ///< on the traction; absent: 1
};

/// [[pore_pressure]]: water in the pores of a soil that runs alone. Water fills them where the pressure is above zero
/// and seeps at the rate its head gradient drives, so that its force on the skeleton is rho_w g - grad p per volume.
struct PorePressure {
  std::string name;
  std::optional<Shape> region;     ///< absent: all soil; of several, the first that holds a point counts
  std::optional<Series> pressure;  ///< Pa, uniform
  std::optional<Series> head;      ///< m: elevation (along -gravity) of the water table; with to_head: head at `from`
  std::optional<Series> to_head;   ///< m: head at `to`; linear between the two points, constant across and beyond
  Point3 from = Point3::Zero(), to = Point3::Zero();
};

/// [fluid]
struct FluidCase {
  /// How pressure follows from velocity: solved to a tolerance, or by explicit sweeps, Eqs. (82)-(85); the latter also
  /// with the drag taken at the window's start.
  enum class Scheme { projection, eisph, eisph_explicit_drag };
  /// What carries the water: particles that move, or the points of the soil that it seeps through.
  enum class Representation { particles, field };
  double particle_spacing = 0.0;  ///< m
  Representation representation = Representation::particles;
  Scheme scheme = Scheme::projection;
  int sweeps = 1;                            ///< of eisph, per window
  std::optional<double> pressure_tolerance;  ///< of projection: residual left over what drives the flow
  std::vector<Shape> regions;  ///< [[fluid.region]]: where water stands at time zero (inside soil it fills the pores)
  std::optional<Series> initial_pressure_head;  ///< of a field: m, against elevation [m]
  std::optional<double> initial_water_table;    ///< of a field: m, elevation at which its pressure is zero; at rest
  Point3 initial_velocity = Point3::Zero();
  double initial_strain = 0.0;    ///< 1/s: adds (s x, -s y)
  double initial_wave = 0.0;      ///< m/s: adds the lowest sloshing mode of the first region, this fast at the surface
  double initial_vortices = 0.0;  ///< m/s: adds Taylor-Green vortices, one period over the periodic box
  Point3 offset{0.5, 0.5, 0.5};   ///< of the first particle from a region's corner, in spacings
  double jitter = 0.0;            ///< random displacement of the initial lattice, in spacings (uniform, +-)
  unsigned seed = 1;
  bool drag = true;  ///< seepage force between the phases
  /// Eqs. (64)/(73): the soil's velocity at the water's points; Eqs. (67)/(74): a sum over pairs, with G = d or, as
  /// printed, 1/d.
  enum class DragForm { pointwise, smoothed, smoothed_as_printed };
  DragForm drag_form = DragForm::pointwise;
  bool skeleton_response =
      true;  ///< the skeleton's predicted response inside the pressure solve (off: plain staggering, to show its limit)
};

/// [solid.quiet]: work saved while the skeleton hardly moves.
struct Quiet {
  double sleep_below = 1e-3;  ///< of g, root mean square of the departure from rest
  double wake_above = 5e-3;   ///< of g, change of the force on any particle
  bool damping = true;        ///< near-critical, in quasi-static windows only, and in regions that are calm
  double regions = 0.0;       ///< of g: regions at rest around soil that flows sleep below; 0: never
};

/// [solid]
struct SolidCase {
  using Model = MaterialName;
  enum class PressureGradient { difference, sum };  ///< Eq. (62) as corrected; Eq. (61), which pulls at the surface
  Model model = Model::elastic;                     ///< of every soil that names none of its own
  double particle_spacing = 0.0;                    ///< m
  Point3 initial_velocity = Point3::Zero();
  double initial_wave = 0.0;  ///< m/s: adds the lowest sloshing mode of the first soil, this fast at the surface
  Point3 offset{0.5, 0.5, 0.5};
  double jitter = 0.0;
  unsigned seed = 2;
  bool initial_rest = true;      ///< find the rest under gravity, water and loads without `start`
  bool initial_seepage = false;  ///< it is found under the seepage force of the steady flow, not buoyancy alone
  PressureGradient pressure_gradient = PressureGradient::difference;
  double strength_reduction = 1.0;    ///< cohesion and tan(friction) are divided by it
  std::optional<Quiet> quiet;         ///< absent: all motion is computed
  std::optional<double> courant;      ///< of dx / sqrt(M / rho_bar_s); absent: by kind of soil (set_up)
  double list_skin = 0.35;            ///< of the pair lists, in spacings
  double artificial_viscosity = 0.1;  ///< alpha of Monaghan's, on approaching particles
  double quadratic_viscosity = 0.0;   ///< beta of the same
  double artificial_stress = 0.0;     ///< epsilon of Gray et al. (2001), in tension
  double hourglass_viscosity = 0.1;   ///< on the part of the velocity that is not linear around a particle
  bool regular_flow = true;           ///< averages that keep stress, density and packing of flowing soil regular
  double hourglass_stiffness = 0.1;   ///< the same on the displacement, of M; bounded where soil yielded
};

/// [coupling]
struct CouplingCase {
  enum class Scheme { serial, parallel, iterated };
  enum class Acceleration { none, aitken, quasi_newton };
  std::optional<double> interval;    ///< s: longest exchange interval; absent: what the solvers propose
  Scheme scheme = Scheme::iterated;  ///< absent, and nothing is predicted: serial
  Acceleration acceleration = Acceleration::quasi_newton;  ///< of the iterated scheme
  std::optional<double> tolerance;                         ///< of the iterated scheme; absent: its default
  bool keep_points = true;                                 ///< points that have not moved are not sent again
  /// Where the fluid predicts the skeleton's motion: the largest force, over the weight, that may be missing in the
  /// soil's balance at the end of a repeated window.
  [[nodiscard]] double settled_below() const { return tolerance.value_or(3e-3); }
};

/// [output]
struct OutputCase {
  double interval = 0.0;        ///< s between frames; 0: first and last only
  double gauge_interval = 0.0;  ///< s between gauge readings; 0: every exchange
};

/// [[gauge]]
struct Gauge {
  std::string name;
  std::string phase;            ///< "fluid" or "solid"
  std::string kind;             ///< of gauge_kinds.hpp
  std::string quantity;         ///< of "point": "pore_pressure", "velocity", "displacement", "effective_stress_yy", ...
  std::vector<Point3> points;   ///< of "point", "height" (name[i] where several), or a line's two ends
  double pressure_head = 0.0;   ///< m, of "front" of a field: where the water has it
  double thickness = 0.0;       ///< m, of "front" of the soil: how thick it must be to count; 0: the last particle
  double every = 0.0;           ///< s, of "factor_of_safety": between readings
  std::optional<Shape> region;  ///< of "volume", "momentum", ...: absent: everywhere
};

struct Case {
  std::filesystem::path path;
  std::string text;                    ///< the file as read, for provenance
  std::vector<std::string> overrides;  ///< key=value from --set, for provenance
  General general;
  Water water;
  std::vector<Soil> soils;
  std::vector<Wall> walls;
  std::vector<WaterFace> water_faces;
  std::vector<Rain> rains;
  std::vector<Load> loads;
  std::vector<PorePressure> pore_pressures;
  FluidCase fluid;
  SolidCase solid;
  CouplingCase coupling;
  OutputCase output;
  std::vector<Gauge> gauges;
  std::vector<std::string> warnings;  ///< what is allowed and hardly meant: "file:line: key '..': .."
  /// The soil is a phase of its own.
  [[nodiscard]] bool deformable() const { return solid.model != SolidCase::Model::rigid; }
  [[nodiscard]] MaterialName model_of(const Soil& soil) const { return soil.model.value_or(solid.model); }
  /// Some soil moves and can yield.
  [[nodiscard]] bool can_yield() const;
  /// The water is a field on the soil's points.
  [[nodiscard]] bool is_field() const { return fluid.representation == FluidCase::Representation::field; }
  /// There is a water phase.
  [[nodiscard]] bool has_water() const { return is_field() || !fluid.regions.empty() || !water_faces.empty(); }
  /// Both phases run; otherwise the water alone in rigid soil, or the soil alone.
  [[nodiscard]] bool coupled() const { return deformable() && has_water(); }
  /// The water's solve predicts the skeleton's motion.
  [[nodiscard]] bool predicts() const {
    return coupled() && fluid.skeleton_response && fluid.scheme == FluidCase::Scheme::projection;
  }
  /// Hex digest of everything both solvers must agree on; independent of comments, order and paths.
  [[nodiscard]] std::string digest() const;
  /// What the digest is of: "key = value" lines.
  [[nodiscard]] std::string coupled_part() const;
};

/// Reads and checks a case file; overrides are "section.key=value" (TOML values). Throws CaseError with file, line,
/// key, expected, found and the nearest valid key; geometry and physics (porosity, overlapping walls, ...) are checked
/// too.
Case read_case(const std::filesystem::path& path, const std::vector<std::string>& overrides = {});

/// The reference of all keys as Markdown (docs/case-file.md), made from the same declarations that read them.
std::string case_reference();

}  // namespace poretwin
