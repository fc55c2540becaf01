// A recorded solver as a phase: publishes what its wire log contains, for the same windows.
#include "common/coupling/phase_main.hpp"
#include "common/coupling/summary.hpp"
#include "peer/arguments.hpp"
#include "peer/peer.hpp"
#include "peer/wire_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

namespace poretwin::peer {
namespace {

using namespace coupling;

class Replay final : public Phase {
 public:
  explicit Replay(const std::filesystem::path& log) : log_(log) {
    const Message first = next(Direction::to_coupler);
    const auto* hello = std::get_if<Hello>(&first.body);
    if (!hello) throw PeerError(log.string() + ": expected HELLO, found " + describe(first));
    contract_ = hello->contract;
    role_ = hello->role;
    next(Direction::from_coupler);  // WELCOME
    take_publication();
  }

  [[nodiscard]] const std::string& role() const { return role_; }
  [[nodiscard]] Contract contract() const override { return contract_; }
  [[nodiscard]] Publication publish() const override { return now_; }

  void initialise(const Inbox& inbox) override {
    compare(next(Direction::from_coupler), inbox);
    take_publication();
  }

  Outcome advance(const Window& window, const Inbox& inbox) override {
    const Message then = next(Direction::from_coupler);
    if (!std::holds_alternative<Advance>(then.body) || then.step != window.step || then.time != window.time ||
        then.interval != window.interval)
      throw PeerError(fmt::format(
          "the run has left its recording: then {} with a window of {} s, now step {} from t = {} s with {} s{}",
          describe(then), then.interval, window.step, window.time, window.interval,
          difference_.empty() ? "" : "; " + difference_));
    compare(then, inbox);
    ++windows_;
    Message answer = next(Direction::to_coupler);
    if (const auto* reject = std::get_if<Reject>(&answer.body))
      return Outcome::reject(reject->suggested_interval, reject->reason);
    now_ = publication_of(std::move(answer));
    return Outcome::accept();
  }

  void save() override {}
  void restore() override {
    const Message then = next(Direction::from_coupler);
    if (!std::holds_alternative<Restore>(then.body))
      throw PeerError("the run has left its recording: then " + describe(then) + ", now RESTORE");
  }

  void archive(Archive& archive) override {
    std::uint64_t at = records_;
    archive(at, now_, difference_, windows_, same_, different_);
    for (; records_ < at; ++records_)
      if (!log_.next()) throw PeerError("the recording ends before the checkpoint");
  }

  [[nodiscard]] OutputFrame frame() const override {
    OutputFrame out;
    out.time = now_.time;
    out.count = now_.points.n_active;
    out.position = [this](std::size_t i, double* x) {
      const auto d = static_cast<std::size_t>(now_.points.dimension);
      for (std::size_t c = 0; c < 3; ++c) x[c] = c < d ? now_.points.position[i * d + c] : 0.0;
    };
    return out;
  }
  [[nodiscard]] std::vector<GaugeReading> gauges() const override { return {}; }
  [[nodiscard]] std::map<std::string, double> counters() const override {
    return {{"windows replayed", static_cast<double>(windows_)},
            {"inboxes as recorded", static_cast<double>(same_)},
            {"inboxes that differ", static_cast<double>(different_)}};
  }

 private:
  /// The next message in that direction, except for heartbeats and requests for the case.
  Message next(Direction direction) {
    while (auto record = log_.next()) {
      ++records_;
      Message message = decode(record->frames);
      if (std::holds_alternative<Heartbeat>(message.body) || std::holds_alternative<CaseRequest>(message.body) ||
          std::holds_alternative<CaseFile>(message.body) || std::holds_alternative<CheckpointOrder>(message.body) ||
          std::holds_alternative<CheckpointWritten>(message.body))
        continue;
      if (record->direction != direction)
        throw PeerError(fmt::format("the recording goes on with {} of the {}", describe(message),
                                    record->direction == Direction::to_coupler ? role_ : "coupler"));
      return message;
    }
    throw PeerError("the recording ends here: the run that was recorded went no further");
  }

  void take_publication() {
    Message message = next(Direction::to_coupler);
    if (!std::holds_alternative<PublicationBody>(message.body))
      throw PeerError("the recorded " + role_ + " left with " + describe(message));
    now_ = publication_of(std::move(message));
  }

  Publication publication_of(Message message) {
    Publication out;
    out.time = message.time;
    const auto& body = std::get<PublicationBody>(message.body);
    out.proposed_interval = body.proposed_interval;
    out.limited_by = body.limited_by;
    out.unsettled = body.unsettled;
    out.points = now_.points;
    out.points.dimension = message.points.dimension;
    out.points.revision = message.points.revision;
    out.points.n_active = message.points.n_active;
    for (auto& array : message.arrays) {
      if (array.name == position_array)
        out.points.position = array.take();
      else if (array.name == volume_array)
        out.points.volume = array.take();
      else if (array.name == smoothing_length_array)
        out.points.smoothing_length = array.take();
      else if (array.name == owner_array)
        out.points.owner = array.take();
      else
        out.fields.push_back({array.name, array.components, array.take()});
    }
    return out;
  }

  /// Compares received fields with the recorded ones bit by bit; stores and reports the first difference.
  void compare(Message then, const Inbox& inbox) {
    std::string found;
    for (auto& array : then.arrays) {
      const auto values = array.take();
      const std::vector<double>* now = nullptr;
      if (array.name == coverage_array)
        now = &inbox.coverage;
      else if (array.name == asymmetry_array)
        now = &inbox.asymmetry;
      else if (array.name == spread_array)
        now = &inbox.spread;
      else
        for (const auto& field : inbox.fields)
          if (field.name == array.name) now = &field.values;
      for (const auto& field : inbox.at_start)
        if (field.name + std::string(start_suffix) == array.name) now = &field.values;
      if (!now || now->size() != values.size()) {
        found = fmt::format("'{}' had {} values then, {} now", array.name, values.size(), now ? now->size() : 0);
        break;
      }
      for (std::size_t k = 0; k < now->size() && found.empty(); ++k)
        if (std::memcmp(&(*now)[k], &values[k], sizeof(double)) != 0)
          found = fmt::format("'{}' of point {} was {} then, is {} now", array.name,
                              k / static_cast<std::size_t>(array.components), values[k], (*now)[k]);
      if (!found.empty()) break;
    }
    if (found.empty()) {
      ++same_;
      return;
    }
    ++different_;
    if (!difference_.empty()) return;
    difference_ = fmt::format("what comes in differs from step {} on: {}", then.step, found);
    log_line(role_ + ": replay: " + difference_);
  }

  WireLogReader log_;
  std::string role_, difference_;
  Contract contract_;
  Publication now_;
  std::uint64_t windows_ = 0, same_ = 0, different_ = 0, records_ = 0;  // counted from the start of the run
};

}  // namespace

int replay(const std::filesystem::path& log, const std::vector<std::string>& arguments) {
  const std::string role = Replay(log).role();
  if (role != "fluid" && role != "solid") throw PeerError(log.string() + ": recorded of a '" + role + "'");
  ArgumentList list("poretwin-" + role, arguments);
  return phase_main(list.count(), list.data(), role == "fluid" ? Role::fluid : Role::solid,
                    [&](const Case&) { return std::make_unique<Replay>(log); });
}

}  // namespace poretwin::peer
