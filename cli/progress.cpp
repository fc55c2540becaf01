#include "cli/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

namespace poretwin::cli {

ProgressView::ProgressView(bool quiet)
    : quiet_(quiet),
      terminal_(::isatty(STDERR_FILENO) != 0),
      start_(Clock::now()),
      next_(start_ + std::chrono::milliseconds(500)) {}

void ProgressView::line(const std::string& json) {
  const auto data = nlohmann::json::parse(json, nullptr, false);
  if (!data.is_object()) return;
  const auto number = [&](const char* key) {
    const auto found = data.find(key);
    return found != data.end() && found->is_number() ? found->get<double>() : 0.0;
  };
  time_ = number("t");
  end_ = number("end");
  interval_ = number("dt");
  steps_ = number("step");
  const auto waiting = data.find("waiting_for");
  waiting_for_ = waiting != data.end() && waiting->is_string() ? waiting->get<std::string>() : std::string();
  if (!known_) {
    known_ = true;
    first_ = Clock::now();
    first_time_ = time_;
    first_steps_ = steps_;
  }
}

void ProgressView::doing(const std::string& what) { doing_ = what; }

void ProgressView::stopping() {
  if (!asked_to_stop_) asked_to_stop_ = Clock::now();
}

void ProgressView::say(const std::string& line) {
  if (shown_ && terminal_ && !quiet_) fmt::print(stderr, "\r\033[K");
  fmt::print(stderr, "{}\n", line);
  std::fflush(stderr);
}

std::string ProgressView::text() const {
  if (asked_to_stop_) {
    const double since = std::chrono::duration<double>(Clock::now() - *asked_to_stop_).count();
    return fmt::format("stopping since {} at t = {:.4g} s, step {:.0f}{}{}", duration(since), time_, steps_,
                       waiting_for_.empty() ? "" : ": waiting for ", waiting_for_);
  }
  // No time has been simulated yet: programs start, or the initial equilibrium is being searched for.
  if (!known_ || (!doing_.empty() && time_ == 0.0))
    return fmt::format("starting, {}{}{}", duration(std::chrono::duration<double>(Clock::now() - start_).count()),
                       doing_.empty() ? "" : ": ", doing_);
  const double elapsed = std::max(1e-3, std::chrono::duration<double>(Clock::now() - first_).count());
  const double pace = (time_ - first_time_) / elapsed;
  std::string shown = fmt::format("{:3.0f} %  t = {:.4g} of {:.4g} s  step {:.0f} ({:.3g}/s, dt = {:.2g} s)",
                                  end_ > 0.0 ? 100.0 * time_ / end_ : 0.0, time_, end_, steps_,
                                  (steps_ - first_steps_) / elapsed, interval_);
  if (pace > 0.0) shown += "  " + duration((end_ - time_) / pace) + " left";
  if (!waiting_for_.empty()) shown += "  waiting for " + waiting_for_;
  return shown;
}

void ProgressView::tick() {
  const auto now = Clock::now();
  if (quiet_ || now < next_) return;
  next_ = now + (terminal_ ? std::chrono::milliseconds(250) : std::chrono::milliseconds(5000));
  if (terminal_)
    fmt::print(stderr, "\r\033[K{}", text());
  else if (known_ || !doing_.empty() || asked_to_stop_)
    fmt::print(stderr, "{}\n", text());
  std::fflush(stderr);
  shown_ = true;
}

void ProgressView::finish() {
  if (shown_ && terminal_ && !quiet_) fmt::print(stderr, "\r\033[K");
  shown_ = false;
}

ProgressFile::~ProgressFile() {
  std::error_code ignored;
  std::filesystem::remove(file_, ignored);
}

void ProgressFile::line(const std::string& json) {
  const auto now = std::chrono::steady_clock::now();
  if (now < next_) return;
  next_ = now + std::chrono::milliseconds(500);
  auto part = file_;
  part += ".part";
  std::ofstream stream(part, std::ios::binary);
  stream << json << '\n';
  stream.close();
  // Written under another name and then renamed, so that no reader finds half a line.
  std::error_code ignored;
  if (stream)
    std::filesystem::rename(part, file_, ignored);
  else
    std::filesystem::remove(part, ignored);
}

std::string duration(double seconds) {
  const auto s = static_cast<long>(std::max(0.0, seconds) + 0.5);
  if (s < 60) return fmt::format("{} s", s);
  if (s < 3600) return fmt::format("{} min {:02} s", s / 60, s % 60);
  return fmt::format("{} h {:02} min", s / 3600, (s / 60) % 60);
}

}  // namespace poretwin::cli
