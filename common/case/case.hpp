// The case: the content of case.toml, checked, in SI units. It has one struct per section. Every key is declared once,
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

/// Case geometry always has three dimensions; 2D cases leave z = 0.
using Point3 = Eigen::Vector3d;

class Solid;  // common/geometry/solid.hpp

/// How a shape is scaled, then turned, then moved from the position that its other keys define.
struct Placement {
  double scale = 1.0;
  double turn = 0.0;              ///< degrees, about the origin
  Point3 axis = Point3::UnitZ();  ///< of the turn (3D)
  Point3 move = Point3::Zero();   ///< m
};

/// A region of space. The kind of the shape determines which of the numbers apply.
struct Shape {
  enum class Kind { box, polygon, ball, cylinder, cone, mesh, terrain };
  Kind kind = Kind::box;
  Point3 min = Point3::Zero(), max = Point3::Zero();
  /// Polygon corners, in order. In 3D they are those of the cross-section of an extrusion or of a body of revolution;
  /// for the latter they are distances from the axis and places along it.
  std::vector<Point3> points;
  std::vector<int> along, around;  ///< axis of an extrusion or of a revolution (3D): one of both is set, to one axis
  double from = 0.0, to = 0.0;     ///< m, ends of an extrusion along its axis
  std::vector<Point3> ends;        ///< of the axis of a cylinder or cone
  Point3 centre = Point3::Zero();
  double radius = 0.0;                 ///< m
  double end_radius = 0.0;             ///< m, of a cone at the second of its ends
  std::string file;                    ///< of a mesh or terrain, relative to the case file
  double bottom = 0.0;                 ///< m, depth to which the body below a terrain reaches
  std::optional<Placement> placement;  ///< absent: as drawn
  std::vector<Shape> within, without;  ///< only the part in all of `within` and in none of `without` (3D)
  std::shared_ptr<const Solid> solid;  ///< 3D: all except boxes and balls along the axes; made by read_case
};

/// A boundary. In 2D it is a line of straight pieces through `points`, with the domain on its left. In 2D and 3D it may
/// be a plane through `point` whose `normal` points into the domain.
struct Face {
  std::vector<Point3> points;
  Point3 point = Point3::Zero(), normal = Point3::Zero();
  /// With water as a field in 3D: only the part of the soil's surface in this shape; without `normal`, all of that
  /// part. For a load or plate in 3D: the part of the plane in this box; for a load without a plane a shape around the
  /// soil.
  std::optional<Shape> within;
};

/// A number, or a table [[t, value], ...]: linear between its rows, constant before the first row and after the last.
struct Series {
  std::vector<std::pair<double, double>> knots;
  [[nodiscard]] double at(double t) const;
  /// Exact integral over time from t0 to t1.
  [[nodiscard]] double integral(double t0, double t1) const;
};

/// [case]
struct General {
  std::string title;
  int dimension = 2;
  Point3 gravity{0.0, -9.81, 0.0};  ///< m/s2; the default points down the last axis
  double central_force = 0.0;       ///< 1/s2: water accelerates towards the origin by this times its distance from it
  double end_time = 0.0;            ///< s
  Point3 domain_min = Point3::Zero(), domain_max = Point3::Zero();  ///< m; corners of the periodic box
  std::vector<int> periodic;                                        ///< axes along which the domain is periodic
  /// m: subtracted from all positions when the case is read, and added to the positions in the output. Without it,
  /// particles of a scene far from the origin (UTM coordinates) would lose digits in their distances.
  Point3 origin = Point3::Zero();
};

/// [water]
struct Water {
  double density = 1000.0;              ///< kg/m3
  double kinematic_viscosity = 1.0e-6;  ///< m2/s
  double cavitation_pressure = -98986;  ///< Pa above air pressure: that of vapour at 20 degrees C, 2339, less 101325
};

namespace porous {
struct SeepageLaw;
struct RetentionLaw;
struct ErosionLaw;
}  // namespace porous

