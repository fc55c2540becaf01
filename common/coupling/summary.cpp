#include "common/coupling/summary.hpp"

#include "common/core/fault.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>

namespace poretwin::coupling {
namespace {

/// Of the process, or of the calling thread.
double cpu_seconds(int of) {
  rusage usage{};
  getrusage(of, &usage);
  auto seconds = [](const timeval& t) { return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec); };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// The most memory the process has held so far [bytes]; 0 where the system does not tell.
double peak_memory() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.rfind("VmHWM:", 0) == 0) return 1024.0 * std::stod(line.substr(6));
  return 0.0;
}

std::string json_object(const NamedNumbers& numbers) {
  std::string out = "{";
  for (const auto& [name, value] : numbers)
    out += (out.size() > 1 ? ", " : "") + json_string(name) + ": " + json_number(value);
  return out + "}";
}

double number_after(const std::string& name, const std::string& text, bool zero_too = false) {
  try {
    std::size_t used = 0;
    const double value = std::stod(text, &used);
    if (used == text.size() && (value > 0.0 || (zero_too && value == 0.0))) return value;
  } catch (const std::exception&) {
    // told below, with the argument's name
  }
  throw CaseError("argument " + name + ": expected a positive number" + (zero_too ? " or zero" : "") + ", got '" +
                  text + "'");
}

}  // namespace

std::string json_string(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (static_cast<unsigned char>(c) < 0x20) {
      out += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    } else {
      out += c;
    }
  }
  return out + "\"";
}

std::string json_number(double value) { return std::isfinite(value) ? fmt::format("{}", value) : "null"; }

void write_summary(const std::filesystem::path& path, const RunSummary& summary) {
  std::string files;
  for (const auto& file : summary.files) files += (files.empty() ? "" : ", ") + json_string(file);
  std::string warnings;
  for (const auto& w : summary.warnings)
    warnings += fmt::format("{}\n    {{\"what\": {}, \"count\": {}, \"detail\": {}, \"result_in_doubt\": {}}}",
                            warnings.empty() ? "" : ",", json_string(w.what), json_number(w.count),
                            json_string(w.detail), w.result_in_doubt);
  const std::string text = fmt::format(
      "{{\n  \"process\": {},\n  \"exit\": {},\n  \"reason\": {},\n  \"wall_s\": {},\n  \"cpu_s\": {},\n  "
      "\"cpu_first_thread_s\": {},\n  \"memory_bytes\": {},\n  \"seconds\": {},\n"
      "  \"steps\": {},\n  \"counters\": {},\n  \"warnings\": [{}],\n  \"files\": [{}]\n}}\n",
      json_string(summary.process), static_cast<int>(summary.exit), json_string(summary.reason),
      json_number(summary.wall), json_number(cpu_seconds(RUSAGE_SELF)), json_number(cpu_seconds(RUSAGE_THREAD)),
      json_number(peak_memory()), json_object(summary.seconds), json_object(summary.steps),
      json_object(summary.counters), warnings, files);
  auto part = path;
  part += ".part";
  {
    std::ofstream out(part);
    out << text;
    if (fails(Fallible::write) || !out.flush()) {
      std::error_code ignored;
      std::filesystem::remove(part, ignored);
      throw FileError("cannot write " + part.string() + ": is the disk full or the folder write-protected?");
    }
  }
  std::error_code error;
  std::filesystem::rename(part, path, error);
  if (error) throw FileError("cannot write " + path.string() + ": " + error.message());
}

void ProgressLines::write(const Progress& progress, bool last) {
  if (descriptor_ < 0) return;
  const auto now = std::chrono::steady_clock::now();
  if (!last && now < next_) return;
  next_ = now + std::chrono::milliseconds(100);
  const std::string line = fmt::format("{{\"t\": {}, \"end\": {}, \"step\": {}, \"dt\": {}, \"waiting_for\": {}}}\n",
                                       json_number(progress.time), json_number(progress.end), progress.step,
                                       json_number(progress.interval), json_string(progress.waiting_for));
  if (::write(descriptor_, line.data(), line.size()) < 0) descriptor_ = -1;
}

