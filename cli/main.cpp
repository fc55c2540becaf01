// poretwin: the one command a person types.
#include "cli/check.hpp"
#include "cli/locate.hpp"
#include "cli/metrics.hpp"
#include "cli/peer.hpp"
#include "cli/run.hpp"
#include "cli/safety.hpp"
#include "cli/script.hpp"
#include "cli/verify.hpp"
#include "common/case/case.hpp"
#include "common/core/error.hpp"
#include "common/coupling/curve_keys.hpp"
#include "common/output/build_info.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <limits>
#include <optional>

namespace {

using namespace poretwin;
using namespace poretwin::cli;

constexpr const char* epilogue =
    "CASE is the name of a folder below cases/, or a path to a folder or TOML file.\n"
    "Exit codes: 0 done, 1 unforeseen, 2 bad case or command line, 3 a peer failed, 4 diverged, 5 files, 6 ended, "
    "but the result is in doubt (mass lost, a reference missed, ..), "
    "130 interrupted.";

struct Arguments {
  std::string which;
  std::filesystem::path out, programs;
  std::string fluid, solid;
  double until = 0.0, tolerance = 0.01;
  std::vector<std::string> set;
  bool no_pictures = false, quiet = false, resume = false, profile = false, overwrite = false,
       accept_changed_program = false;
  std::optional<double> checkpoint_every;
  int restarts = 2;
};

int run(const Arguments& a) {
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
  const RunResult result = run_case(options);
  if (result.exit != 0) fmt::print(stderr, "poretwin: {}\n", result.reason);
  return result.exit;
}

int safety(const Arguments& a) {
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
  return found.run.exit;
}

int check(const Arguments& a) {
  const Case scene = read_case(find_case(a.which).file, a.set);
  expect_memory(scene);
  fmt::print("{}", check_text(scene));
  return 0;
}

/// Declares all commands; the chosen one is left in `action`.
void declare(CLI::App& app, Arguments& a, VerifyOptions& v, std::vector<std::string>& script_arguments,
             std::function<int()>& action) {
  app.require_subcommand(1);
  app.set_version_flag("--version", "poretwin " + version() + ", " + build());
  app.footer(epilogue);
  const auto with_case = [&](CLI::App* command) {
    command->add_option("CASE", a.which, "case name or path")->required();
    command->add_option("--set", a.set, "override a key of the case: section.key=value, soil.0.porosity=0.35")
        ->take_all()
        ->allow_extra_args(false);
  };
  const auto with_programs = [&](CLI::App* command) {
    command->add_option("--programs", a.programs,
                        "folder of poretwin-fluid, poretwin-solid, poretwin-coupler (default: beside poretwin)");
  };
  auto* run_command = app.add_subcommand("run", "Run a case: progress, summary, pictures");
  with_case(run_command);
  with_programs(run_command);
  run_command->add_option("--out", a.out, "folder of the run (default runs/CASE)");
  run_command->add_option("--until", a.until, "simulated time at which to end [s]")->check(CLI::PositiveNumber);
  run_command->add_option("--fluid", a.fluid,
                          "command to run in place of the fluid solver, such as \"python3 my_fluid.py\"");
  run_command->add_option("--solid", a.solid, "command to run in place of the solid solver");
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
      ->check(CLI::Range(0.0, std::numeric_limits<double>::infinity()));
  run_command->add_option("--restarts", a.restarts, "after a crash, from the last checkpoint, at most so often")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  run_command->add_flag("--no-pictures", a.no_pictures, "draw no pictures at the end");
  run_command->add_flag("--profile", a.profile,
                        "leave trace.json: what each process did when, for chrome://tracing or ui.perfetto.dev");
  run_command->add_flag("--quiet", a.quiet, "neither progress nor summary");
  run_command->callback([&] { action = [&] { return run(a); }; });

  auto* safety_command = app.add_subcommand(
      "safety", "Find the factor of safety: the soil's strength is reduced until it finds no equilibrium");
  with_case(safety_command);
  with_programs(safety_command);
  safety_command->add_option("--out", a.out, "folder of the trials (default runs/CASE-safety)");
  safety_command->add_option("--tolerance", a.tolerance, "width of the bracket over the factor")
      ->check(CLI::Range(1e-4, 0.5))
      ->capture_default_str();
  safety_command->add_flag("--no-pictures", a.no_pictures, "do not draw the failure surface");
  safety_command->add_flag("--quiet", a.quiet, "the factor only");
  safety_command->callback([&] { action = [&] { return safety(a); }; });

  auto* check_command = app.add_subcommand("check", "Validate a case; print particles, stable intervals, memory");
  with_case(check_command);
  check_command->callback([&] { action = [&] { return check(a); }; });

  auto* verify_command = app.add_subcommand("verify", "Run a case, or all, and hold it against its reference");
  verify_command->add_option("CASE", v.which, "case name, path, or 'all'")->required();
  with_programs(verify_command);
  verify_command->add_option("--json", v.json, "write the results as JSON too");
  verify_command->add_option("--report", v.report, "folder for one page with the errors, run times and pictures");
  verify_command->add_option("--out", v.out, "folder of the runs")->capture_default_str();
  verify_command->add_option("--run", v.run, "only this run of the case");
  verify_command->add_option("--set", v.overrides, "override a key of every run: section.key=value")
      ->take_all()
      ->allow_extra_args(false);
  verify_command->add_flag("--short", v.short_runs, "the short form of each run");
  verify_command->callback([&] {
    action = [&] {
      v.programs = a.programs.empty() ? program_folder() : a.programs;
      return verify(v);
    };
  });

  auto* plot_command = app.add_subcommand("plot", "Draw fields and gauges of a run");
  plot_command->prefix_command();
  plot_command->footer("poretwin plot RUN [--field F] [--time T] [--phase fluid|solid] [--gauge G...] [--out DIR]");
  plot_command->callback([&, plot_command] {
    script_arguments = plot_command->remaining();
    action = [&] { return draw_pictures(script_arguments, {}); };
  });

  auto* view_command = app.add_subcommand("view", "Look at runs, finished or under way, in a browser");
  view_command->prefix_command();
  view_command->set_help_flag();
  view_command->callback([&, view_command] {
    script_arguments = view_command->remaining();
    action = [&]() -> int {
      // In place of this process, so that Ctrl-C and other signals reach the server itself.
      script_arguments.insert(script_arguments.end(), {"--built", program_folder().parent_path() / "view"});
      become_script("view/server.py", script_arguments);
    };
  });

  auto* bench_command =
      app.add_subcommand("bench", "Error against run time, by scheme and resolution: tables, pictures");
  bench_command->prefix_command();
  bench_command->footer(
      "poretwin bench [PART...] [--schemes S...] [--spacings X...] [--repeats N] [--longest S] [--out DIR] [--page]");
  bench_command->callback([&, bench_command] {
    script_arguments = bench_command->remaining();
    action = [&] {
      script_arguments.insert(script_arguments.end(), {"--program", program_folder() / "poretwin"});
      return run_script("bench/study.py", script_arguments);
    };
  });

  declare_peer(app, action);
  auto* keys_command =
      app.add_subcommand("keys", "Make the two keys of an encrypted run: DIR/coupler.key, DIR/participant.key");
  keys_command->add_option("DIR", a.out, "folder of the keys")->required();
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
  app.add_subcommand("verify-keys", "Print the reference of all keys of a verify.toml (Markdown)")->callback([&] {
    action = [] {
      fmt::print("{}", verify_reference());
      return 0;
    };
  });
}

int command(int argc, char** argv) {
  CLI::App app("Two-phase SPH for flow through deformable porous media: a fluid and a solid process, coupled.",
               "poretwin");
  Arguments arguments;
  VerifyOptions verify_options;
  std::vector<std::string> script_arguments;
  std::function<int()> action;
  declare(app, arguments, verify_options, script_arguments, action);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : static_cast<int>(ExitCode::bad_case);
  }
  return action();
}

int failed(const char* prefix, const std::exception& error, ExitCode code) {
  std::fprintf(stderr, "poretwin: %s%s\n", prefix, error.what());
  return static_cast<int>(code);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return command(argc, argv);
  } catch (const Error& error) {
    return failed("", error, error.code());
  } catch (const std::filesystem::filesystem_error& error) {
    return failed("", error, ExitCode::input_output);
  } catch (const std::exception& error) {
    return failed("unforeseen: ", error, ExitCode::failure);
  }
}
