#include "peer/examiner.hpp"

#include "common/core/error.hpp"
#include "peer/still.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <csignal>

namespace poretwin::peer {
namespace {

using namespace coupling;
using Clock = std::chrono::steady_clock;

constexpr auto heartbeat = Milliseconds(200);
constexpr auto patience = std::chrono::seconds(60);        // longest wait for an answer
constexpr auto goodbye_within = std::chrono::seconds(10);  // longest wait for the end of the process
constexpr std::string_view session = "conformance";
const std::string second_socket = "socket of the second start";

}  // namespace

Examiner::Examiner(const Case& scene, const std::filesystem::path& case_file, std::vector<std::string> command,
                   const std::filesystem::path& log, std::shared_ptr<PrivateFolder> folder, const std::string& socket)
    : scene_(scene),
      case_file_(case_file),
      command_(std::move(command)),
      folder_(std::move(folder)),
      hub_(bind_socket("ipc://" + (folder_->path() / socket).string())),
      child_(
          [&] {
            auto words = command_;
            words.insert(words.end(), {"--case", case_file.string(), "--out", (folder_->path() / "out").string(),
                                       "--connect", "ipc://" + (folder_->path() / socket).string()});
            if (socket == second_socket) words.push_back("--resume");
            return words;
          }(),
          log) {}

Examiner::Examiner(const Case& scene, const std::filesystem::path& case_file, const std::vector<std::string>& command,
                   const std::filesystem::path& log)
    : Examiner(scene, case_file, command, log, std::make_shared<PrivateFolder>(), "socket") {}

Examiner::Examiner(const Examiner& before, const std::filesystem::path& log)
    : Examiner(before.scene_, before.case_file_, before.command_, log, before.folder_, second_socket) {}

bool Examiner::note(Hub::Event event, std::optional<Message>& out) {
  if (event.frames.empty()) {
    closed_ = closed_ || event.line == line_;
    return false;
  }
  if (!line_.empty() && event.line != line_) throw Failed{"it opened a second connection"};
  line_ = event.line;
  Message message;
  try {
    message = decode(event.frames);
  } catch (const PeerError& error) {
    throw Failed{std::string("it sent a message that cannot be read: ") + error.what()};
  }
  const bool greeting =
      std::holds_alternative<Hello>(message.body) || std::holds_alternative<CaseRequest>(message.body);
  if (greeting ? message.sequence != 1 && message.sequence != heard_ + 1 : message.sequence != heard_ + 1)
    throw Failed{fmt::format("{} has sequence {}, expected {}: messages count from 1 without gaps, heartbeats included",
                             describe(message), message.sequence, heard_ + 1)};
  heard_ = message.sequence;
  if (message.session != (welcomed_ ? session : ""))
    throw Failed{fmt::format("{} speaks for session '{}', expected '{}' as WELCOME said", describe(message),
                             message.session, welcomed_ ? session : "")};
  if (const auto* beat = std::get_if<Heartbeat>(&message.body)) {
    ++heartbeats_;
    interrupted_ = interrupted_ || beat->interrupted;
    return false;
  }
  if (std::holds_alternative<CaseRequest>(message.body)) {
    Message answer = message_of(CaseFile{scene_.text, scene_.overrides, scene_.digest(), scene_.general.dimension});
    send(std::move(answer));
    return false;
  }
  out = std::move(message);
  return true;
}

Message Examiner::next(const std::string& awaited) {
  const auto start = Clock::now();
  auto alive = start;
  std::optional<Message> message;
  while (Clock::now() - start < patience) {
    const int beats = heartbeats_;
    if (auto event = hub_->receive(Milliseconds(20)); event && note(std::move(*event), message)) {
      if (const auto* abort = std::get_if<Abort>(&message->body))
        throw Failed{fmt::format("it gave up instead of sending {}: {}", awaited, abort->reason)};
      return std::move(*message);
    }
    if (heartbeats_ > beats) alive = Clock::now();
    if (closed_) {
      const auto code = child_.wait(std::chrono::seconds(2));
      throw Failed{fmt::format("it closed the connection instead of sending {}{}", awaited,
                               code ? fmt::format(" (exit code {})", *code) : "")};
    }
    if (const auto code = child_.ended(); code && line_.empty())
      throw Failed{fmt::format("it ended with exit code {} before it said HELLO", *code)};
    if (welcomed_ && Clock::now() - alive > 10 * heartbeat + std::chrono::seconds(1))
      throw Failed{fmt::format("neither {} nor a heartbeat came for {:g} s; WELCOME asked for one every {:g} s",
                               awaited, std::chrono::duration<double>(Clock::now() - alive).count(),
                               std::chrono::duration<double>(heartbeat).count())};
    if (welcomed_ && Clock::now() - beat_ >= heartbeat) {
      beat_ = Clock::now();
      send(Heartbeat{"waiting", "", 0.0, false});
    }
  }
  throw Failed{fmt::format("{} did not come within {} s", awaited, patience.count())};
}

void Examiner::send(Message message) {
  message.major = major_;
  message.session = session;
  message.sender = "coupler";
  message.sequence = ++sent_;
  hub_->send(line_, encode(std::move(message)));
}

void Examiner::send(Body body) {
  Message message = message_of(std::move(body), step_);
  message.iteration = iteration_;
  message.time = time_;
  send(std::move(message));
}

const Hello& Examiner::hello() {
  const Message message = next("HELLO");
  const auto* hello = std::get_if<Hello>(&message.body);
  if (!hello) throw Failed{"expected HELLO first, got " + describe(message)};
  hello_ = *hello;
  if (message.major != protocol_major)
    throw Failed{fmt::format("expected protocol {}.x, got {}.{}", protocol_major, message.major, message.minor)};
  if (hello_.role != "fluid" && hello_.role != "solid")
    throw Failed{"its role is '" + hello_.role + "', expected fluid or solid"};
  if (hello_.contract.dimension != scene_.general.dimension)
    throw Failed{
        fmt::format("its dimension is {}, the case's is {}", hello_.contract.dimension, scene_.general.dimension)};
  if (hello_.contract.case_digest != scene_.digest())
    throw Failed{fmt::format("its case_digest is '{}', expected '{}', as CASE_FILE says", hello_.contract.case_digest,
                             scene_.digest())};
  for (const auto* specs : {&hello_.contract.gives, &hello_.contract.takes})
    for (const auto& spec : *specs)
      if (spec.name.empty() || spec.components < 1 || spec.unit.empty())
        throw Failed{"a field of HELLO lacks its name, unit or components: '" + spec.name + "'"};
  return hello_;
}

void Examiner::welcome() {
  send(Welcome{std::chrono::duration<double>(heartbeat).count(), 30.0});
  welcomed_ = true;
  beat_ = Clock::now();
}

void Examiner::take_publication(const std::string& after, double time) {
  Message message = next("a PUBLICATION after " + after);
  if (!std::holds_alternative<PublicationBody>(message.body))
    throw Failed{"expected a PUBLICATION after " + after + ", got " + describe(message)};
  if (after_restore_ && !message.points.sent)
    throw Failed{"the first PUBLICATION after a RESTORE or RESUME must bring its points"};
  after_restore_ = false;
  if (std::abs(message.time - time) > 1e-9 * std::max(std::abs(time), 1e-3 * scene_.general.end_time))
    throw Failed{fmt::format("its PUBLICATION after {} is of t = {} s, expected t = {} s", after, message.time, time)};
  try {
    state_ = admit(std::move(message), hello_.contract, state_.points);
  } catch (const PeerError& error) {
    throw Failed{error.what()};
  }
}

void Examiner::begin() {
  hello();
  welcome();
  take_publication("WELCOME", 0.0);
  Message message;
  message.body = Initialise{true, true};
  send_mapped(std::move(message), [](const Point3&) { return 1.0; });
  take_publication("INITIALISE", 0.0);
}

void Examiner::send_mapped(Message message, const Sight& sight) {
  const auto& points = *state_.points;
  const auto d = static_cast<std::size_t>(points.dimension);
  message.points = {points.dimension, points.revision, points.n_active, points.n_active, false};
  Array coverage{std::string(coverage_array), "1", 1, {}}, asymmetry{std::string(asymmetry_array), "1", 1, {}};
  std::vector<Point3> places;
  for (std::size_t i = 0; i < points.n_active; ++i) {
    const double* x = &points.position[i * d];
    places.emplace_back(x[0], x[1], d == 3 ? x[2] : 0.0);
    coverage.values.push_back(sight(places.back()));
    asymmetry.values.push_back(0.0);
  }
  std::vector<Array> fields;
  for (const auto& spec : hello_.contract.takes) {
    Array field{spec.name, spec.unit, spec.components, {}};
    for (std::size_t i = 0; i < places.size(); ++i)
      for (int c = 0; c < spec.components; ++c)
        field.values.push_back(coverage.values[i] > 0.0 ? still_value(scene_, spec.name, places[i]) : 0.0);
    fields.push_back(std::move(field));
  }
  message.arrays.push_back(std::move(coverage));
  message.arrays.push_back(std::move(asymmetry));
  for (auto& field : fields) message.arrays.push_back(std::move(field));
  send(std::move(message));
}

std::optional<Reject> Examiner::advance(double interval, const Sight& sight) {
  Message message;
  message.step = step_ + 1;
  message.iteration = iteration_;
  message.time = time_;
  message.interval = interval;
  message.body = Advance{false, false};
  const std::string name = fmt::format("ADVANCE step {} (attempt {}, {:g} s)", message.step, iteration_, interval);
  send_mapped(std::move(message), sight);
  Message answer = next("an answer to " + name);
  if (answer.step != step_ + 1 || answer.iteration != iteration_)
    throw Failed{fmt::format("its answer to {} carries step {} and attempt {}", name, answer.step, answer.iteration)};
  if (const auto* reject = std::get_if<Reject>(&answer.body)) {
    if (reject->code != RejectCode::step || !(reject->suggested_interval > 0.0))
      throw Failed{"a refused window needs the code REJECT_STEP and a positive suggested_interval"};
    return *reject;
  }
  if (!std::holds_alternative<PublicationBody>(answer.body))
    throw Failed{"expected PUBLICATION or REJECT after " + name + ", got " + describe(answer)};
  if (after_restore_ && !answer.points.sent)
    throw Failed{"the first PUBLICATION after a RESTORE must bring its points"};
  after_restore_ = false;
  const double end = time_ + interval;
  if (std::abs(answer.time - end) > 1e-9 * std::max(std::abs(end), 1e-3 * scene_.general.end_time))
    throw Failed{fmt::format("its PUBLICATION after {} is of t = {} s, expected t = {} s", name, answer.time, end)};
  before_ = state_;
  try {
    state_ = admit(std::move(answer), hello_.contract, state_.points);
  } catch (const PeerError& error) {
    throw Failed{error.what()};
  }
  time_ = end;
  ++step_;
  return std::nullopt;
}

double Examiner::allowed() const {
  const double own = scene_.coupling.interval.value_or(0.01 * scene_.general.end_time);
  return std::min(own, state_.proposed_interval);
}

void Examiner::window(const Sight& sight) {
  double interval = allowed();
  iteration_ = 0;
  for (int attempt = 0; attempt < 20; ++attempt) {
    const auto reject = advance(interval, sight);
    iteration_ = 0;
    if (!reject) return;
    send(Restore{reject->reason});
    after_restore_ = true;
    ++iteration_;
    interval = std::min(0.5 * interval, reject->suggested_interval);
  }
  throw Failed{fmt::format("it refused window {} twenty times, down to {:g} s", step_ + 1, interval)};
}

void Examiner::restore() {
  // Undoes the last window.
  const double start = before_.time;
  Message message = message_of(Restore{"the conformance suite tries it"}, step_);
  message.iteration = iteration_;
  message.time = start;
  send(std::move(message));
  --step_;
  ++iteration_;
  time_ = start;
  state_ = before_;
  after_restore_ = true;
}

void Examiner::checkpoint(const std::string& name, const std::vector<std::string>& keep) {
  send(CheckpointOrder{name, keep});
  const Message answer = next("CHECKPOINT_WRITTEN");
  const auto* written = std::get_if<CheckpointWritten>(&answer.body);
  if (!written || written->name != name)
    throw Failed{fmt::format("expected CHECKPOINT_WRITTEN of '{}', got {}{}", name, describe(answer),
                             written ? " of '" + written->name + "'" : "")};
}

void Examiner::resume(const std::string& name, const Examiner& before) {
  const auto& names = hello().checkpoints;
  if (std::find(names.begin(), names.end(), name) == names.end())
    throw Failed{fmt::format("started with --resume, its HELLO does not offer the checkpoint '{}'", name)};
  welcome();
  take_publication("WELCOME", 0.0);
  step_ = before.step_;
  time_ = before.time_;
  send(Resume{name});
  after_restore_ = true;
  take_publication("RESUME", time_);
}

void Examiner::kill() {
  child_.signal(SIGKILL);
  child_.wait(goodbye_within);
  hub_.reset();
}

int Examiner::idle(Milliseconds time) {
  const auto start = Clock::now();
  const int beats = heartbeats_;
  while (Clock::now() - start < time) {
    std::optional<Message> message;
    if (auto event = hub_->receive(Milliseconds(20)); event && note(std::move(*event), message))
      throw Failed{"it sent " + describe(*message) + " without being asked"};
    if (closed_) throw Failed{"it left while the coupler was silent but for its heartbeats"};
    if (Clock::now() - beat_ >= heartbeat) {
      beat_ = Clock::now();
      send(Heartbeat{"waiting", hello_.role == "fluid" ? "solid" : "fluid", 0.0, false});
    }
  }
  return heartbeats_ - beats;
}

void Examiner::interrupt() {
  child_.signal(SIGINT);
  const auto start = Clock::now();
  while (!interrupted_) {
    idle(Milliseconds(50));
    if (Clock::now() - start > std::chrono::seconds(5))
      throw Failed{"5 s after SIGINT no heartbeat says `interrupted`"};
  }
}

void Examiner::finish(const std::string& reason) {
  send(Finish{reason, true, true});
  const Message message = next("BYE");
  if (!std::holds_alternative<Bye>(message.body)) throw Failed{"expected BYE after FINISH, got " + describe(message)};
}

void Examiner::expect_exit(int code, const std::string& after) {
  // Until the solver ends, it may still send messages, such as its own ABORT.
  const auto deadline = Clock::now() + goodbye_within;
  while (hub_ && !child_.ended() && Clock::now() < deadline) hub_->receive(Milliseconds(20));
  const auto got = child_.wait(goodbye_within);
  if (!got) throw Failed{fmt::format("it still runs {} s after {}", goodbye_within.count(), after)};
  if (*got != code) throw Failed{fmt::format("after {} its exit code is {}, expected {}", after, *got, code)};
}

}  // namespace poretwin::peer
