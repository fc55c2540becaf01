#include "common/coupling/participant.hpp"

#include "common/coupling/border.hpp"
#include "common/output/build_info.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <condition_variable>
#include <limits>
#include <mutex>
#include <thread>

namespace poretwin::coupling {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

std::size_t bytes_of(const Frames& frames) {
  std::size_t bytes = 0;
  for (const auto& frame : frames) bytes += frame.size;
  return bytes;
}

/// Calls answered() until it returns true or the deadline has passed. Writes a log line now and then while it waits.
template <class Answered>
void wait_for_coupler(const Transport& transport, const std::string& name, const ParticipantOptions& options,
                      Answered&& answered) {
  const auto start = Clock::now();
  auto said = start;
  const auto trouble = [&] { return transport.trouble().empty() ? "" : ": " + transport.trouble(); };
  while (Clock::now() - start < options.welcome_deadline) {
    if (options.interrupted && options.interrupted())
      throw Error(ExitCode::interrupted, name + ": interrupted while waiting for the coupler");
    if (answered()) return;
    if (transport.lost()) throw PeerError(name + ": the coupler at " + transport.address() + " closed the connection");
    if (options.say && Clock::now() - said >= options.say_every) {
      said = Clock::now();
      options.say(fmt::format("{}: waiting for the coupler at {} ({:.0f} s){}", name, transport.address(),
                              seconds_since(start), trouble()));
    }
  }
  throw PeerError(fmt::format("{}: no coupler answered at {} within {} s{}", name, transport.address(),
                              static_cast<double>(options.welcome_deadline.count()) / 1000.0, trouble()));
}

}  // namespace

class Participant::Implementation {
 public:
  Implementation(std::unique_ptr<Transport> transport, Role role, Contract contract, ParticipantOptions options)
      : transport_(std::move(transport)),
        role_(role),
        name_(to_string(role)),
        contract_(std::move(contract)),
        options_(std::move(options)) {}

  ~Implementation() {
    {
      const std::lock_guard lock(mutex_);
      stopping_ = true;
    }
    beat_.notify_all();
    if (thread_.joinable()) thread_.join();
  }

  void join() {
    Hello hello{name_,
                contract_,
                options_.software,
                static_cast<std::uint64_t>(getpid()),
                host(),
                options_.keeps_checkpoints,
                options_.checkpoints};
    send(message_of(std::move(hello)));
    wait_for_coupler(*transport_, name_, options_, [&] {
      const auto message = take(Milliseconds(100));
      return message && answer_to_hello(*message);
    });
  }

  void publish(Publication publication) {
    check(publication);
    Message message;
    message.step = step_;
    message.iteration = iteration_;
    message.time = publication.time;
    auto& points = publication.points;
    message.points = {points.dimension, points.revision, points.size(), points.n_active,
                      !revision_sent_ || *revision_sent_ != points.revision};
    n_active_ = points.n_active;
    if (message.points.sent) {
      message.arrays.push_back({std::string(position_array), "m", points.dimension, std::move(points.position)});
      message.arrays.push_back(
          {std::string(volume_array), fmt::format("m^{}", points.dimension), 1, std::move(points.volume)});
      message.arrays.push_back({std::string(smoothing_length_array), "m", 1, std::move(points.smoothing_length)});
      message.arrays.push_back({std::string(owner_array), "1", 1, std::move(points.owner)});
      revision_sent_ = message.points.revision;
    }
    for (const auto& spec : contract_.gives) {
      auto found = std::find_if(publication.fields.begin(), publication.fields.end(),
                                [&](const Field& f) { return f.name == spec.name; });
      message.arrays.push_back({spec.name, spec.unit, spec.components, std::move(found->values)});
    }
    message.body = PublicationBody{publication.proposed_interval, publication.limited_by, publication.unsettled};
    set_doing("waiting");
    send(std::move(message));
  }

  void reject(const Outcome& outcome) {
    // Before the refusal, so that the coupler does not order the window once more.
    if (interrupted() && !reported_interrupt_) send_heartbeat();
    Message message;
    message.step = step_;
    message.iteration = iteration_;
    message.time = window_.time;
    message.interval = window_.interval;
    message.body = Reject{RejectCode::step,
                          "interval",
                          fmt::format("at most {:g} s", outcome.suggested_interval),
                          fmt::format("{:g} s", window_.interval),
                          outcome.suggested_interval,
                          outcome.reason};
    set_doing("waiting");
    send(std::move(message));
  }

  void confirm_checkpoint(const std::string& name) {
    set_doing("waiting");
    send(message_of(CheckpointWritten{name}, step_));
  }

