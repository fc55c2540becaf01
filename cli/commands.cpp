#include "cli/commands.hpp"

#include "cli/check.hpp"
#include "cli/describe.hpp"
#include "cli/element.hpp"
#include "cli/locate.hpp"
#include "cli/metrics.hpp"
#include "cli/peer.hpp"
#include "cli/run.hpp"
#include "cli/safety.hpp"
#include "cli/safety_of_run.hpp"
#include "cli/script.hpp"
#include "cli/verify.hpp"
#include "common/case/case.hpp"
#include "common/case/materials.hpp"
#include "common/core/error.hpp"
#include "common/core/exit_codes.hpp"
#include "common/coupling/curve_keys.hpp"
#include "common/coupling/standard_contract.hpp"
#include "common/output/build_info.hpp"
#include "solid_solver/material/element.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

namespace poretwin::cli {

struct CommandLine::Arguments {
  std::string which;
  std::filesystem::path out, programs;
  std::string fluid, solid;
  double until = 0.0, tolerance = 0.01;
  Instants instants;
  std::vector<std::string> set;
  bool any_address = false, page = false, no_pictures = false, quiet = false, resume = false, profile = false,
       overwrite = false, accept_changed_program = false, python = false;
  std::optional<double> checkpoint_every;
  int restarts = 2, tiles = 1;
  std::filesystem::path hosts;
  std::string json;
  VerifyOptions verify;
  ElementOptions element;
  std::vector<std::string> words;  ///< arguments that are passed on to a script unchanged
};

namespace {

using Arguments = CommandLine::Arguments;

constexpr const char* program_description =
    "Two-phase SPH for flow through deformable porous media: a fluid and a solid process, coupled.";
constexpr const char* case_help = "name of a folder below cases/, or path to a folder or TOML file";

int run(const Arguments& a, JsonOutput& json) {
  const CasePlace place = find_case(a.which);
  RunOptions options;
  options.case_file = place.file;
  options.case_name = place.name;
  options.out = a.out.empty() ? std::filesystem::path("runs") / place.name : a.out;
  options.overrides = a.set;
  if (a.until > 0.0) options.overrides.push_back(fmt::format("case.end_time={:.17g}", a.until));
  options.programs = a.programs.empty() ? program_folder() : a.programs;
  options.fluid = a.fluid;
  options.solid = a.solid;
  options.quiet = a.quiet;
  options.pictures = !a.no_pictures;
  options.resume = a.resume;
  options.overwrite = a.overwrite;
  options.accept_changed_program = a.accept_changed_program;
  options.checkpoint_every = a.checkpoint_every;
  options.restarts = a.restarts;
  options.profile = a.profile;
  options.tiles = a.tiles;
  options.hosts = a.hosts;
  const RunResult result = run_case(options);
  if (result.exit != 0) fmt::print(stderr, "poretwin: {}\n", result.reason);
  if (json.wanted()) json.write(run_json(place.name, place.file, options.out, result));
  return result.exit;
}

int safety_of_run(const Arguments& a, JsonOutput& json) {
  if (!a.set.empty())
    throw CaseError("--set: the soil is that of the run, with the keys of the run; run the case again with other keys");
  SafetyOfRunOptions options;
  options.run = a.which;
  options.out = a.out;
  options.instants = a.instants;
  options.tolerance = a.tolerance;
  options.programs = a.programs.empty() ? program_folder() : a.programs;
  options.quiet = a.quiet;
  options.pictures = !a.no_pictures;
  const SafetyOfRun found = find_safety_of_run(options);
  if (found.exit != 0)
    fmt::print(stderr, "poretwin: {}\n", found.reason);
  else
    fmt::print("{}", safety_of_run_text(found));
  if (json.wanted()) json.write(safety_of_run_json(options, found));
  return found.exit;
}

int safety(const Arguments& a, JsonOutput& json) {
  if (is_run_folder(a.which)) return safety_of_run(a, json);
  if (!a.instants.at.empty() || a.instants.every)
    throw CaseError(
        fmt::format("--at, --every: expected the folder of a run that has ended, with a run.toml, found {}; "
                    "`poretwin run` makes one of a case",
                    a.which));
  const CasePlace place = find_case(a.which);
  RunOptions options;
  options.case_file = place.file;
  options.case_name = place.name;
  options.out = a.out.empty() ? std::filesystem::path("runs") / (place.name + "-safety") : a.out;
  options.overrides = a.set;
  options.programs = a.programs.empty() ? program_folder() : a.programs;
  options.quiet = a.quiet;
  options.pictures = !a.no_pictures;
  const Safety found = find_safety(options, a.tolerance);
  if (found.run.exit != 0)
    fmt::print(stderr, "poretwin: {}\n", found.run.reason);
  else
    fmt::print("{}", safety_text(found));
  if (json.wanted()) json.write(safety_json(options, a.tolerance, found));
  return found.run.exit;
}

int element(const Arguments& a, JsonOutput& json) {
  const CasePlace place = find_case(a.which);
  ElementOptions options = a.element;
  options.case_file = place.file;
  options.case_name = place.name;
  options.out = a.out.empty() ? std::filesystem::path("runs") / (place.name + "-element") : a.out;
  options.overrides = a.set;
  options.pictures = !a.no_pictures;
  const ElementResult result = run_element(options);
  fmt::print("{}", element_text(options, result));
  if (json.wanted()) json.write(element_json(options, result));
  if (result.failure.empty()) return 0;
  fmt::print(stderr, "poretwin: {}\n", result.failure);
  return static_cast<int>(ExitCode::in_doubt);
}

int check(const Arguments& a, JsonOutput& json) {
  const Case scene = read_case(find_case(a.which).file, a.set);
  expect_memory(scene);
  const CheckReport report = report_of(scene);
  fmt::print("{}", check_text(scene, report));
  if (json.wanted()) json.write(check_json(scene, report));
  return 0;
}

/// The arguments given to a command, without --json, as the command line of a script that has the same options.
/// Accepts finite numbers above `least`, or from `least` on; "nan" and "inf" are read as numbers, too.
CLI::Validator finite(const char* name, double least = -HUGE_VAL, bool from_it = true) {
  return {[=](const std::string& word) {
            const double number = std::strtod(word.c_str(), nullptr);
            if (std::isfinite(number) && (number > least || (from_it && number == least))) return std::string();
            return std::isinf(least)
                       ? fmt::format("expected a finite number, found {}", word)
                       : fmt::format("expected a finite number {} {:g}, found {}", from_it ? ">=" : ">", least, word);
          },
          name};
}
CLI::Validator any_finite() { return finite(""); }
CLI::Validator positive() { return finite("POSITIVE", 0.0, false); }
CLI::Validator non_negative() { return finite("NONNEGATIVE", 0.0); }

std::vector<std::string> words_of(const CLI::App& command) {
  std::vector<std::string> positional, words;
  for (const CLI::Option* option : command.get_options()) {
    if (option->count() == 0 || option->get_lnames() == std::vector<std::string>{"json"}) continue;
    const auto& given = option->results();
    if (option->get_positional()) {
      positional.insert(positional.end(), given.begin(), given.end());
      continue;
    }
    words.push_back("--" + option->get_lnames().front());
    if (option->get_items_expected_max() > 0) words.insert(words.end(), given.begin(), given.end());
  }
  positional.insert(positional.end(), words.begin(), words.end());
  return positional;
}

int bench(const Arguments& a, const CLI::App& command, JsonOutput& json) {
  auto words = words_of(command);
  words.insert(words.end(), {"--program", program_folder() / "poretwin"});
  const int exit = run_script("bench/study.py", words);
  if (!json.wanted()) return exit;
  const auto tables = a.out / "bench.json";
  auto all = json_head("bench", exit, exit == 0 ? "end" : "bench/study.py has failed; stderr says why");
  all["out"] = a.out.string();
  all["parts"] = nlohmann::ordered_json::object();
  if (exit == 0) {
    std::ifstream stream(tables);
    all["parts"] = nlohmann::ordered_json::parse(stream, nullptr, false);
    if (!all["parts"].is_object()) throw FileError(tables.string() + ": expected the tables of the benchmark as JSON");
  }
  json.write(all);
  return exit;
}

/// Writes the report of a run. The script gets the defaults of the materials' own keys, which it shows for soils whose
/// case leaves them out: {"mu_i": {"static_friction": 0.38, ..}, ..}.
int report(const CLI::App& command) {
  nlohmann::json defaults = nlohmann::json::object();
  for (const Material& material : materials())
    for (const MaterialKey& key : material.keys)
      defaults[std::string(material.name)][std::string(key.name)] = key.standard;
  auto words = words_of(command);
  words.insert(words.end(), {"--material-defaults", defaults.dump()});
  return run_script("cli/report.py", words);
}

/// Declares all commands; parsing sets `action` to the chosen one.
void declare(CLI::App& app, Arguments& a, JsonOutput& json, std::function<int()>& action) {
  app.require_subcommand(1);
  app.set_version_flag("--version", "poretwin " + version() + ", " + build(), "print version, build and commit");
  app.footer(exit_codes_text());
  const auto with_case = [&](CLI::App* command, const std::string& help = case_help) {
    command->add_option("CASE", a.which, help)->required()->type_name("");
    command->add_option("--set", a.set, "override a key of the case: section.key=value, soil.0.porosity=0.35")
        ->take_all()
        ->allow_extra_args(false)
        ->type_name("KEY=VALUE");
  };
  const auto with_programs = [&](CLI::App* command) {
    command
        ->add_option("--programs", a.programs,
                     "folder of poretwin-fluid, poretwin-solid, poretwin-coupler (default: beside poretwin)")
        ->type_name("DIR");
  };
  const auto with_tiles = [](CLI::App* command, int& tiles) {
    command
        ->add_option(
            "--tiles", tiles,
            "number of processes that share the water, or dry soil, each with a tile of space (mpirun); beside "
            "water, one process computes the soil that moves")
        ->type_name("P")
        ->check(CLI::Range(1, 4096).description(""))
        ->capture_default_str();
  };
  const auto with_json = [&](CLI::App* command) {
    command
        ->add_option("--json", a.json,
                     "write the result as JSON, too (docs/json.md); -: to stdout, and all other output to stderr")
        ->type_name("FILE");
  };
  const auto does = [&](CLI::App* command, std::function<int()> what) {
    command->callback([&a, &json, &action, command, what = std::move(what)] {
      action = [&a, &json, command, what] {
        if (!a.json.empty()) json.open(command->get_name(), a.json);
        return what();
      };
    });
  };
  auto* run_command = app.add_subcommand("run", "Run a case: progress, summary, pictures");
  with_case(run_command);
  with_programs(run_command);
  run_command->add_option("--out", a.out, "folder of the run (default runs/CASE)")->type_name("DIR");
  run_command->add_option("--until", a.until, "simulated time at which to end [s]")->type_name("T")->check(positive());
  run_command
      ->add_option("--fluid", a.fluid, "command to run in place of the fluid solver, such as \"python3 my_fluid.py\"")
      ->type_name("COMMAND");
  run_command->add_option("--solid", a.solid, "command to run in place of the solid solver")->type_name("COMMAND");
  auto* resume = run_command->add_flag("--resume", a.resume,
                                       "go on from the last checkpoint of the run in that folder; a run that has "
                                       "finished is left as it is");
  run_command
      ->add_flag("--overwrite", a.overwrite,
                 "begin anew in a folder whose run was broken off, can be resumed or is of another case: its results "
                 "and checkpoints go")
      ->excludes(resume);
  run_command
      ->add_flag("--accept-changed-program", a.accept_changed_program,
                 "resume although the programs are not those that began: the results are then of both")
      ->needs(resume);
  run_command
      ->add_option("--checkpoint-every", a.checkpoint_every,
                   "wall-clock between checkpoints [s] (default 60); 0: after every window, inf: on Ctrl-C only")
      ->type_name("S")
      ->check(CLI::Range(0.0, std::numeric_limits<double>::infinity()).description(""));
  run_command->add_option("--restarts", a.restarts, "after a crash, from the last checkpoint, at most so often")
      ->type_name("N")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  with_tiles(run_command, a.tiles);
  run_command
      ->add_option(
          "--hosts", a.hosts,
          "machines for the processes of --tiles: a hostfile of mpirun (\"NAME slots=N\" a line), this machine first; "
          "all have the programs and the case at the same paths")
      ->type_name("FILE")
      ->check(CLI::ExistingFile.description(""));
  run_command->add_flag("--no-pictures", a.no_pictures, "draw no pictures at the end");
  run_command->add_flag("--profile", a.profile,
                        "leave trace.json: what each process did when, for chrome://tracing or ui.perfetto.dev");
  run_command->add_flag("--quiet", a.quiet, "neither progress nor summary");
  with_json(run_command);
  does(run_command, [&] { return run(a, json); });

  auto* safety_command = app.add_subcommand(
      "safety", "Find the factor of safety: the soil's strength is reduced until it finds no equilibrium");
  with_case(safety_command, std::string(case_help) +
                                ": the soil at time zero; or the folder of a run that has ended: its soil at the times "
                                "of --at and --every");
  with_programs(safety_command);
  safety_command
      ->add_option("--at", a.instants.at,
                   "of a run: times [s], comma-separated; the nearest frames are taken (default: the last frame)")
      ->delimiter(',')
      ->type_name("T,...");
  safety_command->add_option("--every", a.instants.every, "of a run: at the multiples of this time [s], too")
      ->type_name("T")
      ->check(positive());
  safety_command->add_option("--out", a.out, "folder of the results (default runs/CASE-safety, of a run RUN/safety)")
      ->type_name("DIR");
  safety_command->add_option("--tolerance", a.tolerance, "width of the bracket over the factor")
      ->type_name("X")
      ->check(any_finite())
      ->check(CLI::Range(1e-4, 0.5))
      ->capture_default_str();
  safety_command->add_flag("--no-pictures", a.no_pictures, "do not draw the failure surface");
  safety_command->add_flag("--quiet", a.quiet, "the factor only");
  with_json(safety_command);
  does(safety_command, [&] { return safety(a, json); });

  ElementOptions& e = a.element;
  auto* element_command = app.add_subcommand(
      "element", "Test one soil of a case as in a laboratory: a path of strain or stress, without any particles");
  with_case(element_command);
  std::string tests;
  for (const auto& test : solid::laboratory_tests()) tests += fmt::format("{}{}", tests.empty() ? "" : ", ", test.name);
  element_command->add_option("--test", e.test, tests)->required()->type_name("TEST");
  element_command->add_option("--soil", e.soil, "name or number of the soil (default: the first)")->type_name("SOIL");
  element_command->add_option("--pressure", e.pressure, "vertical effective stress at the start [Pa]")
      ->required()
      ->type_name("PA")
      ->check(non_negative());
  element_command->add_option("--ratio", e.ratio, "horizontal over vertical effective stress at the start")
      ->type_name("K")
      ->check(non_negative())
      ->capture_default_str();
  auto* strains = element_command->add_option(
      "--strain", e.strains,
      "axial strain to reach, compression positive, or shear strain; several: one after the other");
  strains->type_name("STRAIN")->check(any_finite())->expected(1, CLI::detail::expected_max_vector_size);
  auto* loads = element_command->add_option(
      "--stress", e.loads,
      "in place of --strain: the axial effective stress to reach [Pa], in undrained compression the "
      "deviator, in shear the shear stress");
  loads->type_name("PA")->check(any_finite())->expected(1, CLI::detail::expected_max_vector_size)->excludes(strains);
  element_command
      ->add_option("--rate", e.rate,
                   "rate of the prescribed strain [1/s], where the strength depends on it "
                   "(default: very slow)")
      ->type_name("RATE")
      ->check(positive())
      ->excludes(loads);
  element_command->add_option("--steps", e.steps, "from one value to the next")
      ->type_name("N")
      ->check(CLI::Range(1, 10000000))
      ->capture_default_str();
  element_command->add_option("--out", a.out, "folder of table and picture (default runs/CASE-element)")
      ->type_name("DIR");
  element_command->add_flag("--no-pictures", a.no_pictures, "draw no picture");
  with_json(element_command);
  does(element_command, [&] {
    if (e.strains.empty() && e.loads.empty())
      throw CaseError("--strain: expected the strain to reach, or --stress with a stress, found neither");
    return element(a, json);
  });

  auto* check_command = app.add_subcommand("check", "Validate a case; print particles, stable intervals, memory");
  with_case(check_command);
  with_json(check_command);
  does(check_command, [&] { return check(a, json); });

  VerifyOptions& v = a.verify;
  auto* verify_command = app.add_subcommand("verify", "Run a case, or all, and compare it with its reference");
  verify_command->add_option("CASE", v.which, std::string(case_help) + ", or 'all'")->required()->type_name("");
  with_programs(verify_command);
  with_json(verify_command);
  verify_command->add_option("--report", v.report, "folder for one page with the errors, run times and pictures")
      ->type_name("DIR");
  verify_command->add_option("--out", v.out, "folder of the runs")->type_name("DIR")->capture_default_str();
  verify_command->add_option("--run", v.run, "only this run of the case")->type_name("NAME");
  verify_command->add_option("--set", v.overrides, "override a key of every run: section.key=value")
      ->take_all()
      ->allow_extra_args(false)
      ->type_name("KEY=VALUE");
  verify_command->add_flag("--short", v.short_runs, "the short form of each run");
  with_tiles(verify_command, v.tiles);
  does(verify_command, [&] {
    v.programs = a.programs.empty() ? program_folder() : a.programs;
    return verify(v, json);
  });

  auto* plot_command =
      app.add_subcommand("plot", "Draw fields and gauges of a run, or all of its frames as an animation");
  plot_command->add_option("RUN", a.words, "folder of a run, or of what `poretwin verify CASE` has run")
      ->required()
      ->expected(1)
      ->type_name("");
  const auto word = [&](CLI::App* command, const char* name, const char* type, const char* about_it, int most = 1) {
    return command->add_option(name, a.words, about_it)->expected(1, most)->type_name(type);
  };
  constexpr int many = CLI::detail::expected_max_vector_size;
  word(plot_command, "--field", "FIELD",
       "field, or a component of one: pore_pressure, velocity_x, effective_stress_yy");
  word(plot_command, "--time", "T", "the frames nearest to these times [s], in one picture (default: the last)", many);
  word(plot_command, "--phase", "", "default: every phase that has the field")
      ->check(CLI::IsMember({"fluid", "solid"}));
  word(plot_command, "--gauge", "GAUGE", "only these gauges, in one picture each", many);
  word(plot_command, "--format", "", "of the pictures (default png); svg and pdf for printing")
      ->check(CLI::IsMember({"png", "svg", "pdf"}));
  word(plot_command, "--animate", "FILE", "all frames, as FILE.gif or FILE.mp4");
  word(plot_command, "--out", "DIR", "folder of the pictures (default: RUN/pictures)");
  does(plot_command, [plot_command] { return draw_pictures(words_of(*plot_command), {}); });

  auto* report_command = app.add_subcommand(
      "report", "An engineer's report of a run as one page: section, state, gauges, safety, balance, warnings");
  report_command->add_option("RUN", a.words, "folder of a run")->required()->expected(1)->type_name("");
  word(report_command, "--out", "FILE", "FILE.html or FILE.pdf (default: RUN/report.html); a PDF needs chromium");
  does(report_command, [report_command] { return report(*report_command); });

  auto* view_command = app.add_subcommand("view", "Look at runs, finished or under way, in a browser");
  view_command->add_option("RUN", a.words, "folder of a run, or a folder with runs below it (default: runs)")
      ->expected(0, many)
      ->type_name("");
  word(view_command, "--port", "N", "port (default: the first free one from 8470 on)");
  word(view_command, "--bind", "ADDRESS", "address to listen at (default 127.0.0.1, this machine only)");
  word(view_command, "--cases", "DIR", "folders of cases whose references are drawn, beside cases/", many);
  view_command->add_flag("--allow-any-address", a.any_address,
                         "let --bind take an address that other machines reach; nothing is encrypted");
  does(view_command, [view_command] {
    auto words = words_of(*view_command);
    words.insert(words.end(), {"--built", view_folder()});
    // The server replaces this process, so that Ctrl-C and other signals reach it.
    become_script("view/server.py", words);
    return 0;
  });

  auto* bench_command =
      app.add_subcommand("bench", "Error against run time, by scheme and resolution: tables, pictures");
  word(bench_command, "PART", "", "jobs, kernels, sizes, solve, coupling, skipped, or a case (default: all)", many);
  word(bench_command, "--schemes", "SCHEME", "of the studies (default: all)", many);
  word(bench_command, "--spacings", "X", "coarse to fine [m] (default: the study's own)", many);
  word(bench_command, "--repeats", "N", "runs of which the median is taken (default 1)");
  word(bench_command, "--longest", "S", "wall-clock of a run of a study [s] (default 60)");
  word(bench_command, "--sizes", "N", "particles, of the table of sizes", many);
  word(bench_command, "--threads", "N", "of the solvers, in the table of sizes", many);
  bench_command->add_option("--out", a.out, "folder of tables and pictures (default runs/bench)")->type_name("DIR");
  bench_command->add_flag("--page", a.page, "put page and pictures into docs/ of the source tree");
  with_json(bench_command);
  does(bench_command, [&, bench_command] {
    if (a.out.empty()) a.out = "runs/bench";
    return bench(a, *bench_command, json);
  });

  declare_peer(app, action);
  auto* keys_command =
      app.add_subcommand("keys", "Make the two keys of an encrypted run: DIR/coupler.key, DIR/participant.key");
  keys_command->add_option("DIR", a.out, "folder of the keys")->required()->type_name("");
  keys_command->callback([&] {
    action = [&] {
      coupling::write_curve_keys(a.out);
      fmt::print(
          "{0}/coupler.key: for the coupler, keep it there\n{0}/participant.key: for the machines of the solvers\n",
          a.out.string());
      return 0;
    };
  });
  app.add_subcommand("case-keys", "Print the reference of all keys of a case file (Markdown)")->callback([&] {
    action = [] {
      fmt::print("{}", case_reference());
      return 0;
    };
  });
  auto* fields_command = app.add_subcommand(
      "exchange-fields", "Print the fields that the solvers exchange, with units and bounds (Markdown)");
  fields_command->add_flag("--python", a.python, "as the Python client lists them");
  fields_command->callback([&] {
    action = [&] {
      fmt::print("{}", a.python ? coupling::python_contract() : coupling::describe_contract());
      return 0;
    };
  });
  app.add_subcommand("verify-keys", "Print the reference of all keys of a verify.toml (Markdown)")->callback([&] {
    action = [] {
      fmt::print("{}", verify_reference());
      return 0;
    };
  });
  declare_describe(app, action);
}

}  // namespace

CommandLine::CommandLine(JsonOutput& json)
    : CLI::App(program_description, "poretwin"), arguments_(std::make_unique<Arguments>()) {
  declare(*this, *arguments_, json, action_);
}
CommandLine::~CommandLine() = default;

}  // namespace poretwin::cli