/// Name of a material (materials.hpp), or `rigid` for soil that does not move.
struct MaterialName {
  std::string_view name;
  bool operator==(const MaterialName&) const = default;
  static const MaterialName rigid, elastic, drucker_prager, drucker_prager_rate, mohr_coulomb;
};
inline constexpr MaterialName MaterialName::rigid{"rigid"}, MaterialName::elastic{"elastic"},
    MaterialName::drucker_prager{"drucker_prager"}, MaterialName::drucker_prager_rate{"drucker_prager_rate"},
    MaterialName::mohr_coulomb{"mohr_coulomb"};

/// [soil.retention]: how much water the soil retains under suction, and its relative permeability.
struct RetentionCase {
  const porous::RetentionLaw* law = nullptr;           ///< law; nullptr: the first of `porous::retention_laws`
  double residual_water_content = 0.0;                 ///< theta_r: volume of water per volume left under suction
  std::map<std::string, double, std::less<>> numbers;  ///< parameters of the law, by key
  std::optional<Series> saturation, permeability;      ///< law `table`: S_e and k_r against pressure head [m]
};

/// [soil.erosion]: how free water that runs over the soil carries its surface off.
struct ErosionCase {
  const porous::ErosionLaw* law = nullptr;             ///< law; nullptr: the first of `porous::erosion_laws`
  double friction_factor = 0.0;                        ///< f of Darcy and Weisbach, tau = f / 8 rho u^2
  std::map<std::string, double, std::less<>> numbers;  ///< parameters of the law, by key
};

/// [[soil]]: a region of soil and its material. With solid.model = "rigid" only shape, porosity and the seepage law
/// apply.
struct Soil {
  /// How the Drucker-Prager cone is fitted to Coulomb's cohesion and friction (docs/theory/materials.md).
  enum class Cone {
    paper,         ///< Eq. (32): exact for plane strain with associated flow (psi = phi)
    plane_strain,  ///< exact for plane strain with any dilation angle
    repose,        ///< sqrt(J2) / p = tan(phi) when sheared at constant volume: phi is the angle of repose
    outer,         ///< 3D, through Coulomb's compression edges
    inner,         ///< 3D, through Coulomb's extension edges
  };
  std::string name;
  Shape shape;
  std::optional<MaterialName> model;                ///< absent: solid.model applies
  double porosity = 0.4;                            ///< n
  std::optional<double> contact_porosity;           ///< n below which the grains touch; absent: they do at the start
  double grain_density = 2600.0;                    ///< kg/m3, density of the grains themselves, rho_s
  const porous::SeepageLaw* seepage_law = nullptr;  ///< nullptr: the first of `porous::seepage_laws`
  std::optional<RetentionCase> retention;           ///< absent: no capillarity
  std::optional<ErosionCase> erosion;               ///< absent: free water carries nothing off
  double hydraulic_conductivity = 1e-4;             ///< k at `porosity`, m/s; for soil in beds, along the beds
  double anisotropy = 1.0;                          ///< conductivity along the beds over that across them
  Point3 bedding_normal = Point3::Zero();           ///< direction across the beds; zero: along gravity
  double youngs_modulus = 3.0e6;                    ///< Pa
  double poissons_ratio = 0.3;
  double cohesion = 0.0;                         ///< Pa, at the saturation `initial_saturation`
  double friction_angle = 30.0;                  ///< degrees
  double dilation_angle = 0.0;                   ///< degrees
  std::optional<double> earth_pressure_at_rest;  ///< K0 at the start; absent: no stress before the search for rest
  Cone cone = Cone::paper;
  std::optional<double> tensile_strength;    ///< Pa, see docs/case-file.md; absent: tension up to the apex of the cone
  std::optional<double> maximum_void_ratio;  ///< e at which dilation ends; absent: dilation does not end
  double initial_saturation = 0.0;           ///< s_r0: degree of saturation of soil that water has not reached
  double suction_head = 0.0;                 ///< m, capillary suction at a wetting front
  std::optional<double> saturated_cohesion;  ///< Pa, at s_r = 1, Eq. (36); absent: equal to `cohesion`
  std::optional<double> undrained_strength;  ///< Pa, s_u; read_case sets it as cohesion of soil without friction
  /// Strength that remains after slip; absent: the whole strength remains.
  std::optional<double> residual_cohesion, residual_friction_angle, residual_dilation_angle;
  std::optional<double> softening_slip;    ///< m, slip across a shear band at which the strength has become residual
  double band_width = 0.0;                 ///< m, width of a shear band; not a key of the case
  double stiffness_exponent = 0.0;         ///< exponent m in E = E_ref (p' / reference_pressure)^m, p': mean stress
  double reference_pressure = 1e5;         ///< Pa, at which `youngs_modulus` holds
  double least_pressure = 1e3;             ///< Pa, pressure below which the stiffness does not decrease further
  std::optional<double> largest_pressure;  ///< Pa, for which the substep is chosen; absent: by weight and loads
  std::string library;                     ///< path of the shared library with a user's own model (umat)
  std::vector<double> properties;          ///< constants of that model
  std::int64_t state_variables = 0;        ///< number of that model's state variables per particle
  std::map<std::string, double, std::less<>>
      own_numbers;  ///< parameters, by key, of materials and seepage laws with keys of their own
  [[nodiscard]] double own(std::string_view key) const { return own_numbers.at(std::string(key)); }
};

