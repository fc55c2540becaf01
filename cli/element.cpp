#include "cli/element.hpp"

#include "cli/json_output.hpp"
#include "cli/run_folder.hpp"
#include "cli/script.hpp"
#include "cli/text_file.hpp"
#include "common/case/case.hpp"
#include "common/case/materials.hpp"
#include "common/core/error.hpp"
#include "common/core/exit_codes.hpp"
#include "solid_solver/material/element.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <charconv>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

namespace poretwin::cli {
namespace fs = std::filesystem;
namespace {

using solid::Element;
using solid::LaboratoryTest;

/// Finds a soil by its name or its number in the case; the first soil where `requested` is empty.
std::size_t soil_number(const Case& scene, const std::string& requested) {
  if (scene.soils.empty())
    throw CaseError(fmt::format("{}: key 'soil': expected a soil to be tested, found none", scene.path.string()));
  if (requested.empty()) return 0;
  std::string names;
  for (std::size_t i = 0; i < scene.soils.size(); ++i) {
    const std::string& name = scene.soils[i].name;
    if (name == requested || fmt::format("{}", i) == requested) return i;
    names += fmt::format("{}{}{}", i > 0 ? ", " : "", i, name.empty() ? "" : fmt::format(" (\"{}\")", name));
  }
  throw CaseError(
      fmt::format("--soil {}: {} has no such soil; expected one of {}", requested, scene.path.string(), names));
}

/// Refuses an initial stress that would change before the first strain, because the soil does not bear it or because
/// the test does not allow it.
void check_start(const ElementOptions& options, const LaboratoryTest& test, const Element& sample) {
  Element unstrained = sample;
  try {
    unstrained.strain_by(test, 0.0);
  } catch (const DivergedError&) {
    return;  // the test itself will report it
  } catch (const solid::MaterialFailure&) {
    return;
  }
  constexpr double slack = 1e-4;  // of the initial stress: what a material's own iteration leaves
  if ((unstrained.stress() - sample.stress()).norm() <= slack * sample.stress().norm()) return;
  const double vertical = options.pressure, lateral = options.ratio * options.pressure;
  if (test.name == "isotropic")
    throw CaseError(fmt::format("--ratio {:g}: in the test \"isotropic\" all normal stresses are equal; expected 1",
                                options.ratio));
  throw CaseError(
      fmt::format("--ratio {:g}: the soil cannot bear a lateral stress of {:g} Pa beside a vertical one of {:g} Pa; "
                  "expected a ratio nearer to 1",
                  options.ratio, lateral, vertical));
}

/// One row of the table; compression is positive, as usual in a laboratory.
std::vector<double> row_of(const Element& sample, const LaboratoryTest& test, std::size_t shown) {
  const solid::Tensor &e = sample.strain(), &s = sample.stress();
  std::vector<double> row{-e[1],
                          2.0 * e[3],
                          -solid::trace(e),
                          -s[0],
                          -s[1],
                          -s[2],
                          s[3],
                          sample.pressure(),
                          sample.deviator_stress(),
                          sample.void_ratio(),
                          sample.excess_pore_pressure(test),
                          sample.plastic_strain()};
  for (std::size_t k = 0; k < shown; ++k) row.push_back(sample.state()[k]);
  for (double& number : row) number += 0.0;  // turns -0 into 0
  return row;
}

std::string table_of(const ElementResult& result) {
  std::string text = fmt::format("{}\n", fmt::join(result.names, ","));
  for (const auto& row : result.rows) text += fmt::format("{:.9g}\n", fmt::join(row, ","));
  return text;
}

}  // namespace

ElementResult run_element(const ElementOptions& options) {
  const Case scene = read_case(options.case_file, options.overrides);
  const Soil& soil = scene.soils[soil_number(scene, options.soil)];
  if (!scene.deformable() && !soil.model)
    throw CaseError(
        fmt::format("{}: key 'solid.model': rigid soil has no stress to test; expected a material, as with "
                    "--set 'solid.model=\"mohr_coulomb\"'",
                    options.case_file.string()));
  const LaboratoryTest& test = solid::laboratory_test(options.test);
  const auto model = solid::make_constitutive(scene.model_of(soil), soil);
  solid::Tensor start = solid::Tensor::Zero();
  start[1] = -options.pressure;
  start[0] = start[2] = -options.ratio * options.pressure;
  Element sample(soil, *model, start, scene.water.density * scene.water.kinematic_viscosity);

  check_start(options, test, sample);

  ElementResult result;
  result.names = {"axial_strain",
                  "shear_strain",
                  "volumetric_strain",
                  "stress_xx_Pa",
                  "stress_yy_Pa",
                  "stress_zz_Pa",
                  "stress_xy_Pa",
                  "p_Pa",
                  "q_Pa",
                  "void_ratio",
                  "excess_pore_pressure_Pa",
                  "plastic_strain"};
  const auto variables = model->state_variables();
  for (const auto& variable : variables)
    result.names.push_back(variable.name + (variable.unit == "1" ? "" : "_" + variable.unit));
  const auto add_row = [&] { result.rows.push_back(row_of(sample, test, variables.size())); };
  add_row();
  const bool by_load = !options.loads.empty();
  const double sign = test.shears ? 1.0 : -1.0;  // compression is positive in a laboratory test
  const solid::Tensor& s = sample.stress();
  const auto duration = [&](double step) {
    return options.rate ? std::abs(step) / *options.rate : std::numeric_limits<double>::infinity();
  };
  double at = !by_load ? 0.0 : test.shears ? s[3] : test.undrained ? s[0] - s[1] : -s[1];
  try {
    for (const double to : by_load ? options.loads : options.strains) {
      const double step = (to - at) / options.steps;
      for (int k = 1; k <= options.steps; ++k) {
        if (by_load)
          sample.load_to(test, sign * (at + step * k));
        else
          sample.strain_by(test, sign * step, duration(step));
        add_row();
      }
      at = to;
    }
  } catch (const DivergedError& error) {
    result.failure = error.what();
  } catch (const solid::MaterialFailure& failure) {
    result.failure = failure.what;
  }
  fs::create_directories(options.out);
  write_file(options.out / "element.csv", table_of(result));
  if (options.pictures) {
    const fs::path log = options.out / "element.log";
    if (run_script("cli/element.py", {(options.out / "element.csv").string(), "--test", options.test}, log) != 0)
      fmt::print(stderr, "warning: no picture was drawn; see {}\n", log.string());
  }
  return result;
}

std::string element_text(const ElementOptions& options, const ElementResult& result) {
  std::string text = fmt::format("{}, {} steps; at the end:\n", options.test, result.rows.size() - 1);
  for (std::size_t k = 0; k < result.names.size(); ++k)
    text += fmt::format("  {:<28} {:.6g}\n", result.names[k], result.rows.back()[k]);
  return text + fmt::format("all steps: {}\n", (options.out / "element.csv").string());
}

nlohmann::ordered_json element_json(const ElementOptions& options, const ElementResult& result) {
  const bool ended = result.failure.empty();
  auto json = json_head("element", static_cast<int>(ended ? ExitCode::success : ExitCode::in_doubt),
                        ended ? "end" : result.failure);
  json["case"] = options.case_name;
  json["case_file"] = options.case_file.string();
  json["out"] = options.out.string();
  json["test"] = options.test;
  json["columns"] = result.names;
  json["rows"] = nlohmann::ordered_json::array();
  for (const auto& row : result.rows) {
    auto numbers = nlohmann::ordered_json::array();
    for (const double number : row) numbers.push_back(json_number(number));
    json["rows"].push_back(std::move(numbers));
  }
  return json;
}

}  // namespace poretwin::cli
