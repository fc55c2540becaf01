// Any bytes as a message: either a PeerError or a message whose wire form reads back the same; then any publication at
// the border. Input: frames, each as two bytes of length (little-endian) and its bytes.
#include "common/core/error.hpp"
#include "common/coupling/border.hpp"

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

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const Message message = decode(frames_of(data, size));
    if (message.major != protocol_major) return 0;
    const Frames once = encode(message);
    if (!same(once, encode(decode(once)))) std::abort();
    static const Contract contract{2, "", standard_fields(Role::fluid, 2), {}};
    const Snapshot snapshot = admit(message, contract, nullptr);
    if (snapshot.points->n_active > snapshot.points->size()) std::abort();
  } catch (const PeerError&) {
    // refused with its reason
  }
  return 0;
}
