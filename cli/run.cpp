#include "cli/run.hpp"

#include "cli/check.hpp"
#include "cli/json_output.hpp"
#include "cli/locate.hpp"
#include "cli/log_tail.hpp"
#include "cli/progress.hpp"
#include "cli/ranks.hpp"
#include "cli/run_folder.hpp"
#include "cli/script.hpp"
#include "cli/text_file.hpp"
#include "common/case/case.hpp"
#include "common/case/identity.hpp"
#include "common/case/programs.hpp"
#include "common/checkpoint/store.hpp"
#include "common/core/error.hpp"
#include "common/coupling/trace.hpp"
#include "common/output/build_info.hpp"
#include "common/output/gauge_log.hpp"
#include "common/output/undo_driver.hpp"

#include <fmt/format.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>

namespace poretwin::cli {
namespace fs = std::filesystem;
int available_threads() {
  if (const char* given = std::getenv("OMP_NUM_THREADS"); given != nullptr && std::atoi(given) > 0)
    return std::atoi(given);
  cpu_set_t set;
  return ::sched_getaffinity(0, sizeof set, &set) == 0 ? std::max(1, CPU_COUNT(&set)) : 1;
}

namespace {

std::string last_words(const fs::path& log) {
  std::ifstream stream(log);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);)
    if (!line.empty()) lines.push_back(line);
  if (lines.empty()) return "(its log is empty)";
  // The text begins at the last line with an error and ends before what mpirun says of it, between lines of dashes.
  // Without an error, it consists of mpirun's last words, or of the last three lines.
  const auto is_dashed = [](const std::string& line) { return line.starts_with("----------"); };
  auto first = lines.size() > 3 ? lines.end() - 3 : lines.begin(), last = lines.end();
  const auto error = std::find_if(lines.rbegin(), lines.rend(),
                                  [](const std::string& line) { return line.find("error:") != std::string::npos; });
  if (error != lines.rend()) {
    first = error.base() - 1;
    last = std::find_if(first, lines.end(), is_dashed);
  } else if (const auto below = std::find_if(lines.rbegin(), lines.rend(), is_dashed); below != lines.rend()) {
    if (const auto above = std::find_if(below + 1, lines.rend(), is_dashed); above != lines.rend()) {
      first = above.base();
      last = below.base() - 1;
    }
  }
  std::string text;
  for (; first != last; ++first) text += (text.empty() ? "" : "\n  ") + *first;
  return text;
}

}  // namespace

std::string reason_of(const Ended& ended) {
  const std::string how = ended.signal != 0
                              ? fmt::format("was killed by signal {} ({})", ended.signal, ::strsignal(ended.signal))
                              : fmt::format("failed with exit code {}", ended.status);
  return fmt::format("{} {}:\n  {}\n  (all of it: {})", ended.name, how, last_words(ended.log), ended.log.string());
}

