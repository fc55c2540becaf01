// Plays the part of the coupler for one start of a solver's command, strictly by docs/protocol.md.
#pragma once

#include "common/case/case.hpp"
#include "common/coupling/border.hpp"
#include "common/coupling/transport.hpp"
#include "peer/child.hpp"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace poretwin::peer {

/// A fault of the solver, described in plain words.
struct Failed {
  std::string what;
};

/// Coverage of a place [m] by the other phase: 1 inside its cloud, 0 outside.
using Sight = std::function<double(const Point3&)>;

class Examiner {
 public:
  Examiner(const Case& scene, const std::filesystem::path& case_file, const std::vector<std::string>& command,
           const std::filesystem::path& log);
  /// Starts the same solver again, to resume in the folder where `before` left its checkpoints.
  Examiner(const Examiner& before, const std::filesystem::path& log);

  /// Waits for HELLO and checks it; before HELLO, answers a request for the case.
  const coupling::Hello& hello();
  void welcome();
  /// Exchanges HELLO, WELCOME, a publication, INITIALISE with fields at rest, and another publication.
  void begin();

  /// Sends ADVANCE by `interval` [s]. Returns the refusal; empty if accepted, and the publication becomes the state.
  std::optional<coupling::Reject> advance(double interval, const Sight& sight);
  /// Advances by one window, which is shortened as often as the solver requires.
  void window(const Sight& sight);
  void restore();
  /// Sends CHECKPOINT and checks the answer.
  void checkpoint(const std::string& name, const std::vector<std::string>& keep);
  /// Exchanges HELLO, WELCOME, a publication, RESUME to the state that `before` had at the checkpoint, and another
  /// publication.
  void resume(const std::string& name, const Examiner& before);
  /// Kills the solver, as kill -9 does.
  void kill();
  void finish(const std::string& reason);

  /// Counts the heartbeats that arrive within this time; any other message is a fault.
  int idle(coupling::Milliseconds time);
  /// Sends a message without arrays.
  void send(coupling::Body body);
  void expect_exit(int code, const std::string& after);
  void hang_up() { hub_.reset(); }
  void interrupt();

  /// Longest next window [s] that the solver and the case allow.
  [[nodiscard]] double allowed() const;
  [[nodiscard]] bool keeps_checkpoints() const { return hello_.keeps_checkpoints; }
  [[nodiscard]] const coupling::Snapshot& state() const { return state_; }
  [[nodiscard]] std::uint32_t& foreign_major() { return major_; }

 private:
  coupling::Message next(const std::string& awaited);
  void send(coupling::Message message);
  void send_mapped(coupling::Message message, const Sight& sight);
  void take_publication(const std::string& after, double time);
  bool note(coupling::Hub::Event event, std::optional<coupling::Message>& out);

  Examiner(const Case& scene, const std::filesystem::path& case_file, std::vector<std::string> command,
           const std::filesystem::path& log, std::shared_ptr<PrivateFolder> folder, const std::string& socket);

  const Case& scene_;
  std::filesystem::path case_file_;
  std::vector<std::string> command_;
  std::shared_ptr<PrivateFolder> folder_;
  std::unique_ptr<coupling::Hub> hub_;
  Child child_;
  std::string line_;
  bool closed_ = false, interrupted_ = false;
  coupling::Hello hello_;
  coupling::Snapshot state_, before_;
  std::uint64_t heard_ = 0, sent_ = 0, step_ = 0;
  std::uint32_t iteration_ = 0, major_ = coupling::protocol_major;
  double time_ = 0.0;
  int heartbeats_ = 0;
  bool welcomed_ = false, after_restore_ = false;
  std::chrono::steady_clock::time_point beat_{};
};

}  // namespace poretwin::peer
