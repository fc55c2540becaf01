// The progress of a run for the user: one live line on a terminal, else a plain line every few seconds.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>

namespace poretwin::cli {

class ProgressView {
 public:
  explicit ProgressView(bool quiet);
  /// Takes a progress line of a child process, JSON {"t","end","step","dt","waiting_for"}; ignores anything else.
  void line(const std::string& json);
  /// Sets the text shown while no time has been simulated yet, for example during the search for equilibrium.
  void doing(const std::string& what);
  /// The run has been asked to stop: what it still does is shown, in place of the time that is left.
  void stopping();
  /// Prints a line that remains, even where progress is not shown.
  void say(const std::string& line);
  /// Shows the latest state if the time for it has come.
  void tick();
  /// Clears the progress line of the terminal.
  void finish();
  /// The line that tick() shows.
  [[nodiscard]] std::string text() const;

 private:
  using Clock = std::chrono::steady_clock;
  bool quiet_, terminal_;
  bool known_ = false, shown_ = false;
  double time_ = 0.0, end_ = 0.0, interval_ = 0.0, steps_ = 0.0, first_time_ = 0.0, first_steps_ = 0.0;
  std::string waiting_for_, doing_;
  Clock::time_point start_, first_, next_;
  std::optional<Clock::time_point> asked_to_stop_;
};

/// The latest progress line as a file in the run's folder, for programs that watch the run (`poretwin view`). It is
/// removed at the end of the run. A full disk is not reported here, since the processes report it.
class ProgressFile {
 public:
  explicit ProgressFile(std::filesystem::path file) : file_(std::move(file)) {}
  ProgressFile(const ProgressFile&) = delete;
  ProgressFile& operator=(const ProgressFile&) = delete;
  ~ProgressFile();
  /// Writes the line to the file, at most twice a second.
  void line(const std::string& json);

 private:
  std::filesystem::path file_;
  std::chrono::steady_clock::time_point next_{};
};

/// A duration as text: "4 s", "3 min 20 s", "2 h 05 min".
std::string duration(double seconds);

}  // namespace poretwin::cli
