#include "common/ranks/led_phase.hpp"

#include "common/core/archive.hpp"
#include "common/output/build_info.hpp"

#include <fmt/format.h>

#include <chrono>
#include <thread>

namespace poretwin::ranks {
namespace {

using coupling::Inbox;
using coupling::Outcome;
using coupling::Window;

/// What all ranks must have in common.
struct Beginning {
  std::string path;  ///< of the case
  std::vector<std::string> overrides;
  std::string digest;   ///< of the case
  std::string program;  ///< version and build
};

std::string program() { return version() + ", " + build(); }

Case case_of(const Beginning& first) {
  const auto expect = [](const char* what, const std::string& expected, const std::string& found) {
    if (found != expected)
      throw Error(ExitCode::failure,
                  fmt::format("{}: expected that of rank 0, {}, found {}: all machines need the same program and the "
                              "same case",
                              what, expected, found));
  };
  expect("program", first.program, program());
  Case scene = read_case(first.path, first.overrides);
  expect("case", first.digest, scene.digest());
  return scene;
}

/// Rank 0's part of a phase, whose calls the other ranks make, too.
class LedPhase final : public Phase {
 public:
  LedPhase(Leader& leader, std::unique_ptr<Phase> own) : leader_(leader), own_(std::move(own)) {}

  [[nodiscard]] coupling::Contract contract() const override { return own_->contract(); }
  [[nodiscard]] coupling::Publication publish() const override {
    return leader_.call(Call::publish, [&] { return own_->publish(); });
  }
  [[nodiscard]] std::pair<double, std::string> proposal() const override {
    return leader_.call(Call::propose, [&] { return own_->proposal(); });
  }
  void initialise(const Inbox& inbox) override {
    leader_.call(Call::initialise, [&] { own_->initialise(inbox); });
  }
  Outcome advance(const Window& window, const Inbox& inbox) override {
    leader_.at_step(window.step);
    return leader_.call(
        Call::advance, [&] { return own_->advance(window, inbox); }, window);
  }
  void save() override {
    leader_.call(Call::save, [&] { own_->save(); });
  }
  void restore() override {
    leader_.call(Call::restore, [&] { own_->restore(); });
  }
  [[nodiscard]] bool may_reject() const override { return own_->may_reject(); }
  void archive(Archive& archive) override {
    leader_.call(archive.loading() ? Call::read_state : Call::write_state, [&] { own_->archive(archive); });
  }
  [[nodiscard]] OutputFrame frame() const override {
    return leader_.call(Call::frame, [&] { return own_->frame(); });
  }
  [[nodiscard]] std::vector<GaugeReading> gauges() const override {
    return leader_.call(Call::gauges, [&] { return own_->gauges(); });
  }
  /// Asked for after a failure, too: then there are none, since they are counted on all ranks.
  [[nodiscard]] std::map<std::string, double> counters() const override {
    if (leader_.failed()) return {};
    return leader_.call(Call::counters, [&] { return own_->counters(); });
  }
  [[nodiscard]] std::vector<Warning> warnings() const override { return own_->warnings(); }

 private:
  Leader& leader_;
  std::unique_ptr<Phase> own_;
};

}  // namespace

std::unique_ptr<Phase> Leader::make(const Case& scene, const MakePart& part) {
  auto own = call(
      Call::make, [&] { return part(scene); },
      Beginning{std::filesystem::absolute(scene.path).string(), scene.overrides, scene.digest(), program()});
  return std::make_unique<LedPhase>(*this, std::move(own));
}

void Leader::announce(const std::string& call) const {
  if (failed_) throw Error(ExitCode::failure, "the ranks of this run cannot go on after an error");
  static_cast<void>(all_.from_first(call));
}

void Leader::end(int code) {
  if (failed_) throw Error(static_cast<ExitCode>(code), "the error above");
  call(Call::end, [] {});
}

void follow(const tiles::Communicator& all, const MakePart& part) {
  std::unique_ptr<Phase> phase;
  const Inbox nothing;
  try {
    for (;;) {
      Archive said(all.from_first({}));
      Call call{};
      said(call);
      switch (call) {
        case Call::make: {
          Beginning first;
          said(first);
          phase = part(case_of(first));
          break;
        }
        case Call::initialise:
          phase->initialise(nothing);
          break;
        case Call::publish:
          static_cast<void>(phase->publish());
          break;
        case Call::propose:
          static_cast<void>(phase->proposal());
          break;
        case Call::advance: {
          Window window;
          said(window);
          all.at_step(window.step);
          static_cast<void>(phase->advance(window, nothing));
          break;
        }
        case Call::save:
          phase->save();
          break;
        case Call::restore:
          phase->restore();
          break;
        case Call::write_state: {
          Archive none;
          phase->archive(none);
          break;
        }
        case Call::read_state: {
          Archive none{std::string()};
          phase->archive(none);
          break;
        }
        case Call::frame:
          static_cast<void>(phase->frame());
          break;
        case Call::gauges:
          static_cast<void>(phase->gauges());
          break;
        case Call::counters:
          static_cast<void>(phase->counters());
          break;
        case Call::end:
          return;
      }
    }
  } catch (...) {
    std::this_thread::sleep_for(std::chrono::seconds(1));
    throw;
  }
}

}  // namespace poretwin::ranks