/// [[wall]]: one wall, and its conditions for water and for soil.
struct Wall {
  enum class ForWater { none, free_slip, no_slip };
  enum class ForSoil { none, roller, fixed, frictional, rough };
  /// The side of a wall's shape on which water and soil are: in a container, or around an obstacle.
  enum class Domain { inside, outside };
  std::string name;
  Face face;
  std::optional<Shape> shape;  ///< in place of the face (3D)
  Domain domain = Domain::inside;
  ForWater water = ForWater::free_slip;
  ForSoil soil = ForSoil::roller;
  double friction_angle = 0.0;  ///< degrees, friction between a frictional wall and the soil
};

/// [[water_face]]: a face through which water enters and leaves. Behind it is water of a prescribed head or pressure
/// (pond, reservoir, drain), a basin whose level follows from its inflow and the flow through the face, or air (water
/// only leaves). Where no soil touches the face, water particles enter and leave through it, either at a prescribed
/// discharge or such that a head is maintained.
struct WaterFace {
  std::string name;
  Face face;
  std::optional<Series> head;         ///< m: elevation (along -gravity) of the free surface behind the face; for a
                                      ///< basin, that at time zero
  std::optional<Series> pressure;     ///< Pa, uniform on the face
  std::optional<Series> discharge;    ///< m3/s (2D: m2/s) into the basin, or through the inlet into the domain
  std::optional<Series> basin_area;   ///< m2 (2D: m), horizontal area of the basin against elevation [m], from its
                                      ///< bottom up
  std::optional<Series> basin_rain;   ///< m/s, rain on the basin's water, against time; negative: evaporation
  std::optional<double> spill_level;  ///< m, level up to which the basin holds water
  bool outlet = false;                ///< only air is behind the face
  bool free_water = false;            ///< particles of free water come and go before it: set by ground_part(), not by a
                                      ///< key
  std::optional<Series> wave_amplitude;         ///< Pa: amplitude A of a standing wave added to `pressure`
  double wave_length = 0.0, wave_period = 0.0;  ///< m, s: L and T
  /// Pressure of the standing wave at a place and time [Pa]: A cos(2 pi x / L) cos(2 pi t / T).
  [[nodiscard]] double wave(double x, double t) const;
};

/// Whether a basin lies behind one of the faces.
inline bool has_basins(const std::vector<WaterFace>& faces) {
  for (const auto& face : faces)
    if (face.basin_area) return true;
  return false;
}

/// [[rain]]: water that falls on the soil's surface along a face, or evaporates from it.
struct Rain {
  std::string name;
  Face face;
  std::optional<Series> rate;    ///< m/s, per horizontal area; negative: evaporation
  double ponding_depth = 0.0;    ///< m, largest depth of water on the surface; further water runs off
  double limit_suction = 150.0;  ///< m, suction at the surface above which evaporation is below `rate`
};

/// [[well]]: water that is pumped out of the soil or into it along a screen, or a well with a prescribed level.
struct Well {
  std::string name;
  std::vector<Point3> points;       ///< m, both ends of the screen; 2D: centre of a drain across the section
  double radius = 0.0;              ///< m
  std::optional<Series> discharge;  ///< m3/s (2D: m2/s), pumped out of the soil; negative: into the soil
  std::optional<Series> head;       ///< m, elevation (along -gravity) of the water in the well
};

