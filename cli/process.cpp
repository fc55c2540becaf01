#include "cli/process.hpp"

#include "common/core/error.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/signalfd.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <utility>

namespace poretwin::cli {
namespace {

using Clock = std::chrono::steady_clock;

/// A file descriptor that closes itself.
class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int value) : value_(value) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  Descriptor(Descriptor&& other) noexcept : value_(std::exchange(other.value_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(value_, other.value_);
    return *this;
  }
  ~Descriptor() { close(); }
  void close() {
    if (value_ >= 0) ::close(value_);
    value_ = -1;
  }
  [[nodiscard]] int get() const { return value_; }

 private:
  int value_ = -1;
};

/// SIGINT, SIGTERM and SIGCHLD as a readable descriptor; the previous signal mask is restored at the end.
class Signals {
 public:
  Signals() {
    sigemptyset(&set_);
    for (const int s : {SIGINT, SIGTERM, SIGCHLD}) sigaddset(&set_, s);
    ::sigprocmask(SIG_BLOCK, &set_, &before_);
    descriptor_ = Descriptor(::signalfd(-1, &set_, SFD_CLOEXEC | SFD_NONBLOCK));
  }
  Signals(const Signals&) = delete;
  Signals& operator=(const Signals&) = delete;
  /// Discards signals that have arrived so far: they were meant for the child processes, and must not end this one.
  ~Signals() {
    static_cast<void>(stops());
    ::sigprocmask(SIG_SETMASK, &before_, nullptr);
  }
  [[nodiscard]] int descriptor() const { return descriptor_.get(); }
  [[nodiscard]] const sigset_t& before() const { return before_; }
  /// Number of requests to stop since the last call.
  [[nodiscard]] int stops() const {
    int count = 0;
    signalfd_siginfo info{};
    while (::read(descriptor_.get(), &info, sizeof info) == static_cast<ssize_t>(sizeof info))
      if (info.ssi_signo != static_cast<std::uint32_t>(SIGCHLD)) ++count;
    return count;
  }

 private:
  sigset_t set_{}, before_{};
  Descriptor descriptor_;
};

struct Child {
  Program program;
  pid_t pid = -1;
  Descriptor progress;
  std::string pending;  ///< bytes of a progress line that is incomplete yet
  bool asked_to_end = false;
  bool running = true;
};

/// Runs in the child process after fork. Only async-signal-safe calls are allowed before exec, so that everything is
/// prepared by the parent.
[[noreturn]] void become(const std::vector<char*>& arguments, const std::vector<char*>& environment, int log,
                         int output, int progress, int report, const sigset_t& mask, pid_t parent) {
  ::setpgid(0, 0);
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (::getppid() != parent) ::_exit(127);
  ::sigprocmask(SIG_SETMASK, &mask, nullptr);
  const int nothing = ::open("/dev/null", O_RDONLY);
  ::dup2(nothing, STDIN_FILENO);
  ::dup2(output, STDOUT_FILENO);
  ::dup2(log, STDERR_FILENO);
  if (progress >= 0) ::fcntl(progress, F_SETFD, 0);
  ::execve(arguments.front(), arguments.data(), environment.data());
  const int error = errno;
  [[maybe_unused]] const auto written = ::write(report, &error, sizeof error);
  ::_exit(127);
}

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> result;
  for (auto& text : texts) result.push_back(text.data());
  result.push_back(nullptr);
  return result;
}

std::vector<std::string> environment_of(const Program& program) {
  std::vector<std::string> result;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string text = *entry;
    if (program.environment.find(text.substr(0, text.find('='))) == program.environment.end()) result.push_back(text);
  }
  for (const auto& [key, value] : program.environment) result.push_back(key + "=" + value);
  return result;
}

std::array<Descriptor, 2> make_pipe() {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) throw FileError(fmt::format("a pipe cannot be made: {}", std::strerror(errno)));
  return {Descriptor(ends[0]), Descriptor(ends[1])};
}

Child start(const Program& program, const Signals& signals) {
  Child child;
  child.program = program;
  const Descriptor log(
      ::open(program.log.c_str(), O_WRONLY | O_CREAT | (program.goes_on ? O_APPEND : O_TRUNC) | O_CLOEXEC, 0666));
  if (log.get() < 0)
    throw FileError(fmt::format("{}: cannot be written: {}", program.log.string(), std::strerror(errno)));
  // Reserves disk space for the program's last messages, in case the disk is full by then. Not every file system
  // supports it.
  constexpr off_t last_words = 16384;
  static_cast<void>(::fallocate(log.get(), FALLOC_FL_KEEP_SIZE, ::lseek(log.get(), 0, SEEK_END), last_words));
  std::vector<std::string> texts{program.file.string()};
  texts.insert(texts.end(), program.arguments.begin(), program.arguments.end());
  std::array<Descriptor, 2> progress;
  if (program.reports_progress) {
    progress = make_pipe();
    ::fcntl(progress[0].get(), F_SETFL, O_NONBLOCK);
    const int seen_as = program.by_mpirun ? STDOUT_FILENO : progress[1].get();
    texts.insert(texts.end(), {"--progress-fd", std::to_string(seen_as)});
  }
  auto report = make_pipe();
  auto variables = environment_of(program);
  const auto arguments = pointers(texts), environment = pointers(variables);
  const pid_t parent = ::getpid();
  const int output = program.reports_progress && program.by_mpirun ? progress[1].get() : log.get();
  child.pid = ::fork();
  if (child.pid == 0)
    become(arguments, environment, log.get(), output, progress[1].get(), report[1].get(), signals.before(), parent);
  if (child.pid < 0)
    throw FileError(fmt::format("{}: cannot be started: {}", program.file.string(), std::strerror(errno)));
  ::setpgid(child.pid, child.pid);
  report[1].close();
  int error = 0;
  if (::read(report[0].get(), &error, sizeof error) > 0) {
    ::waitpid(child.pid, nullptr, 0);
    throw FileError(fmt::format("{}: cannot be started: {}; expected the program beside 'poretwin'",
                                program.file.string(), std::strerror(error)));
  }
  child.progress = std::move(progress[0]);
  return child;
}

