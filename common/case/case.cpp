#include "common/case/case.hpp"
#include "common/case/gauge_kinds.hpp"

#include "common/case/bodies.hpp"
#include "common/case/check.hpp"
#include "common/case/doubts.hpp"
#include "common/case/field.hpp"
#include "common/case/keys.hpp"
#include "common/case/materials.hpp"
#include "common/case/origin.hpp"
#include "common/core/error.hpp"
#include "common/core/hash.hpp"
#include "common/geometry/extent.hpp"
#include "common/geometry/solid.hpp"
#include "common/media/erosion_law.hpp"
#include "common/media/retention_law.hpp"
#include "common/media/seepage.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <map>
#include <numbers>
#include <set>

namespace poretwin {
namespace {

template <class E>
using Word = std::pair<std::string_view, E>;

constexpr std::array shape_words{
    Word<Shape::Kind>{"box", Shape::Kind::box},        Word<Shape::Kind>{"polygon", Shape::Kind::polygon},
    Word<Shape::Kind>{"ball", Shape::Kind::ball},      Word<Shape::Kind>{"cylinder", Shape::Kind::cylinder},
    Word<Shape::Kind>{"cone", Shape::Kind::cone},      Word<Shape::Kind>{"mesh", Shape::Kind::mesh},
    Word<Shape::Kind>{"terrain", Shape::Kind::terrain}};
constexpr std::array domain_words{Word<Wall::Domain>{"inside", Wall::Domain::inside},
                                  Word<Wall::Domain>{"outside", Wall::Domain::outside}};
constexpr std::array water_words{Word<Wall::ForWater>{"none", Wall::ForWater::none},
                                 Word<Wall::ForWater>{"free_slip", Wall::ForWater::free_slip},
                                 Word<Wall::ForWater>{"no_slip", Wall::ForWater::no_slip}};
constexpr std::array soil_words{
    Word<Wall::ForSoil>{"none", Wall::ForSoil::none}, Word<Wall::ForSoil>{"roller", Wall::ForSoil::roller},
    Word<Wall::ForSoil>{"fixed", Wall::ForSoil::fixed}, Word<Wall::ForSoil>{"frictional", Wall::ForSoil::frictional},
    Word<Wall::ForSoil>{"rough", Wall::ForSoil::rough}};
constexpr std::array plate_words{Word<Plate::Surface>{"smooth", Plate::Surface::smooth},
                                 Word<Plate::Surface>{"rough", Plate::Surface::rough}};
/// The set of default values (case.scheme): poretwin's own, or those of Bui & Nguyen (2017).
enum class Preset { own, paper };
constexpr std::array preset_words{Word<Preset>{"own", Preset::own}, Word<Preset>{"paper", Preset::paper}};
constexpr std::array representation_words{
    Word<FluidCase::Representation>{"particles", FluidCase::Representation::particles},
    Word<FluidCase::Representation>{"field", FluidCase::Representation::field},
    Word<FluidCase::Representation>{"both", FluidCase::Representation::both},
    Word<FluidCase::Representation>{"auto", FluidCase::Representation::automatic}};
constexpr std::array scheme_words{
    Word<FluidCase::Scheme>{"projection", FluidCase::Scheme::projection},
    Word<FluidCase::Scheme>{"eisph", FluidCase::Scheme::eisph},
    Word<FluidCase::Scheme>{"eisph_explicit_drag", FluidCase::Scheme::eisph_explicit_drag}};
constexpr std::array coupling_words{Word<CouplingCase::Scheme>{"serial", CouplingCase::Scheme::serial},
                                    Word<CouplingCase::Scheme>{"parallel", CouplingCase::Scheme::parallel},
                                    Word<CouplingCase::Scheme>{"iterated", CouplingCase::Scheme::iterated}};
constexpr std::array acceleration_words{
    Word<CouplingCase::Acceleration>{"none", CouplingCase::Acceleration::none},
    Word<CouplingCase::Acceleration>{"aitken", CouplingCase::Acceleration::aitken},
    Word<CouplingCase::Acceleration>{"quasi_newton", CouplingCase::Acceleration::quasi_newton}};
constexpr std::array form_words{
    Word<FluidCase::DragForm>{"pointwise", FluidCase::DragForm::pointwise},
    Word<FluidCase::DragForm>{"smoothed", FluidCase::DragForm::smoothed},
    Word<FluidCase::DragForm>{"smoothed_as_printed", FluidCase::DragForm::smoothed_as_printed}};
constexpr std::array cone_words{
    Word<Soil::Cone>{"paper", Soil::Cone::paper}, Word<Soil::Cone>{"plane_strain", Soil::Cone::plane_strain},
    Word<Soil::Cone>{"repose", Soil::Cone::repose}, Word<Soil::Cone>{"outer", Soil::Cone::outer},
    Word<Soil::Cone>{"inner", Soil::Cone::inner}};
constexpr std::array gradient_words{
    Word<SolidCase::PressureGradient>{"difference", SolidCase::PressureGradient::difference},
    Word<SolidCase::PressureGradient>{"sum", SolidCase::PressureGradient::sum}};

void declare(Keys& keys, General& g) {
  std::int64_t dimension = g.dimension;
  keys.text("title", g.title, {"", "What the case is about."});
  Preset preset = Preset::own;  // read_case() looks it up before it reads the other keys
  keys.choice<Preset>("scheme", preset, preset_words,
                      {"",
                       "Defaults of `[fluid]` and `[solid]`: `own`, or `paper`: the scheme of Bui & Nguyen (2017) as "
                       "far as it is built (docs/theory/paper.md); what the case says otherwise still holds."});
  keys.integer("dimension", dimension, {"", "2 (plane strain, z is ignored) or 3."}, between(2, false, 3, false));
  g.dimension = static_cast<int>(dimension);
  keys.dimension = g.dimension;
  if (g.dimension == 3 && g.gravity == General{}.gravity) g.gravity = {0.0, 0.0, -9.81};
  keys.point("gravity", g.gravity, {"m/s2", "Acceleration of gravity; in 3D the default is [0, 0, -9.81]."});
  keys.number("central_force", g.central_force,
              {"1/s2", "Acceleration of the water towards the origin, per distance from it."}, not_negative());
  keys.number("end_time", g.end_time, {"s", "Simulated time at which the run ends.", true}, positive());
  keys.point("domain_min", g.domain_min,
             {"m", "Lower corner of the periodic box; used along periodic axes, and by rough walls in 3D."});
  keys.point("domain_max", g.domain_max, {"m", "Upper corner of the periodic box."});
  keys.axes("periodic", g.periodic, {"", "Axes along which the domain repeats."});
}

void declare(Keys& keys, Water& w) {
  keys.number("density", w.density, {"kg/m3", "Density of water."}, positive());
  keys.number("kinematic_viscosity", w.kinematic_viscosity, {"m2/s", "Kinematic viscosity of water."}, not_negative());
  keys.number(
      "cavitation_pressure", w.cavitation_pressure,
      {"Pa",
       "Pressure, over that of the air, below which water does not go: it cavitates, that is, opens voids instead."},
      between(-HUGE_VAL, true, 0.0, true));
}

constexpr std::string_view shape_meaning =
    "Box, ball (2D: disc), polygon (3D: extruded along, or revolved around an axis); in 3D also cylinder, cone, `mesh` "
    "from a file, and the body below a `terrain`.";

/// Declares the keys that describe a shape of each kind.
void declare_measures(Keys& keys, Shape& s) {
  using Kind = Shape::Kind;
  const int dimension = keys.dimension;
  const bool box = s.kind == Kind::box, round = s.kind == Kind::cylinder || s.kind == Kind::cone;
  keys.point("min", s.min, {"m", "Lower corner of a box.", box});
  keys.point("max", s.max, {"m", "Upper corner of a box.", box});
  if (s.kind == Kind::polygon) keys.dimension = 2;
  keys.points("points", s.points,
              {"m",
               "Corners of a polygon, in order (required for a polygon); no particle lies on its edges. In 3D, with "
               "`along`: their coordinates along the other two axes; with `around`: distance from the axis, and place "
               "along it.",
               s.kind == Kind::polygon});
  keys.dimension = dimension;
  keys.axes("along", s.along,
            {"", "3D: the axis along which a polygon is extruded, [\"y\"], between `from` and `to`."});
  keys.axes("around", s.around, {"", "3D: the axis around which a polygon is revolved, [\"z\"], through `centre`."});
  keys.number("from", s.from, {"m", "First end of an extruded polygon, along its axis.", !s.along.empty()});
  keys.number("to", s.to, {"m", "Second end of an extruded polygon, along its axis.", !s.along.empty()});
  keys.points("ends", s.ends, {"m", "Centres of the two ends of a cylinder or cone.", round});
  keys.point("centre", s.centre,
             {"m", "Centre of a ball; for a revolved polygon the point of the axis from which places along it count.",
              s.kind == Kind::ball});
  keys.number(
      "radius", s.radius,
      {"m", "Radius of a ball or cylinder, and of a cone at the first of its ends.", s.kind == Kind::ball || round},
      not_negative());
  keys.number("end_radius", s.end_radius,
              {"m", "Radius of a cone at the second of its ends; 0: its tip.", s.kind == Kind::cone}, not_negative());
  keys.text(
      "file", s.file,
      {"",
       "Of a `mesh`, .stl, .obj or .ply, a closed surface in metres (see `scale`); of a `terrain`, .asc (ESRI ASCII "
       "grid) or .xyz (lines x y z, one for each point of a grid). Relative to the case file.",
       s.kind == Kind::mesh || s.kind == Kind::terrain});
  keys.number("bottom", s.bottom,
              {"m", "Elevation z down to which the body below a terrain reaches.", s.kind == Kind::terrain});
  const auto placement = [&](Placement& p) {
    keys.number("scale", p.scale,
                {"1", "Factor by which the shape is scaled about the origin; 0.001 for one drawn in millimetres."},
                positive());
    keys.number("turn", p.turn,
                {"degrees",
                 "Angle by which the scaled shape is turned about the origin, counter-clockwise (3D: as seen from the "
                 "tip of `axis`)."});
    keys.point("axis", p.axis, {"", "3D: direction of the axis about which the shape is turned."});
    keys.point("move", p.move, {"m", "Displacement of the scaled and turned shape."});
  };
  Placement p = s.placement.value_or(Placement{});
  placement(p);
  if (p.scale != 1.0 || p.turn != 0.0 || !p.move.isZero(0.0)) s.placement = p;
}

/// Declares the keys of a shape and of the shapes that cut it.
void declare_rest(Keys& keys, Shape& s) {
  declare_measures(keys, s);
  const auto part = [](Keys& inner, Shape& other) {
    inner.choice<Shape::Kind>("shape", other.kind, shape_words, {"", std::string(shape_meaning)});
    declare_measures(inner, other);
  };
  keys.tables(
      "within",
      About{"", "3D: other shapes, each with the keys above; only what lies in all of them is kept of this shape."},
      s.within, part);
  keys.tables("without", About{"", "3D: other shapes, each with the keys above, that are cut out of this shape."},
              s.without, part);
}

void declare(Keys& keys, Shape& s) {
  keys.choice<Shape::Kind>("shape", s.kind, shape_words, {"", std::string(shape_meaning)});
  declare_rest(keys, s);
}

/// Throws CaseError for a shape without its kind: it would count as a box, and missing keys of a box be reported.
void expect_kinds(const Node& tables, const std::string& path) {
  for (std::size_t i = 0; i < tables.items.size(); ++i) {
    const Node& table = tables.items[i];
    if (table.find("shape") != nullptr || table.find("min") != nullptr || table.find("max") != nullptr) continue;
    for (const auto& [key, kind] : {std::pair{"points", "polygon"},
                                    {"ends", "cylinder"},
                                    {"centre", "ball"},
                                    {"radius", "ball"},
                                    {"file", "mesh"}})
      if (const Node* node = table.find(key))
        throw CaseError(fmt::format("{}: key '{}[{}].shape' is missing: expected shape = \"{}\" with '{}'", node->where,
                                    path, i, kind, key));
  }
}

/// Replaces words and keys of earlier versions by the present ones, and returns a warning for each. An old word is
/// accepted for one version after its replacement.
std::vector<std::string> replace_old_words(Node& root) {
  struct Old {
    std::string_view section, key, old, now;
  };
  constexpr std::array old_words{Old{"soil", "seepage_law", "darcy", "kozeny_carman"}};
  constexpr std::array old_keys{Old{"solid", "", "zero_energy_viscosity", "hourglass_viscosity"},
                                Old{"solid", "", "zero_energy_stiffness", "hourglass_stiffness"}};
  std::vector<std::string> said;
  for (auto& [section, table] : root.entries) {
    for (std::size_t i = 0; i < table.items.size(); ++i)
      for (auto& [key, value] : table.items[i].entries)
        for (const auto& word : old_words) {
          if (section != word.section || key != word.key || value.text != word.old) continue;
          said.push_back(
              fmt::format("{}: key '{}[{}].{}': \"{}\" is the old word for \"{}\"; the next version will not read it",
                          value.where, section, i, key, word.old, word.now));
          value.text = word.now;
        }
    for (auto& [key, value] : table.entries)
      for (const auto& word : old_keys) {
        if (section != word.section || key != word.old) continue;
        said.push_back(fmt::format("{}: key '{}.{}' is the old word for '{}'; the next version will not read it",
                                   value.where, section, word.old, word.now));
        key = word.now;
      }
  }
  return said;
}

void declare(Keys& keys, Face& f) {
  keys.points("points", f.points, {"m", "2D: a line of straight pieces, walked with the domain on the LEFT."});
  keys.point("point", f.point, {"m", "Instead of `points`: any point of a plane (3D) or line (2D)."});
  keys.point("normal", f.normal, {"", "With `point`: direction into the domain."});
}

/// The keys of a face on the soil's surface: those of any face and, in 3D with water as a field, the shape `within`.
void declare_on_soil(Keys& keys, Face& f) {
  declare(keys, f);
  keys.optional_table("within",
                      "3D, with fluid.representation = \"field\": only the part of the soil's surface in this shape; "
                      "without `point` and `normal` all of that part, curved or not.",
                      f.within, [](Keys& inner, Shape& shape) { declare(inner, shape); });
}

/// The names of all materials; with `rigid`, also the name of soil that does not move.
std::vector<Word<MaterialName>> model_words(bool rigid) {
  std::vector<Word<MaterialName>> words;
  if (rigid) words.emplace_back("rigid", MaterialName::rigid);
  for (const Material& material : materials()) words.emplace_back(material.name, MaterialName{material.name});
  return words;
}

/// Declares the keys that belong to single materials. Where several materials have a key, or a law of seepage has it,
/// the first declaration counts.
void declare_own_keys(Keys& keys, Soil& s) {
  std::set<std::string_view> declared;
  for (const auto& law : porous::seepage_laws())
    for (const auto& p : law.parameters) declared.insert(p.key);
  for (const Material& material : materials())
    for (const MaterialKey& key : material.keys) {
      if (!declared.insert(key.name).second) continue;
      double& value = s.own_numbers.try_emplace(std::string(key.name), key.standard).first->second;
      keys.number(key.name, value, key.about, key.range);
    }
}

/// Declares the key that chooses one of several laws by its name; the first is the default. meaning: of the key.
template <class Law>
void declare_law(Keys& keys, std::string_view key, const Law*& chosen, const std::deque<Law>& laws,
                 std::string meaning) {
  std::vector<std::pair<std::string_view, const Law*>> words;
  for (const Law& law : laws) {
    meaning += fmt::format("{} `{}`: {}", words.empty() ? "" : ";", law.name, law.meaning);
    words.emplace_back(law.name, &law);
  }
  if (!chosen) chosen = words.front().second;
  keys.choice<const Law*>(key, chosen, words, {"", meaning + "."});
}

/// Declares the parameters of all laws. Where several laws have a key, the first one's declaration counts.
template <class Law>
void declare_parameters(Keys& keys, const std::deque<Law>& laws, std::map<std::string, double, std::less<>>& numbers) {
  std::set<std::string_view> declared;
  for (const Law& law : laws)
    for (const porous::LawParameter& p : law.parameters) {
      if (!declared.insert(p.key).second) continue;
      keys.number(p.key, numbers.try_emplace(p.key, p.value).first->second, {p.unit, p.meaning},
                  p.needed && p.value > 0.0 ? positive() : not_negative());
    }
}

void declare(Keys& keys, RetentionCase& r) {
  std::string with_tables;
  for (const auto& law : porous::retention_laws())
    if (law.takes_tables) with_tables += fmt::format("{}`{}`", with_tables.empty() ? "" : ", ", law.name);
  declare_law(keys, "model", r.law, porous::retention_laws(), "How much water the soil keeps under suction.");
  keys.number("residual_water_content", r.residual_water_content,
              {"", "Volume of water per volume of soil that no suction removes, theta_r; below `porosity`."},
              between(0, false, 1, true));
  declare_parameters(keys, porous::retention_laws(), r.numbers);
  keys.series("saturation", r.saturation,
              {"1", fmt::format("Effective saturation against pressure head [m], [[psi, S_e], ..], both rising up to "
                                "S_e = 1 ({}).",
                                with_tables)});
  keys.series("permeability", r.permeability,
              {"1", fmt::format("Relative permeability against pressure head [m], likewise ({}).", with_tables)});
}

void declare(Keys& keys, ErosionCase& e) {
  declare_law(keys, "model", e.law, porous::erosion_laws(),
              "Speed E at which the surface retreats, against the shear stress tau of the water.");
  keys.number(
      "friction_factor", e.friction_factor,
      {"",
       "f of Darcy and Weisbach: water with the mean velocity u over its depth shears the surface by tau = f / 8 "
       "rho u^2. From Manning's n and the depth h: f = 8 g n^2 / h^(1/3).",
       true},
      positive());
  declare_parameters(keys, porous::erosion_laws(), e.numbers);
}

void declare(Keys& keys, Soil& s) {
  keys.text("name", s.name, {"", "Name, for messages."});
  declare(keys, s.shape);
  keys.choice<MaterialName>("model", s.model, model_words(false),
                            {"", "Material law of this soil, where it moves; absent: `solid.model`."});
  keys.number("porosity", s.porosity, {"", "Volume of pores per volume, n."}, between(0, true, 1, true));
  keys.number("contact_porosity", s.contact_porosity,
              {"",
               "Porosity at and below which the grains touch. Soil that begins looser is a suspension without stress "
               "and stiffness, as liquefied sand is, until it has settled to this porosity; from there on it is "
               "strained. Absent: the grains touch at the start."},
              between(0, true, 1, true));
  keys.number("grain_density", s.grain_density, {"kg/m3", "Density of the grains themselves."}, positive());
  declare_law(keys, "seepage_law", s.seepage_law, porous::seepage_laws(),
              "Hydraulic gradient i against discharge velocity U.");
  std::string without;  // laws that compute the conductivity themselves
  for (const auto& law : porous::seepage_laws())
    if (!law.takes_conductivity) without += fmt::format("{}`{}`", without.empty() ? " but " : ", ", law.name);
  keys.number("hydraulic_conductivity", s.hydraulic_conductivity,
              {"m/s", fmt::format("k at `porosity` (all laws{}); of anisotropic soil along its beds.", without)},
              positive());
  keys.number("anisotropy", s.anisotropy,
              {"",
               "Conductivity along the beds of the soil over that across them, k_h / k_v. With water as particles: in "
               "2D, in rigid soil, and the same in all soils."},
              between(0.01, false, 100, false));
  keys.point(
      "bedding_normal", s.bedding_normal,
      {"",
       "Direction across the beds, of any length: in 2D [-sin a, cos a] for beds that rise at an angle a towards "
       "+x. Absent: along gravity, for level beds."});
  declare_parameters(keys, porous::seepage_laws(), s.own_numbers);
  keys.optional_table("retention",
                      "How much water the soil keeps under suction, and how well it then conducts; absent: no "
                      "capillarity. With fluid.representation = \"field\".",
                      s.retention, [](Keys& inner, RetentionCase& retention) { declare(inner, retention); });
  keys.optional_table("erosion",
                      "How free water that runs over the soil carries its surface off; absent: it does not. In 2D, "
                      "where soil and water are particles.",
                      s.erosion, [](Keys& inner, ErosionCase& erosion) { declare(inner, erosion); });
  keys.number("youngs_modulus", s.youngs_modulus, {"Pa", "Young's modulus of the drained skeleton."}, positive());
  keys.number("poissons_ratio", s.poissons_ratio, {"", "Poisson's ratio of the drained skeleton."},
              between(0, false, 0.5, true));
  keys.number("stiffness_exponent", s.stiffness_exponent,
              {"",
               "m of E = `youngs_modulus` (p' / `reference_pressure`)^m, p' the mean effective pressure; 0: constant "
               "(materials with `youngs_modulus`)."},
              between(0, false, 1, false));
  keys.number("reference_pressure", s.reference_pressure,
              {"Pa", "Mean effective pressure at which the modulus is `youngs_modulus`."}, positive());
  keys.number("least_pressure", s.least_pressure,
              {"Pa", "Least pressure p' in the stiffness: below it the stiffness is constant."}, positive());
  keys.number(
      "largest_pressure", s.largest_pressure,
      {"Pa",
       "Largest mean effective pressure that is expected, where the stiffness follows it: the substep is chosen "
       "for it, and a run in which it is exceeded ends. Absent: twice the weight of soil and loads."},
      positive());
  keys.number("cohesion", s.cohesion,
              {"Pa", "Cohesion, at `initial_saturation` (materials with cohesion and friction)."}, not_negative());
  keys.number("friction_angle", s.friction_angle,
              {"degrees", "Angle of internal friction (materials with cohesion and friction)."},
              between(0, false, 90, true));
  keys.number("dilation_angle", s.dilation_angle,
              {"degrees", "Dilation angle, at most the friction angle (materials with cohesion and friction)."},
              between(0, false, 90, true));
  keys.choice<Soil::Cone>(
      "cone", s.cone, cone_words,
      {"",
       "Fit of the cone to Coulomb (drucker_prager): `paper` Eq. (32), exact for plane strain with dilation = "
       "friction; "
       "`plane_strain` for any dilation; `repose`: friction is the angle of repose; 3D `outer` (compression), `inner` "
       "(extension)."});
  keys.number("tensile_strength", s.tensile_strength,
              {"Pa",
               "Largest tension: of the mean effective stress (drucker_prager), of each principal one (mohr_coulomb); "
               "absent: that of the cone's apex."},
              not_negative());
  keys.number("undrained_shear_strength", s.undrained_strength,
              {"Pa",
               "s_u, of soil that is sheared undrained, in total stresses: in the place of `cohesion`, with "
               "`friction_angle` and `dilation_angle` 0 and, if not given, `tensile_strength` 0."},
              positive());
  keys.number("residual_cohesion", s.residual_cohesion,
              {"Pa", "What `cohesion` falls to, linearly, over `softening_slip`; absent: it does not fall."},
              not_negative());
  keys.number("residual_friction_angle", s.residual_friction_angle,
              {"degrees", "Friction angle after `softening_slip`; absent: it does not fall."},
              between(0, false, 90, true));
  keys.number("residual_dilation_angle", s.residual_dilation_angle,
              {"degrees", "Dilation angle after `softening_slip`; absent: it does not fall."},
              between(0, false, 90, true));
  keys.number("softening_slip", s.softening_slip,
              {"m",
               "Plastic slip across a shear band over which the strength falls to its residual. A band is two "
               "particle spacings wide: divided by that width this is the plastic shear strain, so that what a band "
               "dissipates does not depend on the spacing."},
              positive());
  keys.number(
      "maximum_void_ratio", s.maximum_void_ratio,
      {"", "Void ratio e = n / (1 - n) at which dilation ends (materials with a dilation angle); absent: never."},
      positive());
  keys.number("initial_saturation", s.initial_saturation,
              {"", "Degree of saturation of soil that the water has not reached."}, between(0, false, 1, true));
  keys.number("suction_head", s.suction_head,
              {"m", "Capillary head that draws a wetting front into the soil (Green & Ampt)."}, not_negative());
  keys.number("saturated_cohesion", s.saturated_cohesion,
              {"Pa", "Cohesion when saturated, linear in the saturation between, Eq. (36); absent: as `cohesion`."},
              not_negative());
  keys.number("earth_pressure_at_rest", s.earth_pressure_at_rest,
              {"",
               "K0: horizontal over vertical effective stress at the start, the latter from the weight and the loads "
               "above (with `solid.initial_rest`: before the search for rest); absent: the search loads the soil by "
               "gravity from nothing, which gives nu / (1 - nu) on level ground; without a search the soil starts "
               "without stress."},
              positive());
  keys.text(
      "library", s.library,
      {"",
       "Shared library with the user's own model (umat): absolute, or from the folder the programs are started in."});
  keys.numbers("properties", s.properties, {"", "Constants of the user's own model, PROPS (umat)."});
  keys.integer("state_variables", s.state_variables,
               {"", "Number of state variables of that model per particle, NSTATV (umat)."},
               between(0, false, 200, false));
  declare_own_keys(keys, s);
}

void declare(Keys& keys, Quiet& q) {
  keys.number("sleep_below", q.sleep_below,
              {"g",
               "Sleep begins below this departure from rest (root mean square of the unbalanced acceleration, or "
               "of the velocity times the near-critical damping rate)."},
              positive());
  keys.number(
      "wake_above", q.wake_above,
      {"g",
       "Sleep ends when the force on a particle has changed by more than this acceleration times its mass. The error "
       "of the stress is then at most this fraction of rho g H, with the density rho and the height H of the soil."},
      positive());
  keys.flag(
      "damping", q.damping,
      {"",
       "Near-critical damping in quasi-static windows while the departure from rest is below 10 `wake_above`; off from "
       "the first yielding until the soil is quiet again. Regions (`regions`) are damped likewise before they sleep."});
  keys.number(
      "regions", q.regions,
      {"g",
       "Regions at rest around soil that flows (plastic strain above 1 %) sleep, too. A region sleeps when, in "
       "the time in which waves cross the soil eight times, it has dissipated next to nothing and moved by no "
       "more than this acceleration would move it. Its pairs and stresses are not computed; to the soil that "
       "moves it stands still. It wakes when a force from outside on a particle changes by more than `wake_above`, "
       "when the force of its neighbours on a particle changes by as much as an error of the stress of "
       "`wake_above` times rho g H would change it, or when something moves beside it. docs/performance.md has "
       "measurements with 5e-3; 0: the soil sleeps as a whole only. Not with periodic sides."},
      not_negative());
}

void declare(Keys& keys, Wall& w) {
  keys.text("name", w.name, {"", "Name, for messages."});
  std::optional<Shape::Kind> kind = w.shape ? std::optional(w.shape->kind) : std::nullopt;
  keys.choice<Shape::Kind>(
      "shape", kind, shape_words,
      {"",
       "3D, instead of `point` and `normal`: the wall is the surface of a shape, whose keys are those "
       "of a [[soil]]'s; water is on one side of it (`domain`)."});
  if (kind) {
    if (!w.shape) w.shape.emplace();
    w.shape->kind = *kind;
    declare_rest(keys, *w.shape);
    keys.choice<Wall::Domain>("domain", w.domain, domain_words,
                              {"", "Of a wall with a `shape`: `inside`, a container, or `outside`, an obstacle."});
  } else {
    declare(keys, w.face);
  }
  keys.choice<Wall::ForWater>("water", w.water, water_words, {"", "What the wall is for water; `none`: not there."});
  keys.choice<Wall::ForSoil>(
      "soil", w.soil, soil_words,
      {"",
       "What the wall is for soil; `none`: not there, `roller`: no friction, `fixed`: no slip, for soil that stays in "
       "place, `frictional`: soil slips once its shear on the wall reaches Coulomb's limit, tan(`friction_angle`) "
       "times its pressure, `rough`: no slip, by three rows of soil at rest behind the wall, for soil that flows over "
       "it (in 3D within the box from `case.domain_min` to `case.domain_max`)."});
  const bool frictional = w.soil == Wall::ForSoil::frictional;
  keys.number("friction_angle", w.friction_angle,
              {"degrees", "Angle of friction between the soil and a frictional wall (required there).", frictional},
              between(0, false, 90, true));
}

void declare(Keys& keys, WaterFace& f) {
  keys.text("name", f.name, {"", "Name, for messages."});
  declare_on_soil(keys, f.face);
  keys.series(
      "head", f.head,
      {"m",
       "Elevation (along -gravity) of the free surface of the still water behind the face, a reservoir. Where it is "
       "above the upper end of a face of soil that cannot yield (2D) from which no wall rises, the water runs over "
       "that crest as particles of free water, critically or drowned; particles that come below the level behind the "
       "face join the reservoir. Where no soil touches the face (2D), the face is an opening that keeps free water at "
       "that level: "
       "per time it lets in sqrt(g d) (`head` - level before the opening), d the depth; what is negative is drawn off, "
       "as far as the opening lies under water."});
  keys.series("pressure", f.pressure, {"Pa", "Instead of `head`: pressure, uniform on the face."});
  keys.series(
      "discharge", f.discharge,
      {"m3/s",
       "With `basin_area`: volume per time that is poured into the basin behind the face (2D: m2/s). The basin's level "
       "follows from the balance of its water, including what runs over its crest and back; `head` is then the level "
       "at time zero; absent: empty. Without `basin_area`: volume per time that is let in (below zero: drawn off) "
       "through the face, an inlet of free water that no soil touches (2D)."});
  keys.series(
      "basin_area", f.basin_area,
      {"m2", "With `discharge`: horizontal area of the basin (2D: length, m) against elevation [m], [[z, A], ..]."});
  keys.series(
      "basin_rain", f.basin_rain,
      {"m/s",
       "With `basin_area`, of a field: rain on the basin's water, or on its bottom while it is dry, as volume per "
       "time and horizontal area; below zero: evaporation, as long as there is water."});
  keys.number("spill_level", f.spill_level,
              {"m",
               "With `basin_area`, of a field: level up to which the basin holds water; more flows off at once (gauge "
               "`basin`). A field needs it where the water would run over the upper end of the face."});
  keys.flag("outlet", f.outlet, {"", "Nothing stands behind the face: water that crosses it has left."});
  keys.series(
      "wave_amplitude", f.wave_amplitude,
      {"Pa",
       "With `pressure`: A of a standing wave A cos(2 pi x / `wave_length`) cos(2 pi t / `wave_period`) that is "
       "added to it. Where the sum is below zero no water stands behind the face."});
  keys.number("wave_length", f.wave_length,
              {"m", "Length of the standing wave, along x.", f.wave_amplitude.has_value()}, positive());
  keys.number("wave_period", f.wave_period, {"s", "Period of the standing wave.", f.wave_amplitude.has_value()},
              positive());
}

void declare(Keys& keys, Rain& r) {
  keys.text("name", r.name, {"", "Name, for messages and gauges."});
  declare_on_soil(keys, r.face);
  keys.series(
      "rate", r.rate,
      {"m/s", "Volume of rain per time and horizontal area, also as a table in time; below zero: evaporation.", true});
  keys.number("ponding_depth", r.ponding_depth,
              {"m", "Depth up to which water that cannot soak in stays on the surface; more runs off at once."},
              not_negative());
  keys.number("limit_suction", r.limit_suction,
              {"m", "Suction at the surface up to which evaporation equals `rate`; from there on the soil limits it."},
              positive());
}

void declare(Keys& keys, Well& w) {
  keys.text("name", w.name, {"", "Name, for messages and gauges."});
  keys.points("points", w.points,
              {"m",
               "Both ends of the screen, through which water comes and goes (3D); the centre of a drain across the "
               "section (2D).",
               true});
  keys.number("radius", w.radius, {"m", "Radius of the screen, at most 0.15 particle spacings.", true}, positive());
  keys.series("discharge", w.discharge,
              {"m3/s",
               "Volume per time that is pumped out of the soil (2D: m2/s), below zero: into it. Where the soil yields "
               "less, the well stands empty down to the lower end of its screen and takes what comes."});
  keys.series("head", w.head,
              {"m",
               "Instead of `discharge`: elevation (along -gravity) of the water in the well. Above it water only "
               "seeps out of the soil."});
}

void declare(Keys& keys, Load& l) {
  keys.text("name", l.name, {"", "Name, for messages."});
  declare(keys, l.face);
  keys.optional_table("within",
                      "3D, with `point` and `normal` along an axis: only the part of the plane in this box, as far as "
                      "soil lies there; the total force is the traction times its area. Without `point` and `normal`: "
                      "a shape that contains all soil; `pressure` then acts on the whole surface of the soil, of any "
                      "shape, except where walls hold it.",
                      l.face.within, [](Keys& inner, Shape& shape) { declare(inner, shape); });
  keys.number("pressure", l.pressure,
              {"Pa", "Instead of `traction`: force per area across the face, into the soil where it is above zero."});
  keys.point("traction", l.traction,
             {"Pa",
              "Force per area on the soil's surface near the face (required without `pressure`). With `points` the "
              "total force "
              "is the traction times the length of the line, as far as soil lies along it.",
              !l.pressure});
  keys.number("start", l.start,
              {"s",
               "Time from which on the load acts; absent: it always acts, and the soil comes to rest under it "
               "before time zero."});
  keys.series(
      "factor", l.factor,
      {"1", "Factor on the traction, against time; without `start` the soil comes to rest under its first value."});
}

void declare(Keys& keys, Plate& p) {
  keys.text("name", p.name, {"", "Name, for messages and gauges."});
  declare(keys, p.face);
  keys.optional_table("within",
                      "3D, with `point` and `normal` along an axis: the plate is the part of the plane in this box; "
                      "absent: all of it.",
                      p.face.within, [](Keys& inner, Shape& shape) { declare(inner, shape); });
  keys.choice<Plate::Surface>("surface", p.surface, plate_words,
                              {"", "`smooth`: no shear between plate and soil, `rough`: no slip."});
  keys.series("displacement", p.displacement,
              {"m",
               "How far the plate has moved into the soil, along its normal, as a table in time that begins with 0 "
               "at time zero."});
  keys.series("speed", p.speed, {"m/s", "Instead of `displacement`: its speed into the soil."});
  keys.series("force", p.force,
              {"N",
               "Instead of both: force with which the plate presses on the soil, along its normal (2D: N/m). Without "
               "`start` the soil comes to rest under its first value before time zero."});
  keys.series("along", p.along,
              {"m",
               "2D: how far a rough plate has moved along its line, from its first towards its last point, as a "
               "table in time that begins with 0 at time zero."});
  keys.number("start", p.start, {"s", "Time from which on `force` acts; absent: it always acts."});
  keys.number("mass", p.mass,
              {"kg", "Mass of a plate under a force (2D: kg/m); absent: the mass of one row of the soil before it."},
              positive());
  keys.flag("tilts", p.tilts,
            {"",
             "2D, with `force`: the plate is free to turn. Both of its ends must lie a spacing or more off walls and "
             "other plates."});
  keys.number("eccentricity", p.eccentricity,
              {"m", "With `tilts`: how far from the plate's middle, towards its last point, `force` acts; absent: 0."});
  keys.series("moment", p.moment,
              {"N m",
               "With `tilts`: moment on the plate in addition to that of `force` (2D: N m/m); above zero where it "
               "presses the plate's last point into the soil. It acts while `force` acts."});
  keys.flag("lifts", p.lifts,
            {"",
             "With `tilts`, on dry soil: the plate does not pull at the soil; parts of it that would, come off, and "
             "touch again once the gap has closed. Absent: the soil sticks to the plate."});
}

void declare(Keys& keys, PorePressure& p) {
  keys.text("name", p.name, {"", "Name, for messages."});
  keys.optional_table("region",
                      "Where this pore pressure holds; absent: in all soil. Where regions overlap, the first one "
                      "counts.",
                      p.region, [](Keys& inner, Shape& shape) { declare(inner, shape); });
  keys.series("head", p.head,
              {"m", "Elevation (along -gravity) of the water table; with `to_head`: the total head at `from`."});
  keys.series("pressure", p.pressure, {"Pa", "Instead of `head`: pressure, uniform."});
  keys.series("to_head", p.to_head,
              {"m", "Total head at `to`: linear between `from` and `to`, constant across and beyond (seepage)."});
  keys.point("from", p.from, {"m", "With `to_head`: where `head` holds."});
  keys.point("to", p.to, {"m", "With `to_head`: where `to_head` holds."});
}

void declare_seed(Keys& keys, unsigned& seed) {
  std::int64_t value = seed;
  keys.integer("seed", value, {"", "Seed of the jitter."}, between(0, false, 4294967295.0, false));
  seed = static_cast<unsigned>(value);
}

void declare(Keys& keys, FluidCase& f) {
  keys.number("particle_spacing", f.particle_spacing,
              {"m", "Distance between neighbouring water particles; required where there is water."}, not_negative());
  keys.choice<FluidCase::Representation>(
      "representation", f.representation, representation_words,
      {"",
       "`particles` that move with the water, also where it runs free; `field`: pressure heads at points of soil, "
       "saturated "
       "or not, `particle_spacing` apart; of soil that moves (2D) its particles (docs/theory/pore_water_field.md); "
       "`both`: particles where the water is free, and a field in rigid soil (2D), with water passing through all "
       "parts "
       "of the soil's surface along which no wall, face or rain is drawn (docs/theory/free_water_and_ground.md); "
       "`auto`: `both` where the case has a key for a field only and free water; `field` where it has such a key, or "
       "has "
       "neither free water, inertia nor soil that can yield, and nothing else that a field lacks; otherwise "
       "`particles`. `poretwin check` prints which, and why."});
  keys.series("initial_pressure_head", f.initial_pressure_head,
              {"m", "Field: pressure head at time zero, a number or a table against elevation, [[z, psi], ..]."});
  keys.number(
      "initial_water_table", f.initial_water_table,
      {"m",
       "Field, instead of `initial_pressure_head`: elevation of the water table at time zero, with water at rest "
       "below and above."});
  keys.choice<FluidCase::Scheme>(
      "scheme", f.scheme, scheme_words,
      {"",
       "`projection`: pressure solved to a tolerance; `eisph`: explicit sweeps, Eqs. (82)-(85), in windows short "
       "enough for them; `eisph_explicit_drag`: with the drag of Eq. (75) at the window's start."});
  std::int64_t sweeps = f.sweeps;
  keys.integer("sweeps", sweeps, {"", "Explicit sweeps per window (`eisph`)."}, between(1, false, 1000, false));
  f.sweeps = static_cast<int>(sweeps);
  keys.number("pressure_tolerance", f.pressure_tolerance,
              {"",
               "`projection`, where no skeleton responds: residual of the pressure solve, relative to what drives the "
               "flow; absent: 2e-5 divided by the contrast between the conductivities of the soils, 1e-3 in free water "
               "without soil."},
              between(0, true, 1, true));
  keys.point("initial_velocity", f.initial_velocity, {"m/s", "Velocity of all water at time zero."});
  keys.number("initial_strain", f.initial_strain,
              {"1/s",
               "Rate s of the plane straining flow (s x, -s y) about the origin, which is added to the initial "
               "velocity."});
  keys.number("initial_wave", f.initial_wave,
              {"m/s",
               "Speed, at the ends of the surface, of the lowest sloshing mode along x of the first region, which "
               "is added to the initial velocity."});
  keys.number(
      "initial_vortices", f.initial_vortices,
      {"m/s",
       "Highest speed of Taylor-Green vortices, one period over the periodic box in x and y, which are added to the "
       "initial velocity."});
  keys.point("offset", f.offset, {"spacings", "Position of the first particle, from the lower corner of a region."});
  keys.number("jitter", f.jitter, {"spacings", "Largest random displacement of the initial lattice."},
              between(0, false, 1, false));
  declare_seed(keys, f.seed);
  keys.flag("drag", f.drag, {"", "Seepage force between the phases."});
  keys.choice<FluidCase::DragForm>(
      "drag_form", f.drag_form, form_words,
      {"",
       "`pointwise`: Eqs. (64)/(73), exact for a uniform relative velocity; `smoothed`: Eqs. (67)/(74), a sum over "
       "pairs that depends on how the two lattices lie, G = d; `smoothed_as_printed`: G = 1/d, d^2 times too weak "
       "(rigid soil only)."});
  keys.flag("skeleton_response", f.skeleton_response,
            {"",
             "The pressure solve includes a prediction of the skeleton's motion; false: plain staggering, to show its "
             "limit (docs/stability.md)."});
  keys.tables("region", "Where water stands at time zero; inside soil it fills the pores.", f.regions,
              [](Keys& inner, Shape& shape) { declare(inner, shape); });
}

void declare(Keys& keys, SolidCase& s) {
  keys.choice<MaterialName>(
      "model", s.model, model_words(true),
      {"",
       "`rigid`: the soil does not move, the fluid runs alone; otherwise the material law of all soil that has no "
       "`soil.model`. `drucker_prager_rate`: integrated as in Bui & Nguyen (2017), explicit rates and stress "
       "scaling-back. Without water the solid runs alone."});
  keys.number("particle_spacing", s.particle_spacing,
              {"m", "Distance between soil particles; 0: as fluid.particle_spacing."}, not_negative());
  keys.point("initial_velocity", s.initial_velocity, {"m/s", "Velocity of all soil at time zero."});
  keys.number("initial_wave", s.initial_wave,
              {"m/s",
               "Speed, at the ends of the surface, of the lowest sloshing mode along x of the first soil, which is "
               "added to the initial velocity."});
  keys.point("offset", s.offset, {"spacings", "Position of the first particle, from the lower corner of a soil."});
  keys.number("jitter", s.jitter, {"spacings", "Largest random displacement of the initial lattice."},
              between(0, false, 1, false));
  declare_seed(keys, s.seed);
  keys.flag(
      "initial_rest", s.initial_rest,
      {"", "Before time zero the soil is brought to rest under gravity, the water and the loads without `start`."});
  keys.flag("initial_seepage", s.initial_seepage,
            {"",
             "The soil is brought to rest under the seepage force, too, of water that flows steadily under the "
             "pressure of time zero; false: the water begins to flow at time zero. `poretwin safety` always includes "
             "that force."});
  keys.choice<SolidCase::PressureGradient>(
      "pressure_gradient", s.pressure_gradient, gradient_words,
      {"",
       "How the gradient of the pore pressure on the soil is summed. `difference`: Eq. (62) as corrected; `sum`: "
       "Eq. (61), which expels particles at the soil's surface."});
  keys.number("strength_reduction", s.strength_reduction,
              {"",
               "Factor by which cohesion and tan(friction) of all soil are divided (`poretwin safety` finds the one at "
               "which the slope fails)."},
              positive());
  keys.optional_table("quiet",
                      "Work saved while the soil hardly moves; absent: all its motion is computed. Elastic soil with "
                      "water is then in equilibrium at the end of every window, as it is of long ones anyway.",
                      s.quiet, [](Keys& inner, Quiet& quiet) { declare(inner, quiet); });
  keys.number(
      "courant", s.courant,
      {"",
       "Substep over the time in which an elastic wave crosses one spacing; absent: 1 for soil without water (grains "
       "without cohesion on rough walls 1.4, in 3D 1.3), 0.8 with water and in searches for rest. At the tips of "
       "elastic slopes up to 1.07 is stable."},
      between(0, true, 2, false));
  keys.number("list_skin", s.list_skin,
              {"spacings",
               "Distance by which pair lists reach beyond the kernel's support; a list is kept until neighbours have "
               "moved against each other by as much."},
              not_negative());
  keys.number("artificial_viscosity", s.artificial_viscosity,
              {"", "alpha of Monaghan's artificial viscosity, which acts on particles that approach each other."},
              not_negative());
  keys.number("quadratic_viscosity", s.quadratic_viscosity,
              {"", "beta of Monaghan's artificial viscosity, of the term with the square of the speed of approach."},
              not_negative());
  keys.number(
      "artificial_stress", s.artificial_stress,
      {"",
       "epsilon of the artificial stress of Gray et al. (2001), which keeps cohesive soil in tension from clumping."},
      not_negative());
  keys.number("hourglass_viscosity", s.hourglass_viscosity,
              {"",
               "Viscosity on the part of the velocity that is not linear around a particle, against hourglass modes; "
               "off where the soil flows."},
              not_negative());
  keys.flag(
      "regular_flow", s.regular_flow,
      {"",
       "Stress, density and packing of flowing soil are evened out (docs/theory/soil.md); false: they are not, to show "
       "what that is for."});
  keys.number("hourglass_stiffness", s.hourglass_stiffness,
              {"",
               "Stiffness on the part of the displacement that is not linear around a particle, over the constrained "
               "modulus M. Its stress is at most 0.3 % of the shear stress where soil has yielded; off where the soil "
               "flows."},
              not_negative());
}

void declare(Keys& keys, CouplingCase& c) {
  keys.number("interval", c.interval, {"s", "Longest exchange interval; absent: what the solvers propose."},
              positive());
  keys.choice<CouplingCase::Scheme>(
      "scheme", c.scheme, coupling_words,
      {"",
       "`iterated`: the fluid crosses a window, then the solid, and both again while the solid's motion departs from "
       "the one that the fluid predicted by more than `tolerance` allows; `serial`: each crosses it once, the default "
       "where the fluid predicts nothing (fluid.skeleton_response = false, explicit schemes); `parallel`: once, both "
       "at the same time, each with the other's fields of the window's start. Their limits: docs/theory/coupling.md."});
  keys.choice<CouplingCase::Acceleration>(
      "acceleration", c.acceleration, acceleration_words,
      {"",
       "`iterated` where the fluid predicts nothing (fluid.skeleton_response = false): how the next pass is guessed "
       "from the last ones, `none`, `aitken` (one factor), `quasi_newton` (IQN-ILS)."});
  keys.number("tolerance", c.tolerance,
              {"1",
               "`iterated`: largest force, over the weight, that may be missing in the soil's balance when a window is "
               "accepted (absent: 0.02 after the first pass through it, 0.003 after the others). Where the fluid "
               "predicts nothing: largest change of a velocity or force from one pass to the next, relative to its "
               "norm (absent: 1e-6)."},
              positive());
  keys.flag("keep_points", c.keep_points,
            {"",
             "Soil that has not moved does not send its points again, and the coupler keeps the pairs that it found; "
             "false: always sent, to show what that saves."});
}

void declare(Keys& keys, OutputCase& o) {
  keys.number("interval", o.interval, {"s", "Interval between frames; 0: the first and the last only."},
              not_negative());
  keys.number("gauge_interval", o.gauge_interval,
              {"s", "Interval between gauge readings; 0: a reading after every window."}, not_negative());
}

void declare(Keys& keys, Gauge& g) {
  keys.text(
      "name", g.name,
      {"", "Name of the series, without commas, quotes and line breaks; `name[i]` where there are several points.",
       true});
  keys.text("phase", g.phase, {"", "`fluid` or `solid`.", true});
  keys.text("kind", g.kind, {"", "What is read: [kinds of gauges](#kinds-of-gauges).", true});
  keys.text("quantity", g.quantity,
            {"",
             "With `point`: an output field, with `_x` `_y` `_z` or `_xx` `_yy` .. for one component. With `momentum`: "
             "one component, `momentum_x`, `momentum_y` or `momentum_z`. With `level`, `passed_volume` and, of a "
             "field, `discharge`: name of the face or well. With `infiltration`, `evaporation`, `runoff`: name of the "
             "rain."});
  keys.points("points", g.points,
              {"m",
               "Places of the readings; for a line or a direction its two ends; a face is walked with the domain on "
               "the left."});
  keys.number("pressure_head", g.pressure_head,
              {"m", "`front` of a field: the pressure head whose place is read; 0: the water table."});
  keys.number("thickness", g.thickness,
              {"m", "`front` of the soil: how thick the soil must be there; 0: its farthest particle, the tip."},
              not_negative());
  keys.number(
      "every", g.every,
      {"s",
       "`factor_of_safety`: it is read with the other gauges for the first time after each multiple of this; each "
       "reading is a search of its own."},
      positive());
  keys.optional_table("region",
                      "Where the particles lie of which `volume`, `momentum`, .. are taken; absent: everywhere.",
                      g.region, [](Keys& inner, Shape& shape) { declare(inner, shape); });
}

/// Declares the sections on which both solvers must agree.
void declare_shared(Keys& keys, Case& c) {
  keys.table("case", "The problem as a whole.", [&](Keys& inner) { declare(inner, c.general); });
  keys.dimension = c.general.dimension;
  keys.table("water", "The pore fluid.", [&](Keys& inner) { declare(inner, c.water); });
  keys.tables("soil",
              "A region of soil and its material. With solid.model = \"rigid\" only shape, porosity and the law of "
              "seepage matter.",
              c.soils, [](Keys& inner, Soil& soil) { declare(inner, soil); });
  keys.tables("wall", "A wall and its meaning for either phase.", c.walls,
              [](Keys& inner, Wall& wall) { declare(inner, wall); });
  keys.tables("water_face",
              "A face through which water comes and goes: of prescribed head or pressure, of a basin, or an outlet.",
              c.water_faces, [](Keys& inner, WaterFace& face) { declare(inner, face); });
  keys.tables("load", "A traction on the soil's surface.", c.loads,
              [](Keys& inner, Load& load) { declare(inner, load); });
  keys.tables(
      "plate",
      "A rigid plate or footing on the soil's surface, a straight line (2D) or a rectangle along the axes (3D). "
      "It moves in a prescribed way or under a force, without turning unless it `tilts`. To water as a field (2D) it "
      "is tight where no [[water_face]] lies on it.",
      c.plates, [](Keys& inner, Plate& plate) { declare(inner, plate); });
  keys.table("coupling", "How the phases exchange.", [&](Keys& inner) { declare(inner, c.coupling); });
}

void declare_own(Keys& keys, Case& c) {
  keys.tables("pore_pressure",
              "Water in the pores of soil that runs alone: it fills them where its pressure is above zero, and acts on "
              "the skeleton by buoyancy and seepage, rho_w g - grad p per volume.",
              c.pore_pressures, [](Keys& inner, PorePressure& p) { declare(inner, p); });
  keys.tables("rain", "Rain on the soil's surface, or evaporation from it. With fluid.representation = \"field\".",
              c.rains, [](Keys& inner, Rain& rain) { declare(inner, rain); });
  keys.tables("well", "A well, or in 2D a drain across the section. With fluid.representation = \"field\".", c.wells,
              [](Keys& inner, Well& well) { declare(inner, well); });
  keys.table("fluid", "The water phase.", [&](Keys& inner) { declare(inner, c.fluid); });
  keys.table("solid", "The soil phase.", [&](Keys& inner) { declare(inner, c.solid); });
  keys.table("output", "What is written, and when.", [&](Keys& inner) { declare(inner, c.output); });
  keys.tables("gauge", "A series of readings in gauges.csv.", c.gauges,
              [](Keys& inner, Gauge& gauge) { declare(inner, gauge); });
}

}  // namespace

double Series::at(double t) const {
  if (knots.empty()) return 0.0;
  if (t <= knots.front().first) return knots.front().second;
  for (std::size_t i = 1; i < knots.size(); ++i) {
    const auto& [t0, v0] = knots[i - 1];
    const auto& [t1, v1] = knots[i];
    if (t <= t1) return v0 + (v1 - v0) * (t - t0) / (t1 - t0);
  }
  return knots.back().second;
}

double WaterFace::wave(double x, double t) const {
  if (!wave_amplitude) return 0.0;
  constexpr double turn = 2.0 * std::numbers::pi;
  return wave_amplitude->at(t) * std::cos(turn * x / wave_length) * std::cos(turn * t / wave_period);
}

double Series::integral(double t0, double t1) const {
  if (t1 < t0) return -integral(t1, t0);
  // Sums trapezoids between the knots.
  double sum = 0.0, from = t0;
  for (const auto& [t, value] : knots) {
    if (t <= from || t >= t1) continue;
    sum += 0.5 * (t - from) * (at(from) + at(t));
    from = t;
  }
  return sum + 0.5 * (t1 - from) * (at(from) + at(t1));
}

namespace {

/// Sets the defaults of the scheme of Bui & Nguyen (2017); docs/theory/paper.md lists them.
void take_paper_defaults(Case& c) {
  c.fluid.scheme = FluidCase::Scheme::eisph_explicit_drag;
  c.fluid.drag_form = FluidCase::DragForm::smoothed;
  c.fluid.skeleton_response = false;
  c.solid.courant = 0.2;
  c.solid.hourglass_viscosity = c.solid.hourglass_stiffness = 0.0;
  c.solid.regular_flow = false;
}

/// Sets the members of a soil that follow from other keys.
void complete(Soil& soil, double spacing) {
  soil.band_width = band_width * spacing;
  if (!soil.undrained_strength) return;
  soil.cohesion = *soil.undrained_strength;
  soil.friction_angle = soil.dilation_angle = 0.0;
  if (!soil.tensile_strength) soil.tensile_strength = 0.0;
}

}  // namespace

std::optional<std::pair<std::string, std::string>> lacks_strength(const Case& scene) {
  if (!scene.can_yield())
    return {{"solid.model",
             "a factor of safety needs soil that can fail; expected \"mohr_coulomb\" or \"drucker_prager\""}};
  for (std::size_t i = 0; i < scene.soils.size(); ++i)
    if (const Material kind = material(scene.model_of(scene.soils[i])); kind.can_yield() && !kind.has_strength())
      return {{fmt::format("soil[{}].model", i),
               fmt::format("\"{}\" has no strength that a factor could divide; expected a material with cohesion and "
                           "friction",
                           kind.name)}};
  return {};
}

Material material(MaterialName name) {
  const auto all = materials();
  const auto found = std::ranges::find(all, name.name, &Material::name);
  if (found == all.end())
    throw CaseError(fmt::format("there is no material \"{}\": expected a name that soil.model may have", name.name));
  return *found;
}

double constrained_modulus(const Case& scene, const Soil& soil) {
  const Point3 down = scene.general.gravity;
  double bottom = HUGE_VAL, top = -HUGE_VAL, heaviest = 0.0;
  for (const Soil& other : scene.soils) {
    const double g = down.norm();
    const auto [lowest, highest] =
        extent(other.shape, g > 0.0 ? Point3(-down / g) : Point3::UnitY(), scene.general.dimension);
    bottom = std::min(bottom, lowest);
    top = std::max(top, highest);
    heaviest = std::max(heaviest, (1.0 - other.porosity) * other.grain_density * g);
  }
  return constrained_modulus(scene.model_of(soil), soil, 0.5 * heaviest * (top - bottom));
}

bool Case::erodes() const {
  return std::ranges::any_of(soils, [](const Soil& soil) { return soil.erosion.has_value(); });
}

bool Case::can_yield() const {
  return deformable() &&
         std::ranges::any_of(soils, [this](const Soil& soil) { return material(model_of(soil)).can_yield(); });
}

std::string Case::coupled_part() const {
  Case copy = *this;
  std::string part = list_keys([&](Keys& keys) { declare_shared(keys, copy); });
  // The files of shapes may differ between machines: hence the points of the meshes are part of the text.
  for (const Soil& soil : soils)
    if (soil.shape.solid)
      for (const auto& body : soil.shape.solid->parts())
        for (const Point3& x : body.mesh.triangles().points)
          part += fmt::format("{:.17g} {:.17g} {:.17g}\n", x.x(), x.y(), x.z());
  return part;
}

std::string Case::digest() const { return fmt::format("{:016x}", fnv1a(coupled_part())); }

Case read_case(const std::filesystem::path& path, const std::vector<std::string>& overrides) {
  Case scene;
  scene.path = path;
  scene.overrides = overrides;
  scene.text = read_text(path);
  Node root = parse_document(scene.text, path.string());
  for (const auto& assignment : overrides) apply_override(root, assignment);
  if (root.entries.empty())
    throw CaseError(
        fmt::format("{}: the file is empty; expected a case: a table [case] with end_time, and what is in it "
                    "(docs/case-file.md lists all keys)",
                    path.string()));
  const auto old_words = replace_old_words(root);
  if (const Node* soils = root.find("soil")) expect_kinds(*soils, "soil");
  if (const Node* fluid = root.find("fluid"))
    if (const Node* regions = fluid->find("region")) expect_kinds(*regions, "fluid.region");
  const Node* general = root.find("case");
  const Node* preset = general ? general->find("scheme") : nullptr;
  const bool paper = preset && preset->text == "paper";
  Places places;
  read_keys(
      root,
      [&](Keys& keys) {
        declare_shared(keys, scene);
        if (paper) take_paper_defaults(scene);
        declare_own(keys, scene);
      },
      &places);
  if (paper) {
    const auto integrate_by_rates = [](MaterialName& model) {
      if (model == MaterialName::drucker_prager) model = MaterialName::drucker_prager_rate;
    };
    integrate_by_rates(scene.solid.model);
    for (Soil& soil : scene.soils)
      if (soil.model) integrate_by_rates(*soil.model);
    // The drag can be a sum over pairs only in soil at rest.
    if (scene.coupled() && !places.contains("fluid.drag_form")) scene.fluid.drag_form = FluidCase::DragForm::pointwise;
  }
  if (scene.solid.particle_spacing <= 0.0) scene.solid.particle_spacing = scene.fluid.particle_spacing;
  for (Soil& soil : scene.soils) complete(soil, scene.solid.particle_spacing);
  make_solids(scene, places);
  move_to_origin(scene);
  if (scene.fluid.representation == FluidCase::Representation::automatic) choose_representation(scene, places);
  if (!places.contains("coupling.scheme") && !scene.predicts()) scene.coupling.scheme = CouplingCase::Scheme::serial;
  check_case(scene, places);
  scene.warnings = doubts(scene, places);
  scene.warnings.insert(scene.warnings.begin(), old_words.begin(), old_words.end());
  return scene;
}

std::string case_reference() {
  Case scene;
  return "# The case file\n\n"
         "TOML, SI units, one file for all processes. Points have two coordinates in 2D and three in 3D. "
         "Any key can be set from the command line: `--set fluid.particle_spacing=0.005`, `--set "
         "soil.0.porosity=0.45`. "
         "This page is made from the declarations that read the file (`poretwin case-keys`).\n\n" +
         describe_keys([&](Keys& keys) {
           declare_shared(keys, scene);
           declare_own(keys, scene);
         }) +
         "## Kinds of gauges\n\n" + gauge_kinds_table();
}

}  // namespace poretwin
