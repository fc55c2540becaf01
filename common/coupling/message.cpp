#include "common/coupling/message.hpp"

#include "common/core/fault.hpp"

#include <fmt/format.h>

#include <bit>
#include <cstdint>
#include <cstring>
#include <new>

#include <google/protobuf/stubs/logging.h>

#include "poretwin.pb.h"

namespace poretwin::coupling {

static_assert(std::endian::native == std::endian::little,
              "raw frames are little-endian; a big-endian host must swap here");

Frame Frame::of(std::string bytes) {
  auto kept = std::make_shared<const std::string>(std::move(bytes));
  return {kept, kept->data(), kept->size()};
}

Frame Frame::of(std::vector<double> values) {
  auto kept = std::make_shared<const std::vector<double>>(std::move(values));
  // The language allows reading the bytes of any object as char.
  return {kept, reinterpret_cast<const char*>(kept->data()), kept->size() * sizeof(double)};
}

namespace {

template <class... F>
struct Overloaded : F... {
  using F::operator()...;
};
template <class... F>
Overloaded(F...) -> Overloaded<F...>;

wire::MappingKind to_wire(Mapping mapping) {
  switch (mapping) {
    case Mapping::consistent:
      return wire::CONSISTENT;
    case Mapping::nearest:
      return wire::NEAREST;
    case Mapping::conservative:
      break;
  }
  return wire::CONSERVATIVE;
}
Mapping from_wire(wire::MappingKind kind) {
  return kind == wire::CONSERVATIVE ? Mapping::conservative
         : kind == wire::NEAREST    ? Mapping::nearest
                                    : Mapping::consistent;
}

void write(wire::FieldSpec& out, const FieldSpec& spec) {
  out.set_name(spec.name);
  out.set_unit(spec.unit);
  out.set_components(static_cast<std::uint32_t>(spec.components));
  out.set_mapping(to_wire(spec.mapping));
  out.set_mask(spec.mask);
  out.set_in_time(spec.in_time);
  out.set_found(spec.found);
}

FieldSpec read(const wire::FieldSpec& in) {
  return {in.name(),    in.unit(), static_cast<int>(in.components()), from_wire(in.mapping()), in.mask(),
          in.in_time(), in.found()};
}

void write_body(wire::Header& header, const Body& body) {
  std::visit(Overloaded{
                 [&](const Hello& b) {
                   auto& out = *header.mutable_hello();
                   out.set_role(b.role);
                   out.set_dimension(static_cast<std::uint32_t>(b.contract.dimension));
                   out.set_case_digest(b.contract.case_digest);
                   for (const auto& spec : b.contract.gives) write(*out.add_gives(), spec);
                   for (const auto& spec : b.contract.takes) write(*out.add_takes(), spec);
                   out.set_software(b.software);
                   out.set_process(b.process);
                   out.set_host(b.host);
                   out.set_case_part(b.contract.case_part);
                   out.set_keeps_checkpoints(b.keeps_checkpoints);
                   for (const auto& name : b.checkpoints) out.add_checkpoints(name);
                 },
                 [&](const Welcome& b) {
                   header.mutable_welcome()->set_heartbeat_interval(b.heartbeat_interval);
                   header.mutable_welcome()->set_frozen_deadline(b.frozen_deadline);
                 },
                 [&](const Reject& b) {
                   auto& out = *header.mutable_reject();
                   out.set_code(static_cast<wire::RejectCode>(b.code));
                   out.set_field(b.field);
                   out.set_expected(b.expected);
                   out.set_got(b.got);
                   out.set_suggested_interval(b.suggested_interval);
                   out.set_reason(b.reason);
                 },
                 [&](const PublicationBody& b) {
                   header.mutable_publication()->set_proposed_interval(b.proposed_interval);
                   header.mutable_publication()->set_limited_by(b.limited_by);
                   header.mutable_publication()->set_unsettled(b.unsettled);
                 },
                 [&](const Initialise& b) {
                   header.mutable_initialise()->set_record_frame(b.record_frame);
                   header.mutable_initialise()->set_record_gauges(b.record_gauges);
                 },
                 [&](const Advance& b) {
                   header.mutable_advance()->set_record_frame(b.record_frame);
                   header.mutable_advance()->set_record_gauges(b.record_gauges);
                   header.mutable_advance()->set_pass(b.pass);
                 },
                 [&](const Restore& b) { header.mutable_restore()->set_reason(b.reason); },
                 [&](const Finish& b) {
                   header.mutable_finish()->set_reason(b.reason);
                   header.mutable_finish()->set_record_frame(b.record_frame);
                   header.mutable_finish()->set_record_gauges(b.record_gauges);
                 },
                 [&](const Bye& b) { header.mutable_bye()->set_reason(b.reason); },
                 [&](const Abort& b) {
                   header.mutable_abort()->set_culprit(b.culprit);
                   header.mutable_abort()->set_reason(b.reason);
                   header.mutable_abort()->set_exit_code(static_cast<int>(b.code));
                 },
                 [&](const Heartbeat& b) {
                   auto& out = *header.mutable_heartbeat();
                   out.set_doing(b.doing);
                   out.set_waiting_for(b.waiting_for);
                   out.set_since(b.since);
                   out.set_interrupted(b.interrupted);
                 },
                 [&](const CaseRequest& b) { header.mutable_case_request()->set_role(b.role); },
                 [&](const CaseFile& b) {
                   auto& out = *header.mutable_case_file();
                   out.set_text(b.text);
                   for (const auto& assignment : b.overrides) out.add_overrides(assignment);
                   out.set_digest(b.digest);
                   out.set_dimension(static_cast<std::uint32_t>(b.dimension));
                 },
                 [&](const CheckpointOrder& b) {
                   header.mutable_checkpoint()->set_name(b.name);
                   for (const auto& name : b.keep) header.mutable_checkpoint()->add_keep(name);
                 },
                 [&](const CheckpointWritten& b) { header.mutable_checkpoint_written()->set_name(b.name); },
                 [&](const Resume& b) { header.mutable_resume()->set_name(b.name); },
             },
             body);
}

Hello read_hello(const wire::Hello& in) {
  Hello hello;
  hello.role = in.role();
  hello.contract.dimension = static_cast<int>(in.dimension());
  hello.contract.case_digest = in.case_digest();
  for (const auto& spec : in.gives()) hello.contract.gives.push_back(read(spec));
  for (const auto& spec : in.takes()) hello.contract.takes.push_back(read(spec));
  hello.software = in.software();
  hello.process = in.process();
  hello.host = in.host();
  hello.contract.case_part = in.case_part();
  hello.keeps_checkpoints = in.keeps_checkpoints();
  hello.checkpoints = {in.checkpoints().begin(), in.checkpoints().end()};
  return hello;
}

ExitCode exit_code_of(int code) {
  switch (code) {
    case 0:
    case 2:
    case 3:
    case 4:
    case 5:
    case 6:
    case 130:
      return static_cast<ExitCode>(code);
    default:
      return ExitCode::failure;
  }
}

Body read_body(const wire::Header& header) {
  using Case = wire::Header::BodyCase;
  switch (header.body_case()) {
    case Case::kHello:
      return read_hello(header.hello());
    case Case::kWelcome:
      return Welcome{header.welcome().heartbeat_interval(), header.welcome().frozen_deadline()};
    case Case::kReject: {
      const auto& in = header.reject();
      return Reject{static_cast<RejectCode>(in.code()),
                    in.field(),
                    in.expected(),
                    in.got(),
                    in.suggested_interval(),
                    in.reason()};
    }
    case Case::kPublication:
      return PublicationBody{header.publication().proposed_interval(), header.publication().limited_by(),
                             header.publication().unsettled()};
    case Case::kInitialise:
      return Initialise{header.initialise().record_frame(), header.initialise().record_gauges()};
    case Case::kAdvance:
      return Advance{header.advance().record_frame(), header.advance().record_gauges(), header.advance().pass()};
    case Case::kRestore:
      return Restore{header.restore().reason()};
    case Case::kFinish:
      return Finish{header.finish().reason(), header.finish().record_frame(), header.finish().record_gauges()};
    case Case::kBye:
      return Bye{header.bye().reason()};
    case Case::kAbort:
      return Abort{header.abort().culprit(), header.abort().reason(), exit_code_of(header.abort().exit_code())};
    case Case::kHeartbeat: {
      const auto& in = header.heartbeat();
      return Heartbeat{in.doing(), in.waiting_for(), in.since(), in.interrupted()};
    }
    case Case::kCaseRequest:
      return CaseRequest{header.case_request().role()};
    case Case::kCaseFile: {
      const auto& in = header.case_file();
      return CaseFile{
          in.text(), {in.overrides().begin(), in.overrides().end()}, in.digest(), static_cast<int>(in.dimension())};
    }
    case Case::kCheckpoint: {
      const auto& in = header.checkpoint();
      return CheckpointOrder{in.name(), {in.keep().begin(), in.keep().end()}};
    }
    case Case::kCheckpointWritten:
      return CheckpointWritten{header.checkpoint_written().name()};
    case Case::kResume:
      return Resume{header.resume().name()};
    case Case::BODY_NOT_SET:
      break;
  }
  throw PeerError(fmt::format("message of '{}' (sequence {}) is of a kind this protocol {}.{} does not know",
                              header.sender(), header.sequence(), protocol_major, protocol_minor));
}

/// Returns the frame after checking that its size is the announced one.
const Frame& checked(const wire::Array& in, const Frame& frame, const wire::Header& header) {
  auto refuse = [&](const std::string& what) {
    throw PeerError(fmt::format("array '{}' of '{}' (step {}, sequence {}): {}", in.name(), header.sender(),
                                header.step(), header.sequence(), what));
  };
  if (in.element() != wire::FLOAT64_LE)
    refuse(fmt::format("expected element type FLOAT64_LE, got {}", static_cast<int>(in.element())));
  if (in.components() < 1 || in.components() > 9)
    refuse(fmt::format("expected 1 to 9 components, got {}", in.components()));
  // The frame is in memory, so that its size limits n before a multiplication can overflow.
  const std::uint64_t points = frame.size / (sizeof(double) * in.components());
  if (in.n() != points || frame.size != points * sizeof(double) * in.components())
    refuse(fmt::format("expected {} points x {} components x 8 bytes, got a frame of {} bytes", in.n(), in.components(),
                       frame.size));
  return frame;
}

}  // namespace

std::vector<double> Array::take() {
  if (fails(Fallible::allocate)) throw std::bad_alloc();
  if (received.size == 0) return std::move(values);
  const std::size_t n = received.size / sizeof(double);
  std::vector<double> copy;
  if (reinterpret_cast<std::uintptr_t>(received.data) % alignof(double) == 0) {
    const auto* const first = reinterpret_cast<const double*>(received.data);
    copy.assign(first, first + n);  // resize() would first clear the memory, which is one more pass over it
  } else {
    copy.resize(n);
    std::memcpy(copy.data(), received.data, n * sizeof(double));
  }
  received = {};
  return copy;
}

Message message_of(Body body, std::uint64_t step) {
  Message message;
  message.step = step;
  message.body = std::move(body);
  return message;
}

std::string_view name_of(const Body& body) {
  static constexpr std::string_view names[] = {
      "HELLO",     "WELCOME",      "REJECT",    "PUBLICATION", "INITIALISE",
      "ADVANCE",   "RESTORE",      "FINISH",    "BYE",         "ABORT",
      "HEARTBEAT", "CASE_REQUEST", "CASE_FILE", "CHECKPOINT",  "CHECKPOINT_WRITTEN",
      "RESUME"};
  return names[body.index()];
}

std::string describe(const Message& message) {
  return fmt::format("{} step {} (t = {:g} s)", name_of(message.body), message.step, message.time);
}

Frames encode(Message message) {
  wire::Header header;
  header.set_protocol_major(message.major);
  header.set_protocol_minor(message.minor);
  header.set_session(message.session);
  header.set_sender(message.sender);
  header.set_sequence(message.sequence);
  header.set_step(message.step);
  header.set_iteration(message.iteration);
  header.set_time(message.time);
  header.set_interval(message.interval);
  if (message.points.dimension > 0) {
    auto& points = *header.mutable_points();
    points.set_dimension(static_cast<std::uint32_t>(message.points.dimension));
    points.set_revision(message.points.revision);
    points.set_n(message.points.n);
    points.set_n_active(message.points.n_active);
    points.set_sent(message.points.sent);
  }
  write_body(header, message.body);
  Frames frames(1);
  for (auto& array : message.arrays) {
    auto& out = *header.add_arrays();
    out.set_name(array.name);
    out.set_unit(array.unit);
    out.set_components(static_cast<std::uint32_t>(array.components));
    out.set_element(wire::FLOAT64_LE);
    out.set_n(array.size() / static_cast<std::size_t>(array.components));
    frames.push_back(array.values.empty() ? std::move(array.received) : Frame::of(std::move(array.values)));
  }
  frames.front() = Frame::of(header.SerializeAsString());
  return frames;
}

Message decode(const Frames& frames) {
  // Errors in a message are reported by exceptions only, so that foreign messages cannot fill the log.
  [[maybe_unused]] static const auto loud = google::protobuf::SetLogHandler(nullptr);
  wire::Header header;
  if (frames.empty() || frames.front().size > 16u * 1024u * 1024u ||
      !header.ParseFromArray(frames.front().data, static_cast<int>(frames.front().size)))
    throw PeerError("a message came in whose first frame is not a poretwin header: does a poretwin peer speak there?");
  Message message;
  message.major = header.protocol_major();
  message.minor = header.protocol_minor();
  message.session = header.session();
  message.sender = header.sender();
  message.sequence = header.sequence();
  message.step = header.step();
  message.iteration = header.iteration();
  message.time = header.time();
  message.interval = header.interval();
  if (message.major != protocol_major) return message;
  if (header.has_points()) {
    const auto& in = header.points();
    message.points = {static_cast<int>(in.dimension()), in.revision(), in.n(), in.n_active(), in.sent()};
  }
  message.body = read_body(header);
  if (frames.size() != static_cast<std::size_t>(header.arrays_size()) + 1)
    throw PeerError(fmt::format("{} of '{}' announces {} arrays, {} frames came", name_of(message.body), message.sender,
                                header.arrays_size(), frames.size() - 1));
  for (int k = 0; k < header.arrays_size(); ++k) {
    const auto& in = header.arrays(k);
    message.arrays.push_back({in.name(),
                              in.unit(),
                              static_cast<int>(in.components()),
                              {},
                              checked(in, frames[static_cast<std::size_t>(k) + 1], header)});
  }
  return message;
}

}  // namespace poretwin::coupling
