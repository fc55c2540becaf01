#include "common/core/file_lock.hpp"

#include "common/core/error.hpp"
#include "common/output/build_info.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <thread>
#include <utility>

namespace poretwin {
namespace {

/// Time to wait for programs whose parent process was killed: they write a checkpoint before they end.
constexpr std::chrono::seconds patience{20};

struct Holder {
  std::string words;
  pid_t process = 0;
  std::string machine;
  /// Whether the process that signed ran on this machine and has ended since.
  [[nodiscard]] bool gone() const {
    return process > 0 && machine == host() && ::kill(process, 0) != 0 && errno == ESRCH;
  }
};

/// Reads the holder from the file: the first line is a text for people, the second contains process and machine.
Holder holder_of(int descriptor) {
  std::array<char, 1024> bytes{};
  const auto count = ::pread(descriptor, bytes.data(), bytes.size() - 1, 0);
  const std::string text(bytes.data(), count > 0 ? static_cast<std::size_t>(count) : 0);
  Holder holder;
  holder.words = text.substr(0, text.find('\n'));
  std::array<char, 256> machine{};
  int process = 0;
  const auto second = text.find('\n');
  if (second != std::string::npos &&
      std::sscanf(text.c_str() + second + 1, "%d %255s", &process, machine.data()) == 2) {
    holder.process = process;
    holder.machine = machine.data();
  }
  if (holder.words.empty()) holder.words = "a process that has just begun";
  return holder;
}

}  // namespace

FileLock::FileLock(const std::filesystem::path& file, const std::string& subject, Inherited inherited) : file_(file) {
  descriptor_ = ::open(file.c_str(), O_RDWR | O_CREAT | (inherited == Inherited::no ? O_CLOEXEC : 0), 0666);
  if (descriptor_ < 0) throw FileError(fmt::format("{}: cannot be opened: {}", file.string(), std::strerror(errno)));
  const auto start = std::chrono::steady_clock::now();
  for (bool said = false; ::flock(descriptor_, LOCK_EX | LOCK_NB) != 0;) {
    const int error = errno;
    if (error == EINTR) continue;
    if (error != EWOULDBLOCK) {  // the file system has no locks; users must avoid two runs in one folder
      std::fprintf(stderr, "warning: %s cannot be locked: %s\n", file.c_str(), std::strerror(error));
      return;
    }
    const Holder holder = holder_of(descriptor_);
    const bool ending = holder.gone();
    if (ending && std::chrono::steady_clock::now() - start < patience) {
      if (!std::exchange(said, true))
        std::fprintf(stderr, "waiting for the end of what a killed process has started: %s\n", holder.words.c_str());
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      continue;
    }
    ::close(std::exchange(descriptor_, -1));
    throw FileError(fmt::format("{}: {}{}; wait for its end, or choose another --out", subject, holder.words,
                                ending ? ", which was killed, but what it started has not ended" : ""));
  }
}

FileLock::FileLock(FileLock&& other) noexcept
    : file_(std::move(other.file_)), descriptor_(std::exchange(other.descriptor_, -1)) {}

FileLock& FileLock::operator=(FileLock&& other) noexcept {
  std::swap(file_, other.file_);
  std::swap(descriptor_, other.descriptor_);
  return *this;
}

FileLock::~FileLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void FileLock::sign(const std::string& what) const {
  const std::string text =
      fmt::format("{}, process {} on {}, since {}\n{} {}\n", what, ::getpid(), host(), time_now(), ::getpid(), host());
  if (::ftruncate(descriptor_, 0) != 0 ||
      ::pwrite(descriptor_, text.data(), text.size(), 0) != static_cast<ssize_t>(text.size()))
    throw FileError(fmt::format("{}: cannot be written: {}", file_.string(), std::strerror(errno)));
}

}  // namespace poretwin