void log_line(const std::string& line) {
  const std::string text = fmt::format("[{:%H:%M:%S}] {}\n", fmt::gmtime(std::time(nullptr)), line);
  std::fwrite(text.data(), 1, text.size(), stderr);
}

Arguments parse_arguments(int argc, char** argv, Program program) {
  Arguments out;
  const std::vector<std::string> given(argv + std::min(argc, 1), argv + argc);
  const std::string address_name = program == Program::coupler ? "--bind" : "--connect";
  for (std::size_t k = 0; k < given.size(); ++k) {
    const std::string& name = given[k];
    auto value = [&] {
      if (k + 1 >= given.size()) throw CaseError("argument " + name + " needs a value");
      return given[++k];
    };
    if (name == "--case")
      out.case_file = value();
    else if (name == "--out")
      out.out = value();
    else if (name == "--set")
      out.overrides.push_back(value());
    else if (name == "--progress-fd")
      out.progress_descriptor = static_cast<int>(number_after(name, value()));
    else if (name == address_name)
      out.address = value();
    else if (name == "--keys")
      out.keys = value();
    else if (name == "--alone" && program == Program::phase)
      out.alone = true;
    else if (name == "--allow-any-address" && program == Program::coupler)
      out.allow_any_address = true;
    else if (name == "--resume")
      out.resume = true;
    else if (name == "--overwrite")
      out.overwrite = true;
    else if (name == "--accept-changed-program")
      out.accept_changed_program = true;
    else if (name == "--profile")
      out.profile = true;
    else if (name == "--checkpoint-every")
      out.checkpoint_every = number_after(name, value(), true);
    else if (name == "--wait-deadline")
      out.wait_deadline = number_after(name, value());
    else if (name == "--frozen-deadline")
      out.frozen_deadline = number_after(name, value());
    else if (name == "--help" || name == "-h")
      out.help = true;
    else
      throw CaseError("unknown argument '" + name + "'; --help lists what there is");
  }
  if (out.help) return out;
  if (out.case_file.empty() && (program == Program::coupler || out.alone))
    throw CaseError("argument --case FILE is missing");
  if (out.out.empty()) throw CaseError("argument --out DIR is missing");
  if (out.alone != out.address.empty())
    throw CaseError(out.alone ? "--alone and --connect exclude each other"
                              : "argument " + address_name + " ADDRESS" +
                                    (program == Program::phase ? " or --alone" : "") + " is missing");
  return out;
}

std::string usage(const std::string& name, Program program) {
  std::string text = "usage: " + name + " --out DIR ";
  text += program == Program::coupler ? "--case FILE --bind ADDRESS [--allow-any-address]"
                                      : "(--connect ADDRESS [--case FILE] | --alone --case FILE)";
  text +=
      " [--keys FILE] [--set key=value]... [--progress-fd N] [--wait-deadline S] [--frozen-deadline S]\n"
      "       [--resume [--accept-changed-program] | --overwrite] [--checkpoint-every S] [--profile]\n"
      "--resume: go on from the checkpoint in DIR, all three processes; --accept-changed-program: though another "
      "program\nwrote it; --overwrite: begin anew although there is one; --checkpoint-every: s of wall-clock (60), 0: "
      "every\n"
      "window, inf: only when interrupted; the coupler's or a lone solver's word counts\n"
      "--profile: what was done when, to OUT/trace.NAME.json\n"
      "ADDRESS: ipc:///path or tcp://127.0.0.1:port; without --case FILE the coupler sends its case\n"
      "FILE of --keys: coupler.key or participant.key, made by `poretwin keys`\n"
      "exit codes: 0 done, 1 unforeseen, 2 bad case or arguments, 3 a peer failed, 4 diverged, 5 files, 6 ended with "
      "warnings\nthat put the result in doubt, 130 interrupted\n";
  return text;
}

}  // namespace poretwin::coupling