/// [[load]]: traction on the soil's surface near a face.
struct Load {
  std::string name;
  Face face;
  Point3 traction = Point3::Zero();  ///< Pa
  std::optional<double> pressure;    ///< Pa, normal to the face and into the soil, in place of the traction
  /// Whether it is a pressure on all of the soil's surface, of any shape (3D): a shape around the soil and no plane.
  [[nodiscard]] bool on_all_sides() const { return face.within && face.points.empty() && face.normal.isZero(); }
  /// s; the traction acts from this time on. Absent: it always acts and is part of the initial equilibrium.
  std::optional<double> start;
  std::optional<Series> factor;  ///< factor on the traction against time; absent: 1
};

/// [[plate]]: a rigid plate on the soil's surface, which moves in a prescribed way or under a force. It
/// presses in the direction of its normal, which is the normal of its face into the soil.
struct Plate {
  enum class Surface { smooth, rough };  ///< no friction, or no slip
  std::string name;
  Face face;  ///< one straight line (2D), or a rectangle along the axes (3D)
  Surface surface = Surface::smooth;
  std::optional<Series> displacement;  ///< m, along the normal, against time; 0 at time zero
  std::optional<Series> speed;         ///< m/s, along the normal, in place of the displacement
  std::optional<Series> force;         ///< N (2D: N/m), along the normal, in place of displacement and speed
  std::optional<Series> along;         ///< m, displacement of a rough plate along its line (2D); 0 at time zero
  /// s, time from which on the force acts; absent: it always acts, and the soil comes to rest under its first value.
  std::optional<double> start;
  std::optional<double> mass;  ///< kg (2D: kg/m), of a plate under a force; absent: mass of a row of the soil before it
  bool tilts = false;          ///< a plate under a force is free to turn (2D)
  bool lifts = false;          ///< a plate that tilts does not pull at the soil: parts of it come off
  std::optional<double> eccentricity;  ///< m, of the force from the plate's middle, towards its last point; absent: 0
  std::optional<Series> moment;  ///< N m/m, on the plate, in addition to that of the force; presses its last point
                                 ///< into the soil
};

/// [[pore_pressure]]: prescribed pore water in soil that is computed without a water phase. Pores are full where the
/// pressure is positive. The water seeps by its head gradient, so that its force on the skeleton is rho_w g - grad p
/// per volume.
struct PorePressure {
  std::string name;
  std::optional<Shape> region;     ///< absent: all soil; where regions overlap, the first applies
  std::optional<Series> pressure;  ///< Pa, uniform in the region
  std::optional<Series> head;      ///< m: elevation (along -gravity) of the water table; if `to_head` is given: the
                                   ///< head at `from`
  std::optional<Series> to_head;   ///< m: head at `to`; the head is linear from `from` to `to`, constant across that
                                   ///< line and beyond both points
  Point3 from = Point3::Zero(), to = Point3::Zero();
};

/// [fluid]
struct FluidCase {
  /// How the pressure is computed: solved to a tolerance (projection), or by explicit sweeps, Eqs. (82)-(85) (eisph).
  /// In eisph_explicit_drag the drag is also that of the window's start.
  enum class Scheme { projection, eisph, eisph_explicit_drag };
  /// What represents the water: particles that move, a field on the points of the soil, or both, particles where the
  /// water is free and a field in the soil. `automatic` exists only in the file: when the case is read, it becomes one
  /// of the others.
  enum class Representation { particles, field, both, automatic };
  double particle_spacing = 0.0;  ///< m
  Representation representation = Representation::particles;
  Scheme scheme = Scheme::projection;
  int sweeps = 1;                            ///< eisph: sweeps per window
  std::optional<double> pressure_tolerance;  ///< projection: largest residual over the driving forces
  std::vector<Shape> regions;  ///< [[fluid.region]]: place of the water at time zero (in soil it fills the pores)
  std::optional<Series> initial_pressure_head;  ///< field: pressure head [m] against elevation [m]
  std::optional<double> initial_water_table;    ///< field: m, elevation of zero pressure, with water at rest
  Point3 initial_velocity = Point3::Zero();
  double initial_strain = 0.0;    ///< 1/s: strain rate s of the added velocity (s x, -s y)
  double initial_wave = 0.0;      ///< m/s: adds the lowest sloshing mode of the first region, with this speed at the
                                  ///< surface
  double initial_vortices = 0.0;  ///< m/s: adds Taylor-Green vortices, one period over the periodic box
  Point3 offset{0.5, 0.5, 0.5};   ///< of the first particle from the corner of a region, in spacings
  double jitter = 0.0;            ///< random displacement of the initial lattice, in spacings (uniform, up to +-jitter)
  unsigned seed = 1;
  bool drag = true;  ///< seepage force between the phases
  /// How drag uses the soil's velocity: at the water's points, Eqs. (64)/(73), or in a sum over pairs, Eqs. (67)/(74),
  /// whose factor G is the number d of dimensions (smoothed) or, as printed in the paper, 1/d (smoothed_as_printed).
  enum class DragForm { pointwise, smoothed, smoothed_as_printed };
  DragForm drag_form = DragForm::pointwise;
  /// The pressure solve predicts how the skeleton responds. If false: plain staggering, to show where it is unstable.
  bool skeleton_response = true;
};

