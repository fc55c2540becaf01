// Paths of cases (by name), of the programs beside this one, and of scripts.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace poretwin::cli {

/// A case that the user named.
struct CasePlace {
  std::string name;            ///< "terzaghi"; "terzaghi-case3d" for another file of the same folder
  std::filesystem::path file;  ///< the TOML file
  [[nodiscard]] std::filesystem::path folder() const { return file.parent_path(); }
};

/// Finds a case: NAME is a folder below cases/ (of the working directory, then of those installed with the program), or
/// a path to a folder or file. Throws FileError with the names of all cases.
CasePlace find_case(const std::string& name);

/// Names of the cases that have the given file ("case.toml", "verify.toml"), sorted.
std::vector<std::string> case_names(const std::string& with_file);

/// Folder of the running executable.
std::filesystem::path program_folder();

/// Folder of the data installed with the program: cases/, and Python scripts in cli/ and bench/, as in the source tree.
/// It is ../share/poretwin relative to the program's folder; in a build, a link to the source tree. Throws FileError.
std::filesystem::path data_folder();

/// Folder in which the page of `poretwin view` is built: in a build beside the programs, else in the user's cache
/// (XDG_CACHE_HOME, ~/.cache). Throws FileError where there is neither.
std::filesystem::path view_folder();

}  // namespace poretwin::cli
