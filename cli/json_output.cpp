#include "cli/json_output.hpp"

#include "cli/text_file.hpp"
#include "common/core/error.hpp"
#include "common/output/build_info.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>
#include <regex>

namespace poretwin::cli {
JsonOutput::~JsonOutput() {
  if (stdout_ >= 0) ::close(stdout_);
}

void JsonOutput::open(const std::string& command, const std::string& file) {
  command_ = command;
  file_ = file;
  if (file != "-") return;
  std::fflush(stdout);
  stdout_ = ::fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 3);
  if (stdout_ < 0 || ::dup2(STDERR_FILENO, STDOUT_FILENO) < 0)
    throw FileError(fmt::format("--json -: stdout cannot be set aside: {}", std::strerror(errno)));
}

void JsonOutput::write(const Json& json) {
  // File names may contain any bytes.
  text_ = json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
  if (file_ == "-") return;
  write_file(file_, text_);
}

void JsonOutput::finish() {
  for (std::string_view rest = stdout_ >= 0 ? text_ : std::string_view(); !rest.empty();) {
    const auto written = ::write(stdout_, rest.data(), rest.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) throw FileError(fmt::format("--json -: stdout cannot be written: {}", std::strerror(errno)));
    rest.remove_prefix(static_cast<std::size_t>(written));
  }
  text_.clear();
}

Json json_head(const std::string& command, int exit, const std::string& reason) {
  return {{"command", command}, {"version", version()}, {"exit", exit}, {"reason", reason}};
}

Json json_error(const std::string& command, int exit, const std::string& message) {
  Json error = {{"message", message}, {"file", nullptr}, {"line", nullptr}, {"key", nullptr}};
  // Messages about files begin with the place, "FILE: .." or "FILE:LINE: ..", and may contain "key 'KEY'".
  static const std::regex place(R"(^((?!--)[^:']*[./][^:']*)(?::(\d+))?(?::\d+)?: )"), key(R"(\bkey '([^']+)')");
  std::smatch found;
  if (std::regex_search(message, found, place)) {
    error["file"] = found[1].str();
    if (found[2].matched) error["line"] = std::stoi(found[2].str());
  }
  if (std::regex_search(message, found, key)) error["key"] = found[1].str();
  Json json = json_head(command, exit, message);
  json["error"] = std::move(error);
  return json;
}

Json json_number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

}  // namespace poretwin::cli
