// Where things are: cases by name or path, the programs beside this one, scripts.
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

/// Folder of the data installed with the program, laid out as in the source tree: cases/, and Python scripts in cli/
/// and bench/. It is ../share/poretwin from the program; in a build that is a link to the source tree. Throws
/// FileError.
std::filesystem::path data_folder();

/// Where the page of `poretwin view` is built: in a build beside the programs, else in the user's cache
/// (XDG_CACHE_HOME, ~/.cache). Throws FileError where there is neither.
std::filesystem::path view_folder();

}  // namespace poretwin::cli
