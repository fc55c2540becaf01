// The result of a command for another program: --json FILE of run, check, safety, verify and bench. docs/json.md
// describes its contents.
#pragma once

#include <exception>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace poretwin::cli {

using Json = nlohmann::ordered_json;

class JsonOutput {
 public:
  JsonOutput() = default;
  JsonOutput(const JsonOutput&) = delete;
  JsonOutput& operator=(const JsonOutput&) = delete;
  ~JsonOutput();

  /// `file`: a path, or "-" for stdout. In that case all other output of this process and its children to stdout goes
  /// to stderr.
  void open(const std::string& command, const std::string& file);
  [[nodiscard]] bool wanted() const { return !file_.empty(); }
  [[nodiscard]] const std::string& command() const { return command_; }
  /// Replaces the JSON written before. Stdout receives only the last one, from finish(). Throws FileError.
  void write(const Json& json);
  /// Prints the JSON where stdout was chosen. Throws FileError.
  void finish();

 private:
  std::string command_, file_, text_;
  int stdout_ = -1;  ///< the original stdout, while descriptor 1 is stderr
};

/// The head of every command's result: "command", "version", "exit", "reason".
Json json_head(const std::string& command, int exit, const std::string& reason);

/// The result of a command that could not begin: the head, and "error" with "message", "file", "line" and "key", which
/// are null where unknown.
Json json_error(const std::string& command, int exit, const std::string& message);

/// A number as JSON; null for infinity and NaN, which JSON does not have.
Json json_number(double value);

}  // namespace poretwin::cli
