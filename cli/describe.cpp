#include "cli/describe.hpp"

#include "cli/locate.hpp"
#include "common/core/error.hpp"
#include "common/core/exit_codes.hpp"
#include "common/coupling/arguments.hpp"
#include "common/output/build_info.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

namespace poretwin::cli {
namespace {

using coupling::DeclaredArgument;

/// A program or one of its commands, as man pages and completions show it.
struct Described {
  std::string path;  ///< "run", "peer mock"; empty for the program itself
  std::string about, footer;
  std::vector<std::string> positional;  ///< "CASE"
  std::vector<DeclaredArgument> arguments;
  std::vector<std::vector<std::string>> choices;              ///< the words that each argument accepts; empty: any word
  std::vector<std::pair<std::string, std::string>> commands;  ///< sub-commands: name and description
};

struct DescribedProgram {
  std::string name, about, synopsis;
  std::vector<Described> commands;  ///< the program itself comes first
};

std::string joined(const std::vector<std::string>& words, const std::string& separator) {
  return fmt::format("{}", fmt::join(words, separator));
}

/// Words that an option accepts. CLI11 shows them as "{fluid,solid}".
std::vector<std::string> choices_of(const std::string& type) {
  const auto from = type.find('{'), to = type.find('}');
  std::vector<std::string> words;
  if (from == std::string::npos || to == std::string::npos) return words;
  std::stringstream list(type.substr(from + 1, to - from - 1));
  for (std::string word; std::getline(list, word, ',');) words.push_back(word);
  return words;
}

void describe_app(const CLI::App& app, const std::string& path, std::vector<Described>& all) {
  Described d;
  d.path = path;
  d.about = app.get_description();
  // Sub-commands inherit the footer of their command; it is shown only once.
  if (app.get_parent() != nullptr && app.get_footer() != app.get_parent()->get_footer()) d.footer = app.get_footer();
  for (const CLI::Option* option : app.get_options()) {
    const bool takes = option->get_items_expected_max() > 0;
    const auto choices = choices_of(option->get_type_name());
    std::string value = takes ? (choices.empty() ? option->get_type_name() : joined(choices, "|")) : "";
    value = value.substr(0, value.find(':'));  // removes the bounds of the value
    if (option->get_items_expected_max() > 1 && takes && option->get_expected_max() > 1 && !option->get_positional() &&
        option->get_name() != "--set")
      value += "...";
    std::string help = option->get_description();
    if (takes && !option->get_default_str().empty()) help += " (default " + option->get_default_str() + ")";
    if (option->get_positional()) {
      d.positional.push_back(option->get_required() ? option->get_name(true) : "[" + option->get_name(true) + "...]");
      d.arguments.push_back({option->get_name(true), "", help});
    } else {
      d.arguments.push_back({"--" + option->get_lnames().front(), value, help});
    }
    d.choices.push_back(choices);
  }
  const auto below = app.get_subcommands([](const CLI::App* command) { return !command->get_group().empty(); });
  for (const auto* command : below) d.commands.emplace_back(command->get_name(), command->get_description());
  all.push_back(std::move(d));
  for (const auto* command : below)
    describe_app(*command, path.empty() ? command->get_name() : path + " " + command->get_name(), all);
}

DescribedProgram describe_command(const CLI::App& app) {
  DescribedProgram program{"poretwin", app.get_description(), "poretwin COMMAND [OPTIONS]", {}};
  describe_app(app, "", program.commands);
  return program;
}

DescribedProgram describe_process(const std::string& process) {
  const auto kind = process == "coupler" ? coupling::Program::coupler
                    : process == "solid" ? coupling::Program::solid
                                         : coupling::Program::phase;
  const std::string name = "poretwin-" + process;
  DescribedProgram program{
      name, "the " + process + " process of a run of poretwin", coupling::synopsis(name, kind), {{}}};
  auto& d = program.commands.front();
  d.arguments = coupling::declared_arguments(kind);
  d.choices.resize(d.arguments.size());
  return program;
}

const std::vector<std::string> processes{"fluid", "pore", "joint", "solid", "coupler"};

// Man pages

std::string roff(const std::string& text) {
  std::string out;
  for (std::size_t k = 0; k < text.size(); ++k) {
    const char c = text[k];
    if ((c == '.' || c == '\'') && (k == 0 || text[k - 1] == '\n')) out += "\\&";
    if (c == '\\')
      out += "\\e";
    else if (c == '-')
      out += "\\-";
    else
      out += c;
  }
  return out;
}

std::string roff_arguments(const Described& d) {
  std::string text;
  for (const auto& [name, value, help] : d.arguments)
    text += fmt::format(".TP\n\\fB{}\\fR{}\n{}\n", roff(name), value.empty() ? "" : " \\fI" + roff(value) + "\\fR",
                        roff(help));
  return text;
}

std::string man_page(const DescribedProgram& program) {
  const bool commands = program.commands.size() > 1;
  std::string upper = program.name;
  std::transform(upper.begin(), upper.end(), upper.begin(), [](unsigned char c) { return std::toupper(c); });
  std::string about = program.about;
  if (about.ends_with('.')) about.pop_back();
  const std::string number = version().substr(0, version().find(' '));
  std::string text =
      fmt::format(".TH {} 1 \"\" \"poretwin {}\" \"User Commands\"\n.SH NAME\n{} \\- {}\n.SH SYNOPSIS\n.B {}\n",
                  roff(upper), roff(number), roff(program.name), roff(about), roff(program.synopsis));
  text += ".SH OPTIONS\n" + roff_arguments(program.commands.front());
  if (commands) text += ".SH COMMANDS\n";
  for (std::size_t k = 1; k < program.commands.size(); ++k) {
    const auto& d = program.commands[k];
    const std::string words = d.positional.empty() ? "" : " " + joined(d.positional, " ");
    text += fmt::format(".SS {} {}{}{}\n{}.\n", roff(program.name), roff(d.path), roff(words),
                        d.arguments.size() > d.positional.size() ? " [OPTIONS]" : "", roff(d.about));
    if (!d.footer.empty()) text += ".PP\n.nf\n" + roff(d.footer) + "\n.fi\n";
    text += roff_arguments(d);
  }
  text += ".SH EXIT STATUS\n";
  for (const auto& [code, meaning] : exit_meanings)
    text += fmt::format(".TP\n.B {}\n{}\n", static_cast<int>(code), roff(meaning));
  std::vector<std::string> others;
  if (program.name != "poretwin") others.emplace_back("poretwin");
  for (const auto& process : processes)
    if ("poretwin-" + process != program.name) others.push_back("poretwin-" + process);
  text += ".SH SEE ALSO\n";
  for (const auto& other : others)
    text += fmt::format(".BR {} (1){}\n", roff(other), other == others.back() ? "" : ",");
  return text;
}

// Completions

/// How a shell completes the value of an argument.
enum class Kind { nothing, file, folder, choice, other };
Kind kind_of(const DeclaredArgument& argument, const std::vector<std::string>& choices) {
  if (!choices.empty()) return Kind::choice;
  if (argument.value.empty()) return Kind::nothing;
  if (argument.value == "DIR") return Kind::folder;
  return argument.value == "FILE" ? Kind::file : Kind::other;
}

bool is_option(const DeclaredArgument& argument) { return argument.name.starts_with("--"); }
bool takes_case(const Described& d) {
  return std::find(d.positional.begin(), d.positional.end(), "CASE") != d.positional.end() ||
         d.path == "peer conformance";
}

std::string shell_quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

/// Shell pattern that matches the words of any command.
std::string paths_pattern(const DescribedProgram& program) {
  std::vector<std::string> patterns;
  for (const auto& d : program.commands)
    if (!d.path.empty()) patterns.push_back(shell_quoted(d.path));
  return joined(patterns, " | ");
}

std::string bash_completion(const DescribedProgram& program) {
  std::string text = "# bash completion; made by the program itself\n";
  std::string function = "_" + program.name;
  std::replace(function.begin(), function.end(), '-', '_');
  std::string values, words;
  for (const auto& d : program.commands) {
    std::vector<std::string> offered;
    for (const auto& [name, about] : d.commands) offered.push_back(name);
    std::map<std::string, std::vector<std::string>> by_action;
    for (std::size_t k = 0; k < d.arguments.size(); ++k) {
      const auto& argument = d.arguments[k];
      if (!is_option(argument)) continue;
      offered.push_back(argument.name);
      const auto pattern = shell_quoted(d.path + " " + argument.name);
      switch (kind_of(argument, d.choices[k])) {
        case Kind::nothing:
          break;
        case Kind::file:
          by_action["compgen -f -- \"$current\""].push_back(pattern);
          break;
        case Kind::folder:
          by_action["compgen -d -- \"$current\""].push_back(pattern);
          break;
        case Kind::choice:
          by_action[fmt::format("compgen -W '{}' -- \"$current\"", joined(d.choices[k], " "))].push_back(pattern);
          break;
        case Kind::other:
          by_action[":"].push_back(pattern);
      }
    }
    for (const auto& [does, patterns] : by_action)
      values += fmt::format("    {}) mapfile -t COMPREPLY < <({}); return ;;\n", joined(patterns, " | "), does);
    std::string cases;
    if (takes_case(d)) cases = " $(poretwin describe cases 2>/dev/null)";
    words += fmt::format("    {}) words=\"{}{}\" ;;\n", shell_quoted(d.path), joined(offered, " "), cases);
  }
  text += fmt::format(
      "{}() {{\n  local current=${{COMP_WORDS[COMP_CWORD]}} previous=${{COMP_WORDS[COMP_CWORD-1]}}\n"
      "  local path='' word words=''\n",
      function);
  if (program.commands.size() > 1)
    text += fmt::format(
        "  for word in \"${{COMP_WORDS[@]:1:COMP_CWORD-1}}\"; do\n    word=${{path:+$path }}$word\n    case $word in\n"
        "      {}) path=$word ;;\n    esac\n  done\n",
        paths_pattern(program));
  text += fmt::format(
      "  case \"$path $previous\" in\n{}  esac\n  case $path in\n{}  esac\n"
      "  mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$current\"; [[ $current == -* ]] || compgen -f -- "
      "\"$current\")\n}}\ncomplete -o filenames -F {} {}\n",
      values, words, function, program.name);
  return text;
}

std::string zsh_completion(const DescribedProgram& program) {
  std::string text = "#compdef " + program.name + "\n# zsh completion; made by the program itself\n";
  const auto bracketed = [](const std::string& about) {
    std::string out;
    for (const char c : about) out += c == '[' || c == ']' || c == ':' ? std::string("\\") + c : std::string(1, c);
    return out;
  };
  std::string cases;
  for (const auto& d : program.commands) {
    std::string specs;
    for (std::size_t k = 0; k < d.arguments.size(); ++k) {
      const auto& argument = d.arguments[k];
      if (!is_option(argument)) continue;
      std::string spec = fmt::format("*{}[{}]", argument.name, bracketed(argument.help));
      const std::string value = ":" + bracketed(argument.value) + ":";
      switch (kind_of(argument, d.choices[k])) {
        case Kind::nothing:
          break;
        case Kind::file:
          spec += value + "_files";
          break;
        case Kind::folder:
          spec += value + "_files -/";
          break;
        case Kind::choice:
          spec += value + "(" + joined(d.choices[k], " ") + ")";
          break;
        case Kind::other:
          spec += value;
      }
      specs += " \\\n        " + shell_quoted(spec);
    }
    std::string below, rest = "*:file:_files";
    if (!d.commands.empty()) {
      std::vector<std::string> names_below;
      for (const auto& [name, about] : d.commands) names_below.push_back(shell_quoted(name + ":" + about));
      below = fmt::format("      local -a below=({})\n", joined(names_below, " "));
      rest = "*:command:{_describe command below}";
    } else if (takes_case(d)) {
      rest = "*:case:{_alternative \"cases:case:($(poretwin describe cases 2>/dev/null))\" files:file:_files}";
    }
    cases += fmt::format("    {})\n{}      _arguments{} \\\n        {} ;;\n", shell_quoted(d.path), below, specs,
                         shell_quoted(rest));
  }
  text += "local at='' word\n";
  if (program.commands.size() > 1)
    text += fmt::format(
        "for word in \"${{(@)words[2,CURRENT-1]}}\"; do\n  word=${{at:+$at }}$word\n  case $word in\n    {}) at=$word "
        ";;\n  esac\ndone\n",
        paths_pattern(program));
  return text + "case $at in\n" + cases + "esac\n";
}

std::string fish_completion(const DescribedProgram& program) {
  std::string text = "# fish completion; made by the program itself\n";
  const auto quote = [](const std::string& words) {
    std::string out = "'";
    for (const char c : words) out += c == '\'' || c == '\\' ? std::string("\\") + c : std::string(1, c);
    return out + "'";
  };
  for (const auto& d : program.commands) {
    // Fish tests which words have been typed; for a sub-command the word of its command must have been typed, too.
    std::string condition;
    std::stringstream path(d.path);
    for (std::string word; path >> word;)
      condition += fmt::format("{}__fish_seen_subcommand_from {}", condition.empty() ? "" : "; and ", word);
    if (d.path.empty() && !d.commands.empty()) condition = "__fish_use_subcommand";
    const std::string when =
        fmt::format("complete -c {}{}", program.name, condition.empty() ? "" : " -n " + quote(condition));
    for (const auto& [name, about] : d.commands) text += fmt::format("{} -f -a {} -d {}\n", when, name, quote(about));
    if (takes_case(d)) text += when + " -a '(poretwin describe cases 2>/dev/null)'\n";
    for (std::size_t k = 0; k < d.arguments.size(); ++k) {
      const auto& argument = d.arguments[k];
      if (!is_option(argument)) continue;
      const Kind kind = kind_of(argument, d.choices[k]);
      const char* value = kind == Kind::nothing  ? ""
                          : kind == Kind::file   ? " -r -F"
                          : kind == Kind::folder ? " -x -a '(__fish_complete_directories)'"
                                                 : " -x";
      text += fmt::format("{} -l {}{}{} -d {}\n", when, argument.name.substr(2), value,
                          kind == Kind::choice ? " -a " + quote(joined(d.choices[k], " ")) : "", quote(argument.help));
    }
  }
  return text;
}

std::string description(const CLI::App& app, const std::string& what) {
  if (what == "cases") return joined(case_names("case.toml"), "\n") + "\n";
  std::vector<DescribedProgram> all{describe_command(app)};
  for (const auto& process : processes) all.push_back(describe_process(process));
  const auto dot = what.find('.');
  const std::string form = dot == std::string::npos ? "" : what.substr(dot + 1);
  for (const auto& program : all) {
    if (program.name != what.substr(0, dot)) continue;
    if (form == "1") return man_page(program);
    if (form == "bash") return bash_completion(program);
    if (form == "zsh") return zsh_completion(program);
    if (form == "fish") return fish_completion(program);
  }
  throw CaseError("describe " + what + ": expected cases, or PROGRAM.1, .bash, .zsh or .fish");
}

}  // namespace

void declare_describe(CLI::App& app, std::function<int()>& action) {
  auto* command = app.add_subcommand("describe", "Print a man page or completions")->group("");
  auto what = std::make_shared<std::string>();
  command->add_option("WHAT", *what, "cases, poretwin.1, poretwin-fluid.bash, ..")->required();
  command->callback([&app, &action, what] {
    action = [&app, what] {
      fmt::print("{}", description(app, *what));
      return 0;
    };
  });
}

}  // namespace poretwin::cli