  Command receive() {
    const auto start = Clock::now();
    auto said = start;
    for (;;) {
      if (interrupted() && !reported_interrupt_) send_heartbeat();
      if (auto message = take(Milliseconds(100))) {
        if (std::holds_alternative<Heartbeat>(message->body)) continue;
        totals_.waiting += seconds_since(start);
        return command_of(std::move(*message));
      }
      if (transport_->lost()) fail("the coupler is gone: its connection closed");
      if (Clock::now() - heard_ > options_.coupler_deadline)
        fail(fmt::format("the coupler is {}: no heartbeat for {:.1f} s",
                         transport_->cut() ? "unreachable, the line is cut or its host is down" : "frozen",
                         seconds_since(heard_)));
      if (Clock::now() - said >= options_.say_every) {
        said = Clock::now();
        say(fmt::format("{}: waiting for {} ({:.0f} s), last message {}", name_,
                        waiting_for_.empty() ? std::string("the coupler") : waiting_for_, seconds_since(start), last_));
      }
    }
  }

  void abort(const std::string& reason, ExitCode code) {
    if (left_.exchange(true)) return;  // all have been informed already
    try {
      send(message_of(Abort{name_, reason, code}, step_));
    } catch (const std::exception&) {
      // The caller throws the error that led here once more; the coupler notices that the connection closes.
    }
  }

  void bye(const std::string& reason) {
    left_ = true;
    send(message_of(Bye{reason}, step_));
  }

  void set_heartbeats(bool on) { heartbeats_ = on; }
  Role role() const { return role_; }
  const Contract& contract() const { return contract_; }
  ParticipantTotals totals() const { return totals_; }

 private:
  bool interrupted() const { return options_.interrupted && options_.interrupted(); }
  void say(const std::string& line) const {
    if (options_.say) options_.say(line);
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw PeerError(fmt::format("{}: {}; at step {}, last message from the coupler: {}", name_, what, step_, last_));
  }

  /// Fills in sender, session and sequence number, and sends.
  void send(Message message) {
    const auto start = Clock::now();
    const std::lock_guard lock(sending_);
    message.session = session_;
    message.sender = name_;
    message.sequence = ++sequence_;
    const bool beat = std::holds_alternative<Heartbeat>(message.body);
    Frames frames = encode(std::move(message));
    if (!beat) {
      ++totals_.messages_sent;
      totals_.bytes_sent += bytes_of(frames);
    }
    transport_->send(std::move(frames));
    if (!beat) totals_.sending += seconds_since(start);
  }

  /// The next message of any kind. ABORT and BYE throw here.
  std::optional<Message> take(Milliseconds timeout) {
    auto frames = transport_->receive(timeout);
    if (!frames) return std::nullopt;
    Message message = decode(*frames);
    heard_ = Clock::now();
    if (message.major != protocol_major)
      throw PeerError(fmt::format("{}: refused: protocol: expected {}.x, the coupler speaks {}.{}", name_,
                                  protocol_major, message.major, message.minor));
    if (const auto* beat = std::get_if<Heartbeat>(&message.body)) {
      waiting_for_ = beat->waiting_for;
      return message;
    }
    ++totals_.messages_received;
    totals_.bytes_received += bytes_of(*frames);
    last_ = describe(message);
    if (const auto* abort = std::get_if<Abort>(&message.body)) {
      left_ = true;
      throw Error(abort->code, fmt::format("{}: the run was aborted by {}: {}", name_, abort->culprit, abort->reason));
    }
    if (const auto* bye = std::get_if<Bye>(&message.body)) fail("the coupler left: " + bye->reason);
    return message;
  }

  bool answer_to_hello(const Message& message) {
    if (const auto* reject = std::get_if<Reject>(&message.body))
      throw PeerError(fmt::format("{}: refused by the coupler: {}: expected {}, got {}{}{}", name_, reject->field,
                                  reject->expected, reject->got, reject->reason.empty() ? "" : "; ", reject->reason));
    const auto* welcome = std::get_if<Welcome>(&message.body);
    if (!welcome) return false;
    session_ = message.session;
    const double interval = std::clamp(welcome->heartbeat_interval, 0.01, 10.0);
    interval_ = Milliseconds(static_cast<int>(1000.0 * interval));
    set_doing("computing");
    thread_ = std::thread([this] { keep_beating(); });
    return true;
  }

