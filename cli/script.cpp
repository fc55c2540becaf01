#include "cli/script.hpp"

#include "cli/locate.hpp"
#include "common/core/error.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace poretwin::cli {

namespace {

/// The command that runs a script with the system's Python: another Python in the PATH may lack the packages h5py and
/// matplotlib. -B prevents compiled files in the installed folder.
std::vector<std::string> command_of(const std::string& name, const std::vector<std::string>& arguments) {
  std::vector<std::string> texts{"/usr/bin/python3", "-B", (data_folder() / name).string()};
  texts.insert(texts.end(), arguments.begin(), arguments.end());
  return texts;
}

std::vector<char*> pointers_to(std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  for (auto& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

}  // namespace

void become_script(const std::string& name, const std::vector<std::string>& arguments) {
  auto texts = command_of(name, arguments);
  ::execv(texts.front().c_str(), pointers_to(texts).data());
  throw FileError(
      fmt::format("{}: cannot be started: {}; install the package python3", texts.front(), std::strerror(errno)));
}

int run_script(const std::string& name, const std::vector<std::string>& arguments, const std::filesystem::path& log) {
  auto texts = command_of(name, arguments);
  const auto pointers = pointers_to(texts);
  const pid_t child = ::fork();
  if (child == 0) {
    if (!log.empty()) {
      const int file = ::open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
      ::dup2(file, STDOUT_FILENO);
      ::dup2(file, STDERR_FILENO);
    }
    ::execv(pointers.front(), pointers.data());
    ::_exit(127);
  }
  int status = 0;
  while (child > 0 && ::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return child > 0 && WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}

}  // namespace poretwin::cli