/// [solid.quiet]: saves work while the skeleton hardly moves.
struct Quiet {
  double sleep_below = 1e-3;  ///< over g: soil sleeps if the rms departure from equilibrium is below this
  double wake_above = 5e-3;   ///< over g: soil wakes if the force on any particle changes by more
  bool damping = true;        ///< near-critical damping, only in quasi-static windows and in calm regions
  double regions = 0.0;       ///< over g: calm regions around flowing soil sleep below this departure; 0: never
};

/// [solid]
struct SolidCase {
  using Model = MaterialName;
  enum class PressureGradient {
    difference,
    sum
  };                              ///< `difference`: Eq. (62) as corrected; `sum`: Eq. (61), in error
                                  ///< at surfaces
  Model model = Model::elastic;   ///< of every soil that gives no model
  double particle_spacing = 0.0;  ///< m
  Point3 initial_velocity = Point3::Zero();
  double initial_wave = 0.0;  ///< m/s: adds the lowest sloshing mode of the first soil, with this speed at the surface
  Point3 offset{0.5, 0.5, 0.5};
  double jitter = 0.0;
  unsigned seed = 2;
  bool initial_rest = true;      ///< start in equilibrium under gravity, water and all loads without `start`
  bool initial_seepage = false;  ///< the initial equilibrium includes the force of steady seepage, not only buoyancy
  PressureGradient pressure_gradient = PressureGradient::difference;
  double strength_reduction = 1.0;    ///< cohesion and tan(friction) are divided by this
  std::optional<Quiet> quiet;         ///< absent: all motion is computed
  std::optional<double> courant;      ///< substep over dx / sqrt(M / rho_bar_s); absent: set_up() chooses it
  double list_skin = 0.35;            ///< margin of the pair lists, in spacings
  double artificial_viscosity = 0.1;  ///< Monaghan's alpha, on approaching particles
  double quadratic_viscosity = 0.0;   ///< Monaghan's beta
  double artificial_stress = 0.0;     ///< epsilon of Gray et al. (2001), in tension
  double hourglass_viscosity = 0.1;   ///< damps the part of the velocity that is not linear around a particle
  bool regular_flow = true;           ///< averages that keep stress, density and packing of flowing soil regular
  double hourglass_stiffness = 0.1;   ///< over M: resists the non-linear part of the displacement; bounded in soil that
                                      ///< yielded
};

/// [coupling]
struct CouplingCase {
  enum class Scheme { serial, parallel, iterated };
  enum class Acceleration { none, aitken, quasi_newton };
  std::optional<double> interval;                          ///< s: longest window; absent: as the solvers propose
  Scheme scheme = Scheme::iterated;                        ///< default; serial where the fluid makes no prediction
  Acceleration acceleration = Acceleration::quasi_newton;  ///< of the iterated scheme
  std::optional<double> tolerance;                         ///< of the iterated scheme; absent: settled_below()
  bool keep_points = true;                                 ///< points that have not moved are not sent again
  /// Where the fluid predicts the skeleton's motion: the largest force, over the weight, that may be missing in the
  /// balance of the soil's forces at the end of a repeated window.
  [[nodiscard]] double settled_below() const { return tolerance.value_or(3e-3); }
};