  Command command_of(Message message) {
    Command command;
    command.window = {message.step, message.time, message.interval};
    step_ = message.step;
    iteration_ = message.iteration;
    if (const auto* b = std::get_if<Initialise>(&message.body)) {
      command.kind = Command::Kind::initialise;
      command.record_frame = b->record_frame;
      command.record_gauges = b->record_gauges;
      command.inbox = inbox_of(message);
    } else if (const auto* a = std::get_if<Advance>(&message.body)) {
      command.kind = Command::Kind::advance;
      command.record_frame = a->record_frame;
      command.record_gauges = a->record_gauges;
      command.window.pass = a->pass;
      window_ = command.window;
      if (!(window_.interval > 0.0) || !std::isfinite(window_.interval) || !std::isfinite(window_.time))
        fail(fmt::format("a window of {} s from t = {} s makes no sense", window_.interval, window_.time));
      command.inbox = inbox_of(message);
      n_active_before_ = n_active_;
    } else if (const auto* r = std::get_if<Restore>(&message.body)) {
      command.kind = Command::Kind::restore;
      command.reason = r->reason;
      n_active_ = n_active_before_;
      revision_sent_.reset();  // after a restore, the phase may use the same revision number for other points
    } else if (const auto* c = std::get_if<CheckpointOrder>(&message.body)) {
      command.kind = Command::Kind::checkpoint;
      command.checkpoint = c->name;
      command.keep = c->keep;
    } else if (const auto* resume = std::get_if<Resume>(&message.body)) {
      command.kind = Command::Kind::resume;
      command.checkpoint = resume->name;
      revision_sent_.reset();
    } else if (const auto* f = std::get_if<Finish>(&message.body)) {
      command.kind = Command::Kind::finish;
      command.reason = f->reason;
      command.record_frame = f->record_frame;
      command.record_gauges = f->record_gauges;
    } else {
      fail("an unexpected " + describe(message) + " came in");
    }
    const bool writing = command.kind == Command::Kind::finish || command.kind == Command::Kind::checkpoint;
    set_doing(writing ? "writing" : "computing");
    return command;
  }

  Inbox inbox_of(Message& message) const {
    Inbox inbox;
    for (auto& array : message.arrays) {
      if (array.size() != n_active_ * static_cast<std::size_t>(array.components))
        fail(fmt::format("field '{}' came for {} points, {} were expected", array.name,
                         array.size() / static_cast<std::size_t>(array.components), n_active_));
      auto values = array.take();
      constexpr double largest = std::numeric_limits<double>::max();
      if (const auto bad = first_outside(values, -largest, largest); bad != values.size())
        fail(fmt::format("field '{}' holds {} at point {}", array.name, values[bad],
                         bad / static_cast<std::size_t>(array.components)));
      if (array.name == coverage_array)
        inbox.coverage = std::move(values);
      else if (array.name == asymmetry_array)
        inbox.asymmetry = std::move(values);
      else if (array.name == spread_array)
        inbox.spread = std::move(values);
      else if (array.name.ends_with(start_suffix))
        inbox.at_start.push_back(
            {array.name.substr(0, array.name.size() - start_suffix.size()), array.components, std::move(values)});
      else if (array.name.ends_with(found_suffix))
        inbox.found.push_back(
            {array.name.substr(0, array.name.size() - found_suffix.size()), array.components, std::move(values)});
      else
        inbox.fields.push_back({std::move(array.name), array.components, std::move(values)});
    }
    if (inbox.coverage.size() != n_active_) fail("the coverage is missing from " + describe(message));
    if (inbox.asymmetry.size() != n_active_) fail("the asymmetry is missing from " + describe(message));
    for (const auto& spec : contract_.takes)
      if (inbox.at(spec.name).components != spec.components)
        fail(fmt::format("field '{}': expected {} components, got {}", spec.name, spec.components,
                         inbox.at(spec.name).components));
    for (const auto* more : {&inbox.at_start, &inbox.found})
      for (const auto& field : *more)
        if (inbox.at(field.name).components != field.components)
          fail(fmt::format(
              "field '{}': expected {} components at {}, got {}", field.name, inbox.at(field.name).components,
              more == &inbox.at_start ? "the window's start" : "the end that a pass found", field.components));
    return inbox;
  }

  void check(const Publication& publication) const {
    const auto& points = publication.points;
    const std::size_t n = points.size();
    auto refuse = [&](const std::string& what) {
      throw Error(ExitCode::failure, name_ + ": own publication: " + what);
    };
    if (points.dimension != contract_.dimension) refuse("its points have another dimension than the contract");
    if (points.position.size() != n * static_cast<std::size_t>(points.dimension) ||
        points.smoothing_length.size() != n || points.owner.size() != n)
      refuse("positions, volumes, smoothing lengths and owners differ in number");
    if (points.n_active > n) refuse("more active points than points");
    for (const auto& spec : contract_.gives) {
      const auto found = std::find_if(publication.fields.begin(), publication.fields.end(),
                                      [&](const Field& f) { return f.name == spec.name; });
      if (found == publication.fields.end()) refuse("field '" + spec.name + "' is missing");
      if (found->components != spec.components || found->values.size() != n * static_cast<std::size_t>(spec.components))
        refuse(fmt::format("field '{}' should hold {} x {} values, holds {}", spec.name, n, spec.components,
                           found->values.size()));
    }
  }

