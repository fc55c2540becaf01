// The case: what a person wrote in case.toml, checked, in SI units. One struct per section; every key is declared once,
// in case.cpp.
#pragma once

#include <Eigen/Core>

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace poretwin {

/// Case geometry is three-dimensional throughout; 2D cases leave z = 0.
using Point3 = Eigen::Vector3d;

/// Box ("min", "max") or, in 2D, polygon ("points").
struct Shape {
  enum class Kind { box, polygon };
  Kind kind = Kind::box;
  Point3 min = Point3::Zero(), max = Point3::Zero();
  std::vector<Point3> points;  ///< polygon corners, in order
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
};

/// [case]
struct General {
  std::string title;
  int dimension = 2;
  Point3 gravity{0.0, -9.81, 0.0};  ///< m/s2; default downwards along the last axis of the dimension
  double end_time = 0.0;            ///< s
  Point3 domain_min = Point3::Zero(), domain_max = Point3::Zero();  ///< m, needed only with periodic sides
  std::vector<int> periodic;                                        ///< axes
};

/// [water]
struct Water {
  double density = 1000.0;              ///< kg/m3
  double kinematic_viscosity = 1.0e-6;  ///< m2/s
};

/// [[soil]]: a region of soil and its material. With solid.model = "rigid" only shape, porosity and conductivity
/// matter.
struct Soil {
  std::string name;
  Shape shape;
  double porosity = 0.4;                 ///< n = n_w
  double grain_density = 2600.0;         ///< kg/m3, intrinsic rho_s
  double hydraulic_conductivity = 1e-4;  ///< m/s at `porosity`; Kozeny-Carman (18) away from it
  double youngs_modulus = 3.0e6;         ///< Pa
  double poissons_ratio = 0.3;
  double cohesion = 0.0;         ///< Pa
  double friction_angle = 30.0;  ///< degrees
  double dilation_angle = 0.0;   ///< degrees
};

/// [[wall]]: one wall, its meaning for either phase.
struct Wall {
  enum class ForWater { none, free_slip, no_slip };
  enum class ForSoil { none, roller, fixed };
  std::string name;
  Face face;
  ForWater water = ForWater::free_slip;
  ForSoil soil = ForSoil::roller;
};

/// [[water_face]]: a face of prescribed head or pressure through which water comes and goes (ponded head, reservoir,
/// drain).
struct WaterFace {
  std::string name;
  Face face;
  std::optional<Series> head;      ///< m: elevation (along -gravity) of the free surface behind the face
  std::optional<Series> pressure;  ///< Pa, uniform on the face
};

/// [[load]]: traction on the soil's surface near a face.
struct Load {
  std::string name;
  Face face;
  Point3 traction = Point3::Zero();  ///< Pa
  std::optional<double> start;  ///< s; applied from then on. Absent: there from the beginning, part of the initial rest
};

/// [fluid]
struct FluidCase {
  double particle_spacing = 0.0;  ///< m
  std::vector<Shape> regions;  ///< [[fluid.region]]: where water stands at time zero (inside soil it fills the pores)
  Point3 initial_velocity = Point3::Zero();
  Point3 offset{0.5, 0.5, 0.5};  ///< of the first particle from a region's corner, in spacings
  double jitter = 0.0;           ///< random displacement of the initial lattice, in spacings (uniform, +-)
  unsigned seed = 1;
  bool drag = true;  ///< seepage force between the phases
  bool skeleton_response =
      true;  ///< the skeleton's predicted response inside the pressure solve (off: plain staggering, to show its limit)
};

/// [solid]
struct SolidCase {
  enum class Model { rigid, elastic, drucker_prager };
  enum class PressureGradient { difference, sum };  ///< Eq. (62) as corrected; Eq. (61), which expels surface particles
  Model model = Model::elastic;
  double particle_spacing = 0.0;  ///< m
  Point3 initial_velocity = Point3::Zero();
  Point3 offset{0.5, 0.5, 0.5};
  double jitter = 0.0;
  unsigned seed = 2;
  bool initial_rest = true;  ///< find the rest under gravity, water and standing loads before time zero
  PressureGradient pressure_gradient = PressureGradient::difference;
};

/// [coupling]
struct CouplingCase {
  std::optional<double> interval;  ///< s: longest exchange interval; absent: what the solvers propose
};

/// [output]
struct OutputCase {
  double interval = 0.0;        ///< s between frames; 0: first and last only
  double gauge_interval = 0.0;  ///< s between gauge readings; 0: every exchange
};

/// [[gauge]]
struct Gauge {
  std::string name;
  std::string phase;     ///< "fluid" or "solid"
  std::string kind;      ///< "point", "front", "volume", "momentum", "kinetic_energy", "particles", "max_speed";
                         ///< solid only: "max_displacement", "uplift", "pending_impulse" (taken, not yet paid for)
  std::string quantity;  ///< of "point": "pore_pressure", "velocity", "displacement", "effective_stress_yy", ...
  std::vector<Point3> points;   ///< of "point" (name[i] where several), of "front" (a line's two ends)
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
  std::vector<Load> loads;
  FluidCase fluid;
  SolidCase solid;
  CouplingCase coupling;
  OutputCase output;
  std::vector<Gauge> gauges;
  [[nodiscard]] bool coupled() const { return solid.model != SolidCase::Model::rigid; }
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
