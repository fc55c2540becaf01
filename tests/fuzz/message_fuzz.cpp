// Any bytes as a message give a PeerError, or a message that reads back unchanged from its frames; then any publication
// at the border; and any table of shared memory (docs/decisions/0008), of which no byte beyond its end may be read.
// Input: frames, each as two bytes of length (little-endian) followed by its bytes.
#include "common/core/error.hpp"
#include "common/coupling/border.hpp"
#include "common/coupling/shared_memory.hpp"

#include <cstdint>
#include <cstdlib>
#include <cstring>

namespace {

using namespace poretwin;
using namespace poretwin::coupling;

Frames frames_of(const std::uint8_t* data, std::size_t size) {
  Frames frames;
  while (size >= 2) {
    const std::size_t length = std::min<std::size_t>(data[0] | std::size_t{data[1]} << 8, size - 2);
    frames.push_back(Frame::of(std::string(reinterpret_cast<const char*>(data) + 2, length)));
    data += 2 + length;
    size -= 2 + length;
  }
  return frames;
}

bool same(const Frames& a, const Frames& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t k = 0; k < a.size(); ++k)
    if (a[k].size != b[k].size || (a[k].size > 0 && std::memcmp(a[k].data, b[k].data, a[k].size) != 0)) return false;
  return true;
}

/// A table that names existing memory, with sizes from the bytes of the first frame.
void borrow(const Frames& frames) {
  static LentMemory lent;
  static BorrowedMemory borrowed;
  static const std::string name = [] {
    std::vector<double> large(LentMemory::worthwhile / sizeof(double));
    const Frames honest = lent.lend({Frame::of(std::string()), Frame::of(std::move(large))});
    if (!sharing::is_table(honest)) std::abort();
    return std::string(honest.front().data, honest.front().size - sizeof(std::uint64_t));
  }();
  if (frames.empty()) return;
  Frames told{Frame::of(name + std::string(frames.front().data, frames.front().size))};
  told.insert(told.end(), frames.begin(), frames.end());
  unsigned sum = 0;
  for (const Frame& frame : borrowed.borrow(std::move(told)))
    for (std::size_t k = 0; k < frame.size; ++k) sum += static_cast<unsigned char>(frame.data[k]);
  [[maybe_unused]] static volatile unsigned looked_at = 0;
  looked_at = sum;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const Frames frames = frames_of(data, size);
  borrow(frames);
  try {
    const Message message = decode(frames);
    if (message.major != protocol_major) return 0;
    const Frames once = encode(message);
    if (!same(once, encode(decode(once)))) std::abort();
    static const Contract contract{2, "", standard_fields(Role::fluid, 2), {}};
    const Snapshot snapshot = admit(message, contract, nullptr);
    if (snapshot.points->n_active > snapshot.points->size()) std::abort();
  } catch (const PeerError&) {
    // refused with a reason
  }
  return 0;
}