  void set_doing(std::string what) {
    const std::lock_guard lock(mutex_);
    doing_ = std::move(what);
    doing_since_ = Clock::now();
    doing_step_ = step_;
  }

  void send_heartbeat() {
    Message message;
    Heartbeat beat;
    {
      const std::lock_guard lock(mutex_);
      beat.doing = doing_;
      beat.since = seconds_since(doing_since_);
      message.step = doing_step_;
    }
    beat.interrupted = interrupted();
    if (beat.interrupted) reported_interrupt_ = true;
    message.body = std::move(beat);
    send(std::move(message));
  }

  void keep_beating() {
    std::unique_lock lock(mutex_);
    while (!stopping_) {
      beat_.wait_for(lock, interval_, [&] { return stopping_; });
      if (stopping_) return;
      lock.unlock();
      try {
        if (heartbeats_ && !left_) send_heartbeat();
      } catch (const std::exception& error) {
        say(name_ + ": no heartbeat: " + error.what());
      }
      lock.lock();
    }
  }

  std::unique_ptr<Transport> transport_;
  const Role role_;
  const std::string name_;
  const Contract contract_;
  const ParticipantOptions options_;

  std::string session_;
  std::uint64_t step_ = 0;
  std::uint32_t iteration_ = 0;
  Window window_;
  std::size_t n_active_ = 0, n_active_before_ = 0;  ///< number of receiving points: now; at the window's start
  std::optional<std::uint64_t> revision_sent_;
  Clock::time_point heard_ = Clock::now();
  std::string last_ = "none", waiting_for_;
  ParticipantTotals totals_;

  std::mutex sending_;  ///< keeps sequence numbers in the order of sending
  std::uint64_t sequence_ = 0;

  std::mutex mutex_;  ///< guards what the heartbeat thread reads
  std::condition_variable beat_;
  bool stopping_ = false;
  std::string doing_ = "computing";
  std::uint64_t doing_step_ = 0;
  Clock::time_point doing_since_ = Clock::now();
  Milliseconds interval_{1000};
  std::atomic<bool> heartbeats_ = true, left_ = false, reported_interrupt_ = false;
  std::thread thread_;
};

CaseFile request_case(Transport& transport, Role role, const ParticipantOptions& options) {
  const std::string name(to_string(role));
  Message request = message_of(CaseRequest{name});
  request.sender = name;
  request.sequence = 1;
  transport.send(encode(std::move(request)));
  CaseFile out;
  wait_for_coupler(transport, name, options, [&] {
    const auto frames = transport.receive(Milliseconds(100));
    if (!frames) return false;
    Message message = decode(*frames);
    if (const auto* reject = std::get_if<Reject>(&message.body))
      throw PeerError(fmt::format("{}: no case from the coupler: {}: expected {}, got {}", name, reject->field,
                                  reject->expected, reject->got));
    if (auto* file = std::get_if<CaseFile>(&message.body)) {
      out = std::move(*file);
      return true;
    }
    return false;
  });
  return out;
}

Participant::Participant(std::unique_ptr<Transport> transport, Role role, Contract contract, ParticipantOptions options)
    : implementation_(
          std::make_unique<Implementation>(std::move(transport), role, std::move(contract), std::move(options))) {}
Participant::~Participant() = default;
void Participant::join() { implementation_->join(); }
void Participant::publish(Publication publication) { implementation_->publish(std::move(publication)); }
void Participant::reject(const Outcome& outcome) { implementation_->reject(outcome); }
void Participant::confirm_checkpoint(const std::string& name) { implementation_->confirm_checkpoint(name); }
Command Participant::receive() { return implementation_->receive(); }
void Participant::abort(const std::string& reason, ExitCode code) { implementation_->abort(reason, code); }
void Participant::bye(const std::string& reason) { implementation_->bye(reason); }
Role Participant::role() const { return implementation_->role(); }
const Contract& Participant::contract() const { return implementation_->contract(); }
ParticipantTotals Participant::totals() const { return implementation_->totals(); }
void Participant::set_heartbeats(bool on) { implementation_->set_heartbeats(on); }

}  // namespace poretwin::coupling
