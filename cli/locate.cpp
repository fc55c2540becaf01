#include "cli/locate.hpp"

#include "common/case/keys.hpp"
#include "common/core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <set>

namespace poretwin::cli {
namespace fs = std::filesystem;
namespace {

std::vector<fs::path> case_roots() { return {"cases", data_folder() / "cases"}; }

CasePlace placed(const fs::path& file) {
  const fs::path absolute = fs::absolute(file).lexically_normal();
  std::string name = absolute.parent_path().filename().string();
  if (absolute.filename() != "case.toml") name = fmt::format("{}-{}", name, absolute.stem().string());
  return {name, file};
}

}  // namespace

std::vector<std::string> case_names(const std::string& with_file) {
  std::set<std::string> names;
  std::error_code ignored;
  for (const auto& root : case_roots())
    for (const auto& entry : fs::directory_iterator(root, ignored))
      if (fs::exists(entry.path() / with_file)) names.insert(entry.path().filename().string());
  return {names.begin(), names.end()};
}

CasePlace find_case(const std::string& name) {
  for (const auto& root : case_roots())
    if (name.find('/') == std::string::npos && fs::exists(root / name / "case.toml"))
      return placed(root / name / "case.toml");
  if (fs::is_directory(name) && fs::exists(fs::path(name) / "case.toml")) return placed(fs::path(name) / "case.toml");
  if (fs::is_regular_file(name)) return placed(name);
  if (fs::is_directory(name))
    throw FileError(fmt::format("{}: the folder has no case.toml; expected a case file, or a folder with one", name));
  if (name.find('/') != std::string::npos || name.ends_with(".toml"))
    throw FileError(
        fmt::format("{}: no such file; expected a case file, a folder with a case.toml, or the name of a "
                    "folder below cases/",
                    name));
  const auto names = case_names("case.toml");
  std::string list;
  for (const auto& known : names) list += (list.empty() ? "" : ", ") + known;
  throw FileError(fmt::format("no case '{}': expected a case file, a folder with a case.toml, or one of: {}{}", name,
                              list, names.empty() ? "" : fmt::format("; did you mean '{}'?", nearest(name, names))));
}

fs::path program_folder() { return fs::read_symlink("/proc/self/exe").parent_path(); }

fs::path data_folder() {
  const fs::path expected = (program_folder().parent_path() / "share" / "poretwin").lexically_normal();
  std::error_code missing;
  fs::path found = fs::canonical(expected, missing);
  if (missing)
    throw FileError(
        fmt::format("{}: the cases and scripts of poretwin are not there: expected them beside the folder of "
                    "the program; install poretwin as a whole, or start the program where it was built",
                    expected.string()));
  return found;
}

fs::path view_folder() {
  std::error_code ignored;
  if (fs::is_symlink(program_folder().parent_path() / "share" / "poretwin", ignored))
    return program_folder().parent_path() / "view";
  const char *cache = std::getenv("XDG_CACHE_HOME"), *home = std::getenv("HOME");
  if (!(cache && *cache) && !(home && *home))
    throw FileError("view: the page is kept in the user's cache: expected HOME or XDG_CACHE_HOME in the environment");
  return (cache && *cache ? fs::path(cache) : fs::path(home) / ".cache") / "poretwin" / "view";
}

}  // namespace poretwin::cli
