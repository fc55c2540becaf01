// Large frames between two processes of one machine: they lie in memory that both see, and only a table of their sizes
// goes through the socket, which would copy every byte into the kernel and out again. The memory is anonymous (memfd):
// it has no name that could stay behind, and ends with the processes. Messages are the same either way.
#pragma once

#include "common/coupling/message.hpp"

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace poretwin::coupling {

/// Where another process of the same user finds memory, and a token by which it knows that this is the right one: in
/// another container the same process number may belong to another process.
struct MemoryName {
  std::int32_t process = 0, descriptor = 0;
  std::uint64_t token = 0;
};

/// Memory that one end of a line lends to the other. For one thread.
class LentMemory {
 public:
  /// Messages that can be under way at once; further ones go through the socket.
  static constexpr std::size_t most_slots = 4;
  /// Messages with smaller frames are as fast through the socket [bytes].
  static constexpr std::size_t worthwhile = 32 << 10;

  /// The name of memory for a trial: who can reach it can reach the rest. None where the kernel gives no memory.
  [[nodiscard]] std::optional<MemoryName> name();
  /// [header][frame]* becomes [table][header][frame or empty]*, the frames' bytes in memory; a small message, and one
  /// for which no memory is free, stays as it is.
  Frames lend(Frames frames);

 private:
  struct Slot;
  std::shared_ptr<Slot> free_slot(std::size_t bytes);
  std::vector<std::shared_ptr<Slot>> slots_;
};

/// Another process's memory as it is read here. For one thread; the frames may go to others.
class BorrowedMemory {
 public:
  [[nodiscard]] bool reaches(const MemoryName& name);
  /// The message that was given to lend(): its frames lie in shared memory until their last owner releases them. A
  /// message without a table stays as it is, and so does one whose table is wrong: decode() then refuses it.
  Frames borrow(Frames frames);

 private:
  struct View;
  std::shared_ptr<View> view(const MemoryName& name);
  std::map<std::uint64_t, std::shared_ptr<View>> views_;  ///< by token
};

/// Messages by which the two ends agree before they lend; the user of a line never sees them. A DEALER names its memory
/// in its routing id; a ROUTER that can reach it names its own in an offer; a DEALER that can reach that accepts.
namespace sharing {

/// "" when there is no memory.
std::string routing_id(const std::optional<MemoryName>& name);
std::optional<MemoryName> read_routing_id(const std::string& id);
Frames offer(const MemoryName& name);
std::optional<MemoryName> read_offer(const Frames& frames);
/// A message whose bytes are in memory that could not be reached: left behind by borrow().
bool is_table(const Frames& frames);
Frames accept();
bool is_accept(const Frames& frames);

}  // namespace sharing
}  // namespace poretwin::coupling