/// [output]
struct OutputCase {
  double interval = 0.0;        ///< s between frames; 0: only the first and the last frame
  double gauge_interval = 0.0;  ///< s between gauge readings; 0: read at every exchange
};

/// [[gauge]]
struct Gauge {
  std::string name;
  std::string phase;            ///< "fluid" or "solid"
  std::string kind;             ///< a name of gauge_kinds.hpp
  std::string quantity;         ///< of kind "point": "pore_pressure", "velocity", "displacement",
                                ///< "effective_stress_yy", ...
  std::vector<Point3> points;   ///< of "point" and "height" (name[i] if several), or the two ends of a line
  double pressure_head = 0.0;   ///< m, "front" of a field: the pressure head that marks the front
  double thickness = 0.0;       ///< m, "front" of the soil: least thickness; 0: the outermost particle
  double every = 0.0;           ///< s, "factor_of_safety": time between readings
  std::optional<Shape> region;  ///< for "volume", "momentum", ...: part that counts; absent: all
  /// Whether a gauge of vectors reads component d: all do, but one of kind "momentum" with a quantity ("momentum_y").
  [[nodiscard]] bool reads_component(int d) const {
    return kind != "momentum" || quantity.empty() || quantity.back() == "xyz"[d];
  }
};

struct Case {
  std::filesystem::path path;
  std::string text;                    ///< the file as read; stored with the results
  std::vector<std::string> overrides;  ///< the key=value of --set; stored with the results
  General general;
  Water water;
  std::vector<Soil> soils;
  std::vector<Wall> walls;
  std::vector<WaterFace> water_faces;
  std::vector<Rain> rains;
  std::vector<Well> wells;
  std::vector<Load> loads;
  std::vector<Plate> plates;
  std::vector<PorePressure> pore_pressures;
  FluidCase fluid;
  SolidCase solid;
  CouplingCase coupling;
  OutputCase output;
  std::vector<Gauge> gauges;
  std::string representation_chosen;  ///< reason for the result of fluid.representation = "auto"; else empty
  std::vector<std::string> warnings;  ///< doubts about the case: "file:line: key '..': .."
  /// The soil moves, so that there is a solid process.
  [[nodiscard]] bool deformable() const { return solid.model != SolidCase::Model::rigid; }
  [[nodiscard]] MaterialName model_of(const Soil& soil) const { return soil.model.value_or(solid.model); }
  /// Some soil can yield.
  [[nodiscard]] bool can_yield() const;
  /// Whether free water carries off some soil of the case.
  [[nodiscard]] bool erodes() const;
  /// The water is a field on the points of the soil.
  [[nodiscard]] bool is_field() const { return fluid.representation == FluidCase::Representation::field; }
  /// The water is particles where it is free, and a field in the soil.
  [[nodiscard]] bool is_both() const { return fluid.representation == FluidCase::Representation::both; }
  /// Water in the soil is a field, whatever represents free water.
  [[nodiscard]] bool has_field() const { return is_field() || is_both(); }
  /// There is a water phase.
  [[nodiscard]] bool has_water() const { return has_field() || !fluid.regions.empty() || !water_faces.empty(); }
  /// Both phases run. Otherwise only the water runs, in rigid soil, or only the soil.
  [[nodiscard]] bool coupled() const { return deformable() && has_water(); }
  /// The fluid's pressure solve predicts the skeleton's motion.
  [[nodiscard]] bool predicts() const {
    return coupled() && fluid.skeleton_response && fluid.scheme == FluidCase::Scheme::projection;
  }
  /// Hex digest of everything on which both solvers must agree. It does not depend on comments, order and paths.
  [[nodiscard]] std::string digest() const;
  /// The text from which digest() is computed: "key = value" lines.
  [[nodiscard]] std::string coupled_part() const;
};

/// Reads a case file and checks it, including its geometry and physics (porosity, overlapping walls, ...). overrides:
/// "section.key=value" with TOML values. Throws CaseError with file, line, key, expected, found and the nearest valid
/// key.
Case read_case(const std::filesystem::path& path, const std::vector<std::string>& overrides = {});

/// The reference of all keys as Markdown (docs/case-file.md), from the same declarations with which they are read.
std::string case_reference();

}  // namespace poretwin
