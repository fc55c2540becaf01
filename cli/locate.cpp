#include "cli/locate.hpp"

#include "common/case/keys.hpp"
#include "common/core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace poretwin::cli {
namespace fs = std::filesystem;
namespace {

std::vector<fs::path> case_roots() {
  std::vector<fs::path> roots{fs::path("cases")};
  if (const fs::path source = fs::path(PORETWIN_SOURCE_DIR) / "cases"; fs::exists(source)) roots.push_back(source);
  return roots;
}

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

void expect_run_folder(const fs::path& out) {
  if (!fs::exists(out / "run.toml"))
    throw FileError(fmt::format("{}: nothing to resume: expected the folder of an earlier run, found no run.toml in it",
                                out.string()));
}

void prepare_run_folder(const fs::path& out) {
  std::error_code error;
  if (fs::exists(out) && !fs::is_directory(out))
    throw FileError(fmt::format("{}: expected a folder for the run, found a file", out.string()));
  if (fs::exists(out) && !fs::is_empty(out, error)) {
    if (!fs::exists(out / "run.toml"))
      throw FileError(
          fmt::format("{}: not empty and not the folder of an earlier run (no run.toml in it); choose another --out",
                      out.string()));
    for (const auto& entry : fs::directory_iterator(out)) {
      const std::string file = entry.path().filename().string(), ending = entry.path().extension().string();
      const bool ours = ending == ".vtkhdf" || ending == ".undo" || ending == ".xmf" || ending == ".h5" ||
                        file.ends_with(".summary.json") || (file.starts_with("gauges") && ending == ".csv") ||
                        (file.starts_with("trace") && ending == ".json") || file == "log" || file == "pictures" ||
                        file == "checkpoints";
      if (ours) fs::remove_all(entry.path(), error);
    }
  }
  fs::create_directories(out / "log", error);
  if (error) throw FileError(fmt::format("{}: the folder cannot be made: {}", out.string(), error.message()));
}

}  // namespace poretwin::cli
