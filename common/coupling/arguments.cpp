#include "common/coupling/arguments.hpp"

#include "common/core/error.hpp"
#include "common/core/exit_codes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>

namespace poretwin::coupling {
namespace {

double number_after(const std::string& name, const std::string& text, bool zero_too = false) {
  try {
    std::size_t used = 0;
    const double value = std::stod(text, &used);
    if (used == text.size() && (value > 0.0 || (zero_too && value == 0.0))) return value;
  } catch (const std::exception&) {
    // reported below, with the argument's name
  }
  throw CaseError("argument " + name + ": expected a positive number" + (zero_too ? " or zero" : "") + ", got '" +
                  text + "'");
}

struct Argument : DeclaredArgument {
  std::function<void(Arguments& out, const std::string& value)> take;
};

template <class Member>
Argument flag(const char* name, const char* help, Member member) {
  return {{name, "", help}, [member](Arguments& out, const std::string&) { out.*member = true; }};
}
template <class Member>
Argument text(const char* name, const char* value, const char* help, Member member) {
  return {{name, value, help}, [member](Arguments& out, const std::string& given) { out.*member = given; }};
}
Argument seconds(const char* name, const char* help, double Arguments::*member, bool zero_too = false) {
  return {{name, "S", help},
          [=](Arguments& out, const std::string& given) { out.*member = number_after(name, given, zero_too); }};
}

std::vector<Argument> table(Program program) {
  const bool phase = program != Program::coupler;
  std::vector<Argument> all{
      text("--out", "DIR", "folder of the results", &Arguments::out),
      phase ? text("--connect", "ADDRESS", "the coupler's: ipc:///path or tcp://host:port", &Arguments::address)
            : text("--bind", "ADDRESS", "to listen at: ipc:///path or tcp://127.0.0.1:port", &Arguments::address),
      text("--case", "FILE", phase ? "the case; without it the coupler sends its own" : "the case",
           &Arguments::case_file)};
  if (phase)
    all.push_back(flag("--alone", "run without a coupler, a case of this phase alone", &Arguments::alone));
  else
    all.push_back(flag("--allow-any-address", "listen beyond this machine without keys, for a network that is trusted",
                       &Arguments::allow_any_address));
  if (program == Program::solid)
    all.insert(
        all.end(),
        {text("--safety-of", "FILE",
              "in place of a run: the factor of safety of the soil in frames of a run, FILE being its solid.vtkhdf",
              &Arguments::safety_of),
         {{"--frame", "N", "of --safety-of: number of a frame, from 0; may be given again"},
          [](Arguments& out, const std::string& given) {
            out.frames.push_back(static_cast<std::size_t>(number_after("--frame", given, true)));
          }},
         {{"--tolerance", "X", "of --safety-of: width of the bracket over the factor (0.01)"},
          [](Arguments& out, const std::string& given) { out.tolerance = number_after("--tolerance", given); }}});
  all.insert(
      all.end(),
      {text("--keys", "FILE",
            phase ? "participant.key, made by `poretwin keys`" : "coupler.key, made by `poretwin keys`",
            &Arguments::keys),
       {{"--set", "KEY=VALUE", "override a key of the case; may be given again"},
        [](Arguments& out, const std::string& given) { out.overrides.push_back(given); }},
       flag("--resume", "go on from the checkpoint in DIR, all three processes", &Arguments::resume),
       flag("--accept-changed-program", "resume although another program wrote the checkpoint",
            &Arguments::accept_changed_program),
       flag("--overwrite", "begin anew although there is a checkpoint", &Arguments::overwrite),
       seconds("--checkpoint-every",
               "wall-clock between checkpoints [s] (60); 0: every window, inf: only when interrupted; read by the "
               "coupler, or by a solver that runs alone",
               &Arguments::checkpoint_every, true),
       seconds("--wait-deadline", "for the others to come [s] (60)", &Arguments::wait_deadline),
       seconds("--frozen-deadline", "of silence after which another process counts as frozen [s] (30)",
               &Arguments::frozen_deadline),
       flag("--profile", "what was done when, to DIR/trace.NAME.json", &Arguments::profile),
       {{"--progress-fd", "N", "descriptor for lines of JSON with the progress of the run"},
        [](Arguments& out, const std::string& given) {
          out.progress_descriptor = static_cast<int>(number_after("--progress-fd", given));
        }},
       flag("--version", "print version, build and commit", &Arguments::version),
       flag("--help", "print this", &Arguments::help)});
  return all;
}

}  // namespace

std::vector<DeclaredArgument> declared_arguments(Program program) {
  const auto all = table(program);
  return {all.begin(), all.end()};
}

Arguments parse_arguments(int argc, char** argv, Program program) {
  Arguments out;
  const auto all = table(program);
  const std::vector<std::string> given(argv + std::min(argc, 1), argv + argc);
  for (std::size_t k = 0; k < given.size(); ++k) {
    const std::string name = given[k] == "-h" ? "--help" : given[k];
    const auto found = std::find_if(all.begin(), all.end(), [&](const Argument& a) { return a.name == name; });
    if (found == all.end()) throw CaseError("unknown argument '" + name + "'; --help lists what there is");
    if (found->value.empty()) {
      found->take(out, "");
      continue;
    }
    if (k + 1 >= given.size()) throw CaseError("argument " + name + " needs a value");
    found->take(out, given[++k]);
  }
  if (out.help || out.version) return out;
  if (out.case_file.empty() && (program == Program::coupler || out.alone))
    throw CaseError("argument --case FILE is missing");
  if (out.out.empty()) throw CaseError("argument --out DIR is missing");
  if (!out.safety_of.empty() && !out.alone) throw CaseError("argument --safety-of needs --alone");
  if (out.alone != out.address.empty())
    throw CaseError(out.alone
                        ? "--alone and --connect exclude each other"
                        : fmt::format("argument {} is missing",
                                      program == Program::coupler ? "--bind ADDRESS" : "--connect ADDRESS or --alone"));
  return out;
}

std::string synopsis(const std::string& name, Program program) {
  return name + " --out DIR " +
         (program == Program::coupler ? "--case FILE --bind ADDRESS [OPTIONS]"
                                      : "(--connect ADDRESS [--case FILE] | --alone --case FILE) [OPTIONS]");
}

std::string usage(const std::string& name, Program program) {
  std::string text = "usage: " + synopsis(name, program) + "\n\n";
  for (const auto& [argument, value, help] : declared_arguments(program))
    text += fmt::format("  {:<28}{}\n", argument + (value.empty() ? "" : " " + value), help);
  return text + "\n" + exit_codes_text();
}

}  // namespace poretwin::coupling
