// A complete coupled run of two phases (mocks or solvers) and the coupler in one process, over any transport. Deadlines
// are short, so that nothing can hang.
#pragma once

#include "common/coupling/drive.hpp"
#include "common/coupling/mock.hpp"
#include "common/coupling/standard_contract.hpp"
#include "coupler/pairing.hpp"
#include "coupler/schedule.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <functional>
#include <optional>
#include <thread>

namespace poretwin::coupling {

enum class Line { in_process, ipc, tcp };

inline std::string line_name(Line line) {
  return line == Line::in_process ? "in_process" : line == Line::ipc ? "ipc" : "tcp";
}

/// How one of the three ended.
struct Fate {
  std::string error;  ///< empty: all went well
  ExitCode code = ExitCode::success;
  bool died = false;
  DriveReport report;
};

struct CoupledRun {
  // Inputs.
  Line line = Line::in_process;
  int dimension = 2;
  bool paired = false;  ///< both solvers have the same points
  WindowClock::Settings settings{1.0, 0.1, 0.0, 0.0};
  BrokerOptions broker;
  ParticipantOptions participant;
  std::filesystem::path checkpoints;   ///< folder; empty: no checkpoints
  double checkpoint_every = no_limit;  ///< s
  bool resume = false, only_coupler_keeps = false;
  std::uint64_t stop_after = 0;  ///< windows after which Ctrl-C is simulated; 0: never
  Scheme scheme;
  std::function<std::string(const std::string&)> route;            ///< address for participants, given the coupler's
  std::function<std::unique_ptr<Hub>(std::unique_ptr<Hub>)> wrap;  ///< what the coupler gets in place of its hub
  // Results.
  Fate fluid, solid, coupler;
  MemoryRecorder fluid_record, solid_record;
  ScheduleReport report;
  BrokerTotals totals;
  std::vector<std::string> log;
  double wall = 0.0;  ///< s

  CoupledRun() {
    broker.case_digest = "mock";
    broker.wait_deadline = Milliseconds(5000);
    broker.frozen_deadline = Milliseconds(5000);
    broker.heartbeat = Milliseconds(50);
    participant.welcome_deadline = Milliseconds(5000);
    participant.coupler_deadline = Milliseconds(10000);
  }

  /// Either phase may be nullptr.
  void run(Phase* fluid_phase, Phase* solid_phase) {
    const auto start = std::chrono::steady_clock::now();
    std::unique_ptr<Hub> hub;
    if (line == Line::in_process)
      hub = in_process_.hub();
    else
      hub = bind_socket(line == Line::ipc ? "ipc://" + socket_path() : "tcp://127.0.0.1:*");
    address_ = route ? route(hub->address()) : hub->address();
    if (wrap) hub = wrap(std::move(hub));
    std::thread fluid_thread([&] { drive(fluid_phase, Role::fluid, fluid_record, fluid, fluid_participant_); });
    std::thread solid_thread([&] { drive(solid_phase, Role::solid, solid_record, solid, solid_participant_); });
    guard(coupler, [&] {
      auto options = broker;
      options.dimension = dimension;
      options.say = [this](const std::string& text) { log.push_back(text); };
      std::uint64_t step = 0;
      if (stop_after > 0) options.interrupted = [&] { return step >= stop_after; };
      const CheckpointStore store(checkpoints, "coupler", {});
      Broker b(*hub, options);
      Schedule schedule(
          b, paired ? make_paired_mapping(dimension) : make_mapping(dimension), settings,
          [&](const Progress& progress) { step = progress.step; },
          {checkpoints.empty() ? nullptr : &store, checkpoint_every, resume}, scheme);
      try {
        schedule.run();
      } catch (...) {
        report = schedule.report();
        totals = b.totals();
        throw;
      }
      report = schedule.report();
      totals = b.totals();
    });
    hub.reset();
    fluid_thread.join();
    solid_thread.join();
    if (line == Line::ipc) std::filesystem::remove(socket_path());
    wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }

  /// For MockKnobs::on_freeze: the participant becomes silent as a stopped process would.
  void silence(Role role) {
    auto& participant_now = role == Role::fluid ? fluid_participant_ : solid_participant_;
    participant_now->set_heartbeats(false);
  }

  void expect_success() const {
    EXPECT_EQ(fluid.error, "");
    EXPECT_EQ(solid.error, "");
    EXPECT_EQ(coupler.error, "");
  }

 private:
  static std::string socket_path() {
    return (std::filesystem::temp_directory_path() / ("poretwin-test-" + std::to_string(getpid()))).string();
  }

  template <class F>
  static void guard(Fate& fate, F&& f) {
    try {
      f();
    } catch (const Error& error) {
      fate.error = error.what();
      fate.code = error.code();
    } catch (const std::exception& error) {
      fate.error = error.what();
      fate.code = ExitCode::failure;
    } catch (const MockDeath&) {
      fate.died = true;
      fate.error = "died";
    }
  }

  void drive(Phase* phase, Role role, MemoryRecorder& record, Fate& fate, std::optional<Participant>& place) {
    if (!phase) return;
    guard(fate, [&] {
      auto transport = line == Line::in_process ? in_process_.line() : connect_socket(address_);
      const CheckpointStore store(checkpoints, std::string(to_string(role)), {});
      auto options = participant;
      options.keeps_checkpoints = !checkpoints.empty() && !only_coupler_keeps;
      if (resume)
        for (const auto& checkpoint : store.whole()) options.checkpoints.push_back(checkpoint.name);
      place.emplace(std::move(transport), role, phase->contract(), options);
      struct Leave {
        std::optional<Participant>& p;
        ~Leave() { p.reset(); }
      } leave{place};
      drive_coupled(*phase, *place, record, fate.report, checkpoints.empty() ? nullptr : &store);
    });
  }

  InProcess in_process_;
  std::string address_;
  std::optional<Participant> fluid_participant_, solid_participant_;
};

/// A value within the bounds of its field: `free` where any number is allowed, else that of soil and water at rest.
inline double within_bounds(const std::string& name, double free) {
  const auto& field = *standard_field(name);
  if (field.bounds.low < 0.0) return free;
  return field.name == field::constrained_modulus ? std::abs(free) : field.at_rest;
}

/// A square of 1 m x 1 m with fields of the standard contract.
inline MockPhase::Formula still_square(Role role, double spacing = 0.1, FieldFormula formula = {}) {
  return [=](double t) {
    return formula_publication(role, t, lattice_points(2, {0.0, 0.0}, {1.0, 1.0}, spacing), formula);
  };
}

}  // namespace poretwin::coupling
