// The messages of proto/poretwin.proto as plain structs, and their conversion to bytes. Other headers need not include
// protobuf.
#pragma once

#include "common/core/error.hpp"
#include "common/coupling/exchange.hpp"

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace poretwin::coupling {

inline constexpr std::uint32_t protocol_major = 1;
inline constexpr std::uint32_t protocol_minor = 3;

/// Reserved names of arrays.
inline constexpr std::string_view position_array = "@position";
inline constexpr std::string_view volume_array = "@volume";
inline constexpr std::string_view smoothing_length_array = "@smoothing_length";
inline constexpr std::string_view owner_array = "@owner";
inline constexpr std::string_view coverage_array = "@coverage";
inline constexpr std::string_view asymmetry_array = "@asymmetry";
inline constexpr std::string_view spread_array = "@spread";
/// Suffixes of a field's name for its values at the window's start, and for those after the last pass.
inline constexpr std::string_view start_suffix = "@start", found_suffix = "@found";

/// Bytes, and an owner that keeps them alive as long as they are read, for instance by a socket.
struct Frame {
  std::shared_ptr<const void> owner;
  const char* data = nullptr;
  std::size_t size = 0;  ///< bytes
  static Frame of(std::string bytes);
  static Frame of(std::vector<double> values);
};
/// [Header][raw frame]*
using Frames = std::vector<Frame>;

/// One named array of a message: n * components values. In a message made here the array has them in `values`. In a
/// decoded message it has them in `received`, from which take() copies them.
struct Array {
  std::string name;
  std::string unit;
  int components = 1;
  std::vector<double> values;
  Frame received = {};
  [[nodiscard]] std::size_t size() const { return values.empty() ? received.size / sizeof(double) : values.size(); }
  /// Moves the values out; may be called once. Values in memory that another process can write to are checked after
  /// they are copied here.
  std::vector<double> take();
};

struct PointsInfo {
  int dimension = 0;
  std::uint64_t revision = 0;
  std::uint64_t n = 0;
  std::uint64_t n_active = 0;
  bool sent = false;
};

struct CaseRequest {
  std::string role;
};
/// The case as the coupler has read it, for a participant that has no case file.
struct CaseFile {
  std::string text;                    ///< TOML
  std::vector<std::string> overrides;  ///< "section.key=value"
  std::string digest;                  ///< digest of the part of the case on which both sides agree
  int dimension = 0;
};
struct Hello {
  std::string role;
  Contract contract;
  std::string software;
  std::uint64_t process = 0;
  std::string host;
  bool keeps_checkpoints = false;
  std::vector<std::string> checkpoints = {};  ///< names of checkpoints from which the participant could resume
};
struct Welcome {
  double heartbeat_interval = 1.0;  ///< s
  double frozen_deadline = 30.0;    ///< s
};
enum class RejectCode { unknown = 0, protocol = 1, role = 2, dimension = 3, digest = 4, field = 5, step = 10 };
struct Reject {
  RejectCode code = RejectCode::unknown;
  std::string field, expected, got;
  double suggested_interval = 0.0;  ///< s
  std::string reason;
};
struct PublicationBody {
  double proposed_interval = no_limit;  ///< s
  std::string limited_by;
  double unsettled = 0.0;
};
struct Initialise {
  bool record_frame = false, record_gauges = false;
};
struct Advance {
  bool record_frame = false, record_gauges = false;
  unsigned pass = 0;
};
struct Restore {
  std::string reason;
};
struct Finish {
  std::string reason;
  bool record_frame = false, record_gauges = false;
};
struct CheckpointOrder {
  std::string name;
  std::vector<std::string> keep;
};
struct CheckpointWritten {
  std::string name;
};
struct Resume {
  std::string name;
};
struct Bye {
  std::string reason;
};
struct Abort {
  std::string culprit, reason;
  ExitCode code = ExitCode::failure;
};
struct Heartbeat {
  std::string doing, waiting_for;
  double since = 0.0;  ///< s
  bool interrupted = false;
};

using Body = std::variant<Hello, Welcome, Reject, PublicationBody, Initialise, Advance, Restore, Finish, Bye, Abort,
                          Heartbeat, CaseRequest, CaseFile, CheckpointOrder, CheckpointWritten, Resume>;

struct Message {
  std::uint32_t major = protocol_major, minor = protocol_minor;
  std::string session, sender;
  std::uint64_t sequence = 0;
  std::uint64_t step = 0;
  std::uint32_t iteration = 0;
  double time = 0.0;      ///< s
  double interval = 0.0;  ///< s
  PointsInfo points;
  std::vector<Array> arrays;
  Body body = Heartbeat{};
};

/// A message without arrays.
Message message_of(Body body, std::uint64_t step = 0);

/// "ADVANCE", ...: the message's name for logs and errors.
std::string_view name_of(const Body& body);
/// "ADVANCE step 7 (t = 0.3 s)".
std::string describe(const Message& message);

/// Converts a message to frames. Arrays are moved into their frames, not copied.
Frames encode(Message message);
/// Converts frames to a message. Throws PeerError with the fault: no header; wrong kind, number or size of frames;
/// wrong element type. For another protocol_major only the header is read (the caller refuses the peer by `major`).
Message decode(const Frames& frames);

}  // namespace poretwin::coupling