class Watch {
 public:
  Watch(const std::function<void(const std::string&)>& progress, const std::function<void(bool)>& tick,
        const Patience& patience)
      : progress_(progress), tick_(tick), patience_(patience) {}

  Watched run(const std::vector<Program>& programs) {
    try {
      for (const auto& program : programs) children_.push_back(start(program, signals_));
    } catch (...) {
      end_all(SIGKILL);
      while (running() > 0) reap();
      throw;
    }
    while (running() > 0) {
      wait_for_news();
      read_progress();
      reap();
      if (const int stops = signals_.stops(); stops > 0 && running() > 0) interrupt();
      press();
      tick_(result_.interrupted);
    }
    read_progress();
    return std::move(result_);
  }

 private:
  [[nodiscard]] std::size_t running() const {
    return static_cast<std::size_t>(
        std::count_if(children_.begin(), children_.end(), [](const Child& c) { return c.running; }));
  }

  void wait_for_news() const {
    std::vector<pollfd> watched{{signals_.descriptor(), POLLIN, 0}};
    for (const auto& child : children_)
      if (child.progress.get() >= 0) watched.push_back({child.progress.get(), POLLIN, 0});
    ::poll(watched.data(), watched.size(), 250);
  }

  void read_progress() {
    std::array<char, 4096> bytes{};
    for (auto& child : children_) {
      while (child.progress.get() >= 0) {
        const auto count = ::read(child.progress.get(), bytes.data(), bytes.size());
        if (count < 0) break;
        if (count == 0) child.progress.close();
        child.pending.append(bytes.data(), static_cast<std::size_t>(count));
      }
      for (auto end = child.pending.find('\n'); end != std::string::npos; end = child.pending.find('\n')) {
        progress_(child.pending.substr(0, end));
        child.pending.erase(0, end + 1);
      }
    }
  }

  void reap() {
    for (auto& child : children_) {
      if (!child.running) continue;
      int status = 0;
      rusage usage{};
      if (::wait4(child.pid, &status, WNOHANG, &usage) != child.pid) continue;
      child.running = false;
      Ended ended;
      ended.name = child.program.name;
      ended.log = child.program.log;
      ended.status = WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
      const bool killed = WIFSIGNALED(status) || (child.program.by_mpirun && ended.status > 128 &&
                                                  ended.status != static_cast<int>(ExitCode::interrupted));
      ended.signal = killed ? ended.status - 128 : 0;
      ended.by_us = child.asked_to_end;
      const auto seconds = [](const timeval& t) {
        return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
      };
      ended.cpu = seconds(usage.ru_utime) + seconds(usage.ru_stime);
      const bool well = ended.status == 0 || ended.status == static_cast<int>(ExitCode::in_doubt);
      if (!well && !next_) schedule(SIGTERM, patience_.by_itself);
      result_.ended.push_back(ended);
    }
  }

  void interrupt() {
    if (result_.interrupted) {  // a second Ctrl-C, unless the first one was delivered twice
      if (Clock::now() - interrupted_at_ < patience_.grace) return;
      std::fputs("\nstopping all processes now\n", stderr);
      next_at_ = Clock::now();
      return;
    }
    result_.interrupted = true;
    interrupted_at_ = Clock::now();
    fmt::print(stderr,
               "\nporetwin: stopping: the window under way is given up and a checkpoint written; a search for rest "
               "ends without one; another signal ends at once after {} s\n",
               std::chrono::duration_cast<std::chrono::seconds>(patience_.grace).count());
    for (auto& child : children_) end(child, child.program.stop_signal);
    schedule(SIGTERM, patience_.after_interrupt);
  }

  void schedule(int signal, std::chrono::milliseconds delay) {
    next_ = signal;
    next_at_ = Clock::now() + delay;
  }

  /// Sends the next, stronger signal to programs that have not ended in time.
  void press() {
    if (!next_ || Clock::now() < next_at_) return;
    end_all(*next_);
    schedule(SIGKILL, patience_.after_term);
  }

  static void end(Child& child, int signal) {
    if (!child.running) return;
    child.asked_to_end = true;
    ::kill(child.pid, signal);
  }
  void end_all(int signal) {
    for (auto& child : children_) end(child, signal);
  }

  const std::function<void(const std::string&)>& progress_;
  const std::function<void(bool)>& tick_;
  Patience patience_;
  Signals signals_;
  std::vector<Child> children_;
  Watched result_;
  std::optional<int> next_;
  Clock::time_point next_at_{}, interrupted_at_{};
};

}  // namespace

Watched run_together(const std::vector<Program>& programs, const std::function<void(const std::string&)>& progress,
                     const std::function<void(bool)>& tick, const Patience& patience) {
  return Watch(progress, tick, patience).run(programs);
}

}  // namespace poretwin::cli
