// Shared memory for large frames between two processes of one machine. Only a table of the frames' sizes passes through
// the socket, which would copy every byte into the kernel and out again. The memory is anonymous (memfd): it has no
// name that could remain, and ends with the processes. The messages are the same with and without shared memory.
#pragma once

#include "common/coupling/message.hpp"

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace poretwin::coupling {

/// The place where another process of the same user finds the memory, and a token by which it recognises the memory: in
/// another container the same process number may belong to another process.
struct MemoryName {
  std::int32_t process = 0, descriptor = 0;
  std::uint64_t token = 0;
};

/// Memory that one end of a line lends to the other end. Only one thread may use it.
class LentMemory {
 public:
  /// Number of messages that can be in the memory at the same time. Further messages pass through the socket.
  static constexpr std::size_t most_slots = 4;
  /// Messages with fewer bytes than this are as fast through the socket.
  static constexpr std::size_t worthwhile = 32 << 10;

  /// The name of a block of memory, for a test: a process that can access this block can access the others. Empty if
  /// the kernel gives no memory.
  [[nodiscard]] std::optional<MemoryName> name();
  /// Converts [header][frame]* to [table][header][frame or empty]*, with the bytes of the frames in shared memory. A
  /// small message, or a message for which no memory is free, is returned unchanged.
  Frames lend(Frames frames);

 private:
  struct Slot;
  std::shared_ptr<Slot> free_slot(std::size_t bytes);
  std::vector<std::shared_ptr<Slot>> slots_;
};

/// Access to memory that another process lends. Only one thread may use it; the frames may be passed to other threads.
class BorrowedMemory {
 public:
  /// Whether the named memory can be accessed.
  [[nodiscard]] bool reaches(const MemoryName& name);
  /// The message that was passed to lend(). Its frames are in shared memory until their last owner releases them.
  /// Messages without a table or with a wrong table are returned unchanged; decode() refuses the latter.
  Frames borrow(Frames frames);

 private:
  struct View;
  std::shared_ptr<View> view(const MemoryName& name);
  std::map<std::uint64_t, std::shared_ptr<View>> views_;  ///< by token
};

/// Messages by which both ends agree to share memory. Users of a line never see them. A DEALER names its memory in its
/// routing id. A ROUTER that can access it offers its own memory. A DEALER that can access that memory accepts.
namespace sharing {

/// The routing id; empty if there is no memory.
std::string routing_id(const std::optional<MemoryName>& name);
std::optional<MemoryName> read_routing_id(const std::string& id);
Frames offer(const MemoryName& name);
std::optional<MemoryName> read_offer(const Frames& frames);
/// Whether the memory of this message could not be accessed, so that borrow() returned the message unchanged.
bool is_table(const Frames& frames);
Frames accept();
bool is_accept(const Frames& frames);

}  // namespace sharing
}  // namespace poretwin::coupling