namespace {

constexpr int peer_failed = static_cast<int>(ExitCode::peer),
              interrupted_exit = static_cast<int>(ExitCode::interrupted);

/// A temporary folder for the socket, whose path must not be longer than 107 characters.
class PrivateFolder {
 public:
  PrivateFolder() {
    std::string pattern = (fs::temp_directory_path() / "poretwin-XXXXXX").string();
    if (pattern.size() > 80) pattern = "/tmp/poretwin-XXXXXX";
    if (::mkdtemp(pattern.data()) == nullptr)
      throw FileError(fmt::format("{}: a temporary folder cannot be made: {}", pattern, std::strerror(errno)));
    path_ = pattern;
  }
  PrivateFolder(const PrivateFolder&) = delete;
  PrivateFolder& operator=(const PrivateFolder&) = delete;
  ~PrivateFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

/// The program for a role in the run.
fs::path program_file(const RunOptions& options, const Case& scene, const std::string& role) {
  return options.programs / ("poretwin-" + (role == "fluid" ? water_program(scene.fluid.representation) : role));
}

/// The user's own command in place of the built-in solver, with the solver's arguments appended; the shell splits the
/// command into words. An empty command leaves the built-in solver.
Program in_place(const std::string& command, Program solver) {
  if (command.empty()) return solver;
  solver.file = "/bin/sh";
  solver.arguments.insert(solver.arguments.begin(), {"-c", "exec " + command + " \"$@\"", solver.name});
  return solver;
}

std::vector<Program> programs_of(const RunOptions& options, const Case& scene, const std::string& address, bool resume,
                                 bool again) {
  const auto program = [&](const std::string& name, std::vector<std::string> first) {
    Program p;
    p.name = name;
    p.file = program_file(options, scene, name);
    p.arguments = {"--case", options.case_file.string(), "--out", options.out.string()};
    p.arguments.insert(p.arguments.end(), first.begin(), first.end());
    if (resume) p.arguments.push_back("--resume");
    const bool leads = name == "coupler" || !scene.coupled();
    if (leads && options.checkpoint_every)
      p.arguments.insert(p.arguments.end(), {"--checkpoint-every", fmt::format("{}", *options.checkpoint_every)});
    const std::string* other = name == "fluid" ? &options.fluid : name == "solid" ? &options.solid : nullptr;
    const bool ours = !other || other->empty();
    if (options.profile && ours) p.arguments.push_back("--profile");
    if (resume && options.accept_changed_program && ours) p.arguments.push_back("--accept-changed-program");
    for (const auto& assignment : options.overrides) p.arguments.insert(p.arguments.end(), {"--set", assignment});
    p.environment = {{"OMP_NUM_THREADS", std::to_string(available_threads())}};
    p.log = options.out / "log" / (name + ".log");
    p.goes_on = resume || again;
    return p;
  };
  std::vector<Program> programs;
  if (!scene.coupled()) {
    programs.push_back(over_ranks(options, program(scene.deformable() ? "solid" : "fluid", {"--alone"})));
    programs.back().reports_progress = true;
    return programs;
  }
  programs.push_back(program("coupler", {"--bind", address}));
  programs.back().reports_progress = true;
  programs.push_back(in_place(options.fluid, over_ranks(options, program("fluid", {"--connect", address}))));
  programs.push_back(in_place(options.solid, program("solid", {"--connect", address})));
  // The solvers join once their particles are made, which may take minutes in 3D. One that fails is noticed at once; a
  // command of the user's may never join.
  if (options.fluid.empty() && options.solid.empty())
    for (Program& p : programs) p.arguments.insert(p.arguments.end(), {"--wait-deadline", "86400"});
  return programs;
}

std::string leader_of(const Case& scene) {
  return scene.coupled() ? "coupler" : scene.deformable() ? "solid" : "fluid";
}

/// Identity of a user's command: its text with the hashes of the files that it names, since a script is part of the
/// program that runs.
std::string identity_of_command(const std::string& command) {
  std::string text = "'" + command + "'";
  std::istringstream words(command);
  for (std::string word; words >> word;) {
    word.erase(std::remove_if(word.begin(), word.end(), [](char c) { return c == '\'' || c == '"'; }), word.end());
    std::error_code none;
    if (fs::is_regular_file(word, none)) text += " " + program_hash(word);
  }
  return text;
}

/// What this run must have in common with the run that it resumes.
RunIdentity identity_of(const RunOptions& options, const Case& scene) {
  RunIdentity identity = case_identity(scene);
  std::string programs = version();
  const auto add = [&](const std::string& name, const std::string& command) {
    programs +=
        fmt::format(", {} {}", name,
                    command.empty() ? program_hash(program_file(options, scene, name)) : identity_of_command(command));
  };
  if (scene.coupled()) add("coupler", "");
  if (scene.coupled() || !scene.deformable()) add("fluid", options.fluid);
  if (scene.deformable()) add("solid", options.solid);
  identity.emplace_back(program_entry, programs);
  return identity;
}

Summary::Numbers numbers_of(const nlohmann::ordered_json& data, const char* key) {
  Summary::Numbers result;
  if (const auto found = data.find(key); found != data.end() && found->is_object())
    for (const auto& [name, value] : found->items())
      if (value.is_number()) result.emplace_back(name, value.get<double>());
  return result;
}

std::vector<Summary> read_summaries(const fs::path& out) {
  std::vector<Summary> summaries;
  for (const char* process : {"coupler", "fluid", "solid"}) {
    std::ifstream stream(out / (std::string(process) + ".summary.json"));
    if (!stream) continue;
    const auto data = nlohmann::ordered_json::parse(stream, nullptr, false);
    if (!data.is_object()) continue;
    Summary s;
    s.process = data.value("process", process);
    s.reason = data.value("reason", "");
    s.exit = data.value("exit", 0);
    const auto number = [&](const char* key) {
      const auto found = data.find(key);
      return found != data.end() && found->is_number() ? found->get<double>() : 0.0;
    };
    s.wall = number("wall_s");
    s.cpu = number("cpu_s");
    s.seconds = numbers_of(data, "seconds");
    s.steps = numbers_of(data, "steps");
    s.counters = numbers_of(data, "counters");
    if (const auto warnings = data.find("warnings"); warnings != data.end() && warnings->is_array())
      for (const auto& w : *warnings)
        if (w.is_object())
          s.warnings.push_back(
              {w.value("what", ""), w.value("count", 0.0), w.value("detail", ""), w.value("result_in_doubt", false)});
    if (const auto files = data.find("files"); files != data.end() && files->is_array())
      for (const auto& file : *files)
        if (file.is_string()) s.files.push_back(file.get<std::string>());
    summaries.push_back(s);
  }
  return summaries;
}

std::string number(double value) {
  return std::abs(value) < 1e15 && value == std::floor(value) ? fmt::format("{:.0f}", value)
                                                              : fmt::format("{:.4g}", value);
}

std::string toml_text(const std::string& text) {
  // TOML has the same escapes as JSON.
  return nlohmann::json(text).dump();
}

void write_run_file(const RunOptions& options, const RunIdentity& identity, const std::string& started,
                    const RunResult* result) {
  std::string text =
      fmt::format("# Written by poretwin; marks this folder as a run.\ncase = {}\ncase_file = {}\noverrides = [",
                  toml_text(options.case_name), toml_text(fs::absolute(options.case_file).lexically_normal().string()));
  for (std::size_t i = 0; i < options.overrides.size(); ++i)
    text += (i > 0 ? ", " : "") + toml_text(options.overrides[i]);
  text += fmt::format("]\nversion = {}\nbuild = {}\nhost = {}\nstarted = {}\n", toml_text(version()),
                      toml_text(build()), toml_text(host()), toml_text(started));
  if (result != nullptr) {
    text += fmt::format(
        "ended = {}\nexit = {}\nreason = {}\nwall_s = {:.3f}\ncpu_s = {:.3f}\nrestarts = {}\nwarnings = [",
        toml_text(time_now()), result->exit, toml_text(result->reason), result->wall, result->cpu, result->restarts);
    std::string warnings;
    for (const auto& warning : result->case_warnings) warnings += "\n  " + toml_text(warning) + ",";
    for (const auto& s : result->summaries)
      for (const auto& w : s.warnings)
        warnings +=
            "\n  " + toml_text(fmt::format("{}: {} ({}): {}", s.process, w.what, number(w.count), w.detail)) + ",";
    text += warnings + (warnings.empty() ? "]\n\n[exits]\n" : "\n]\n\n[exits]\n");
    for (const auto& ended : result->ended) text += fmt::format("{} = {}\n", ended.name, ended.status);
  }
  text += "\n# A run that is resumed must have these in common with it.\n[identity]\n";
  for (const auto& [name, value] : identity) text += fmt::format("{} = {}\n", toml_text(name), toml_text(value));
  write_file(options.out / "run.toml", text);
}

/// Text such as "computing 1.2 s, waiting 0.3 s", largest first; sums that round to zero are left out.
std::string listed_seconds(Summary::Numbers numbers) {
  std::stable_sort(numbers.begin(), numbers.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
  std::string text;
  for (const auto& [name, value] : numbers)
    if (value >= 0.005) text += fmt::format("{}{} {:.2f} s", text.empty() ? "" : ", ", name, value);
  return text;
}

/// One line for each count that is not zero; a cause that limited windows is listed with its fraction of all windows.
std::string listed_counts(const std::string& process, const Summary::Numbers& numbers) {
  const auto is_limit = [](const std::string& name) { return name.starts_with("windows limited by"); };
  double windows = 0.0;
  for (const auto& [name, value] : numbers)
    if (is_limit(name)) windows += value;
  std::string text;
  for (const auto& [name, value] : numbers)
    if (value != 0.0)
      text += fmt::format("{:<10}{:>14}  {}{}\n", process, number(value), name,
                          is_limit(name) ? fmt::format(" ({:.1f} %)", 100.0 * value / windows) : "");
  return text;
}

/// Text with the warnings of the processes: all of them, or only those that put the result in doubt.
std::string listed_warnings(const std::vector<Summary>& summaries, bool in_doubt_only, const char* separator) {
  std::string text;
  for (const auto& s : summaries)
    for (const auto& w : s.warnings)
      if (w.result_in_doubt || !in_doubt_only)
        text += fmt::format("{}{}: {} ({})", text.empty() ? "" : separator, s.process, w.what, number(w.count));
  return text;
}

std::vector<fs::path> files_in(const fs::path& out) {
  std::vector<fs::path> files;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(out, error))
    if (entry.is_regular_file(error) && entry.path().extension() != ".lock") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

/// Ignores Ctrl-C and SIGTERM while it exists: the end of a run must still be recorded.
class StopsIgnored {
 public:
  StopsIgnored() : interrupt_(std::signal(SIGINT, SIG_IGN)), terminate_(std::signal(SIGTERM, SIG_IGN)) {}
  StopsIgnored(const StopsIgnored&) = delete;
  StopsIgnored& operator=(const StopsIgnored&) = delete;
  ~StopsIgnored() {
    std::signal(SIGINT, interrupt_);
    std::signal(SIGTERM, terminate_);
  }

 private:
  void (*interrupt_)(int);
  void (*terminate_)(int);
};

/// Completes the results once all processes have ended: cuts files back to whole frames, joins traces and gauges,
/// writes run.toml. These steps fail, too, on a full disk; their errors are appended to the first cause.
void close_run(const RunOptions& options, const RunIdentity& identity, const std::string& started, RunResult& result) {
  const auto attempt = [&](const std::function<void()>& step) {
    try {
      step();
    } catch (const std::exception& error) {
      if (result.exit == 0) result.exit = static_cast<int>(ExitCode::input_output);
      result.reason += (result.reason.empty() ? "" : "\n  then: ") + std::string(error.what());
    }
  };
  // Cuts files that a killed process left incomplete back to their last complete frame.
  for (const char* phase : {"fluid", "solid"})
    attempt([&] { hdf5::roll_back(options.out / (std::string(phase) + ".vtkhdf")); });
  attempt([&] { coupling::join_traces(options.out); });
  result.summaries = read_summaries(options.out);
  attempt([&] {
    merge_gauges({options.out / "gauges.fluid.csv", options.out / "gauges.solid.csv"}, options.out / "gauges.csv");
  });
  if (result.exit == 0)
    if (const auto doubts = listed_warnings(result.summaries, true, "; "); !doubts.empty()) {
      result.exit = static_cast<int>(ExitCode::in_doubt);
      result.reason = "ended, with warnings that put the result in doubt: " + doubts;
    }
  if (result.ended_well()) attempt([&] { fs::remove_all(options.out / "checkpoints"); });
  attempt([&] { write_run_file(options, identity, started, &result); });
}

}  // namespace

const Ended* root_cause(const std::vector<Ended>& ended) {
  const Ended* follower = nullptr;
  for (const auto& e : ended) {
    if (e.status == 0 || e.status == static_cast<int>(ExitCode::in_doubt)) continue;
    const bool followed = e.by_us || e.status == peer_failed;
    if (!followed) return &e;
    if (follower == nullptr || (follower->by_us && !e.by_us)) follower = &e;
  }
  return follower;
}

RunResult run_case(const RunOptions& options) {
  const Case scene = read_case(options.case_file, options.overrides);
  if (!scene.coupled() && !(options.fluid.empty() && options.solid.empty()))
    throw CaseError(
        "the case's soil is rigid, so the fluid runs alone: expected another solid.model with --fluid or --solid");
  if (options.tiles > 1) expect_tiles(options, scene);
  if (options.tiles == 1 && !options.hosts.empty())
    throw CaseError("--hosts: machines for the processes of --tiles: expected --tiles P with it, P of 2 or more");
  expect_memory(scene);
  const RunIdentity identity = identity_of(options, scene);
  const std::string leader = leader_of(scene), out = options.out.string();
  const RunFolder folder({options.out, options.case_name, identity, leader, options.resume, options.overwrite,
                          options.accept_changed_program});
  if (folder.already_finished()) {
    fmt::print(stderr,
               "poretwin: {}: this run has already finished: nothing is left to resume, nothing was touched; to "
               "compute it again, leave out --resume\n",
               out);
    RunResult before;
    before.already_finished = true;
    before.summaries = read_summaries(options.out);
    before.case_warnings = scene.warnings;
    return before;
  }
  if (!folder.replaced().empty() && !options.quiet)
    fmt::print(stderr, "poretwin: {}: replaces {}\n", out, folder.replaced());
  const std::string started = time_now();
  write_run_file(options, identity, started, nullptr);
  const PrivateFolder socket;
  ProgressView view(options.quiet);
  std::optional<ProgressFile> progress(options.out / "progress.json");
  const auto start = std::chrono::steady_clock::now();
  const std::string address = "ipc://" + (socket.path() / "poretwin.sock").string();
  RunResult result;
  result.case_warnings = scene.warnings;
  result.representation_chosen = scene.representation_chosen;
  if (options.warnings)
    for (const auto& warning : scene.warnings) view.say("warning: " + warning);
  std::vector<fs::path> logs;
  for (const char* process : {"coupler", "fluid", "solid"})
    logs.push_back(options.out / "log" / (std::string(process) + ".log"));
  LogTail tail(logs, options.resume, [&](const std::string& line) {
    if (line.starts_with("rest of the soil")) view.doing(line);
    if (options.warnings && line.find("warning: ") != std::string::npos) view.say(line);
  });
  bool resume = options.resume;
  for (;;) {
    const Watched watched = run_together(
        programs_of(options, scene, address, resume, result.restarts > 0),
        [&](const std::string& line) {
          view.line(line);
          progress->line(line);
        },
        [&](bool stopping) {
          tail.read();
          if (stopping) view.stopping();
          view.tick();
        });
    view.finish();
    tail.read();
    result.ended = watched.ended;
    for (const auto& ended : watched.ended) result.cpu += ended.cpu;
    const Ended* cause = root_cause(watched.ended);
    // An interruption may also have reached the child processes only; or the run may have ended before it arrived.
    if (cause != nullptr && (watched.interrupted || cause->status == interrupted_exit)) {
      result.exit = interrupted_exit;
      result.reason = has_checkpoints(options.out, leader) ? "interrupted; --resume goes on from the last checkpoint"
                                                           : "interrupted; there is no checkpoint";
    } else if (cause != nullptr) {
      result.exit = cause->signal != 0 ? static_cast<int>(ExitCode::failure) : cause->status;
      result.reason = reason_of(*cause);
    }
    // A process that ended with an error would do so again. A crash may have an outside cause: the run is then
    // restarted.
    if (watched.interrupted || cause == nullptr || cause->signal == 0 || cause->by_us ||
        result.restarts == options.restarts)
      break;
    ++result.restarts;
    resume = has_checkpoints(options.out, leader);
    // Removes incomplete checkpoints, which a start from the beginning must not find.
    if (!resume) fs::remove_all(options.out / "checkpoints");
    fmt::print(stderr, "poretwin: {} was killed by signal {} ({}); restart {} of {}, from {}\n", cause->name,
               cause->signal, ::strsignal(cause->signal), result.restarts, options.restarts,
               resume ? "the last checkpoint" : "the beginning: there is no checkpoint yet");
    result.exit = 0;
    result.reason.clear();
  }
  {
    const StopsIgnored until_the_end_is_written;
    progress.reset();
    result.wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    close_run(options, identity, started, result);
  }
  if (!options.quiet) fmt::print("{}", summary_text(result, options.out));
  if (options.pictures && result.ended_well()) {
    const int drawn = draw_pictures({options.out.string()}, options.out / "log" / "plot.log");
    if (drawn != 0)
      fmt::print(stderr, "warning: no pictures were drawn; see {}\n", (options.out / "log" / "plot.log").string());
  }
  return result;
}

nlohmann::ordered_json run_json(const std::string& case_name, const fs::path& case_file, const fs::path& out,
                                const RunResult& result) {
  const auto object = [](const Summary::Numbers& numbers) {
    Json json = Json::object();
    for (const auto& [name, value] : numbers) json[name] = json_number(value);
    return json;
  };
  Json json = json_head("run", result.exit, result.reason.empty() ? "end" : result.reason);
  json["case"] = case_name;
  json["case_file"] = case_file.string();
  json["out"] = out.string();
  json["already_finished"] = result.already_finished;
  json["wall_s"] = result.wall;
  json["cpu_s"] = result.cpu;
  json["restarts"] = result.restarts;
  json["time_s"] = nullptr;
  json["windows"] = 0.0;
  json["case_warnings"] = result.case_warnings;
  json["warnings"] = Json::array();
  json["processes"] = Json::array();
  json["files"] = Json::array();
  for (const auto& s : result.summaries) {
    for (const auto& [name, value] : s.steps)
      if (name == "windows") json["windows"] = std::max(json["windows"].get<double>(), value);
    for (const auto& [name, value] : s.counters)
      if (name == "end_time_s") json["time_s"] = json_number(value);
    for (const auto& w : s.warnings)
      json["warnings"].push_back({{"process", s.process},
                                  {"what", w.what},
                                  {"count", json_number(w.count)},
                                  {"detail", w.detail},
                                  {"result_in_doubt", w.result_in_doubt}});
    json["processes"].push_back({{"process", s.process},
                                 {"exit", s.exit},
                                 {"reason", s.reason},
                                 {"wall_s", s.wall},
                                 {"cpu_s", s.cpu},
                                 {"seconds", object(s.seconds)},
                                 {"steps", object(s.steps)},
                                 {"counters", object(s.counters)}});
  }
  for (const auto& file : files_in(out)) json["files"].push_back(file.string());
  return json;
}

std::string summary_text(const RunResult& result, const fs::path& out) {
  std::string text = fmt::format("\n{:<10}{:>10}{:>10}  where the time went\n", "process", "wall", "cpu");
  for (const auto& s : result.summaries)
    text += fmt::format("{:<10}{:>8.2f} s{:>8.2f} s  {}\n", s.process, s.wall, s.cpu, listed_seconds(s.seconds));
  text += "\nprocess            count  of what (steps, work done, work skipped)\n";
  for (const auto& s : result.summaries)
    text += listed_counts(s.process, s.steps) + listed_counts(s.process, s.counters);
  if (!result.representation_chosen.empty())
    text += fmt::format("\nfluid.representation = \"auto\": {}\n", result.representation_chosen);
  if (const auto warnings = listed_warnings(result.summaries, false, "\n"); !warnings.empty())
    text += fmt::format("\nwarnings\n{}\n", warnings);
  text += fmt::format("\nfiles in {}:", out.string());
  std::error_code error;
  for (const auto& file : files_in(out))
    text += fmt::format(" {} ({} kB)", file.filename().string(), (fs::file_size(file, error) + 1023) / 1024);
  return text + fmt::format("\ntotal: {:.2f} s wall, {:.2f} s cpu\n", result.wall, result.cpu);
}

}  // namespace poretwin::cli
