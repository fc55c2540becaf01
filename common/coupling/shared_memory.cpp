#include "common/coupling/shared_memory.hpp"

#include "common/core/fault.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <new>
#include <random>
#include <string_view>

namespace poretwin::coupling {
namespace {

// A protobuf header begins with 0x08, so that these texts cannot be mistaken for a header.
constexpr std::string_view table_mark = "\xffPORETWIN table", offer_mark = "\xffPORETWIN offer",
                           accept_mark = "\xffPORETWIN accept", routing_mark = "\x01PORETWIN memory";
constexpr const char* file_name = "poretwin";
constexpr std::size_t largest_memory = std::size_t{4} << 30;  ///< largest memory for one message [bytes]

/// The first bytes of every block of shared memory.
struct Head {
  std::atomic<std::uint32_t> lent;  ///< 1 from the sender's first write to the receiver's last read
  std::uint64_t token;
};
static_assert(std::atomic<std::uint32_t>::is_always_lock_free);

/// Frames begin at multiples of a cache line, after the head.
constexpr std::size_t line_size = 64;
constexpr std::size_t aligned(std::size_t bytes) { return (bytes + line_size - 1) / line_size * line_size; }
static_assert(sizeof(Head) <= line_size);

struct Mapped {
  char* bytes = nullptr;
  std::size_t size = 0;

  Mapped(int descriptor, std::size_t length) : size(length) {
    void* where = fails(Fallible::map)
                      ? MAP_FAILED
                      : ::mmap(nullptr, length, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
    if (where != MAP_FAILED) bytes = static_cast<char*>(where);
  }
  Mapped(const Mapped&) = delete;
  Mapped& operator=(const Mapped&) = delete;
  ~Mapped() {
    if (bytes) ::munmap(bytes, size);
  }
  [[nodiscard]] Head& head() const { return *std::launder(reinterpret_cast<Head*>(bytes)); }
};

struct Descriptor {
  int value;
  explicit Descriptor(int descriptor) : value(descriptor) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (value >= 0) ::close(value);
  }
};

bool begins_with(const Frame& frame, std::string_view mark) {
  return frame.size >= mark.size() && std::memcmp(frame.data, mark.data(), mark.size()) == 0;
}

template <class T>
void append(std::string& bytes, const T& value) {
  static_assert(std::is_trivially_copyable_v<T>);
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

template <class T>
T value_at(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

constexpr std::size_t name_size = 16;

std::string text_of(std::string_view mark, const MemoryName& name) {
  std::string text(mark);
  append(text, name.process);
  append(text, name.descriptor);
  append(text, name.token);
  return text;
}

MemoryName name_at(const char* bytes) {
  return {value_at<std::int32_t>(bytes), value_at<std::int32_t>(bytes + 4), value_at<std::uint64_t>(bytes + 8)};
}

}  // namespace

struct LentMemory::Slot {
  Descriptor file;
  Mapped memory;
  MemoryName name;

  explicit Slot(std::size_t size) : file(make(size)), memory(file.value, size) {
    if (!memory.bytes) return;
    std::random_device source;
    name = {::getpid(), file.value, std::uint64_t{source()} << 32 | source()};
    new (memory.bytes) Head{0, name.token};
  }
  [[nodiscard]] bool free() const { return memory.head().lent.load(std::memory_order_acquire) == 0; }

 private:
  /// Makes memory that cannot be shrunk (sealed), so that a reader never finds it shorter than announced.
  static int make(std::size_t size) {
    const int file = ::memfd_create(file_name, MFD_CLOEXEC | MFD_ALLOW_SEALING);
    if (file >= 0 && (::ftruncate(file, static_cast<off_t>(size)) != 0 ||
                      ::fcntl(file, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW) != 0)) {
      ::close(file);
      return -1;
    }
    return file;
  }
};

std::shared_ptr<LentMemory::Slot> LentMemory::free_slot(std::size_t bytes) {
  auto found = std::find_if(slots_.begin(), slots_.end(), [](const auto& slot) { return slot->free(); });
  if (found != slots_.end() && (*found)->memory.size >= bytes) return *found;
  if (found == slots_.end() && slots_.size() == most_slots) return nullptr;
  auto slot = std::make_shared<Slot>(aligned(bytes + bytes / 4));
  if (!slot->memory.bytes) return nullptr;
  if (found == slots_.end())
    slots_.push_back(slot);
  else
    *found = slot;
  return slot;
}

std::optional<MemoryName> LentMemory::name() {
  const auto slot = free_slot(line_size);
  return slot ? std::optional(slot->name) : std::nullopt;
}

Frames LentMemory::lend(Frames frames) {
  std::size_t bytes = line_size;
  for (std::size_t k = 1; k < frames.size(); ++k) bytes += aligned(frames[k].size);
  if (bytes < worthwhile || bytes > largest_memory) return frames;
  const auto slot = free_slot(bytes);
  if (!slot) return frames;
  std::string table = text_of(table_mark, slot->name);
  slot->memory.head().lent.store(1, std::memory_order_relaxed);
  std::size_t at = line_size;
  for (std::size_t k = 1; k < frames.size(); ++k) {
    auto& frame = frames[k];
    append(table, std::uint64_t{frame.size});
    if (frame.size > 0) std::memcpy(slot->memory.bytes + at, frame.data, frame.size);
    at += aligned(frame.size);
    frame = {};
  }
  frames.insert(frames.begin(), Frame::of(std::move(table)));
  return frames;
}

struct BorrowedMemory::View {
  Mapped memory;
  View(int file, std::size_t size) : memory(file, size) {}
};

std::shared_ptr<BorrowedMemory::View> BorrowedMemory::view(const MemoryName& name) {
  if (const auto found = views_.find(name.token); found != views_.end()) return found->second;
  const std::string path = fmt::format("/proc/{}/fd/{}", name.process, name.descriptor);
  // Only files with this name are opened, since opening files of other kinds can have side effects.
  std::array<char, 64> target{};
  const auto length = ::readlink(path.c_str(), target.data(), target.size());
  const std::string expected = fmt::format("/memfd:{} (deleted)", file_name);
  if (length < 0 || std::string_view(target.data(), static_cast<std::size_t>(length)) != expected) return nullptr;
  const Descriptor file(::open(path.c_str(), O_RDWR | O_CLOEXEC));
  struct stat status {};
  if (file.value < 0 || ::fstat(file.value, &status) != 0 || status.st_size < static_cast<off_t>(line_size) ||
      static_cast<std::size_t>(status.st_size) > 2 * largest_memory)
    return nullptr;
  if (const int seals = ::fcntl(file.value, F_GET_SEALS); seals < 0 || (seals & F_SEAL_SHRINK) == 0) return nullptr;
  auto seen = std::make_shared<View>(file.value, static_cast<std::size_t>(status.st_size));
  if (!seen->memory.bytes || seen->memory.head().token != name.token) return nullptr;
  // The lender has dropped memory that it no longer needed, without saying which: all views are dropped.
  if (views_.size() >= 2 * LentMemory::most_slots) views_.clear();
  return views_[name.token] = std::move(seen);
}

bool BorrowedMemory::reaches(const MemoryName& name) { return view(name) != nullptr; }

Frames BorrowedMemory::borrow(Frames frames) {
  if (frames.size() < 2 || !sharing::is_table(frames)) return frames;
  const Frame table = frames.front();
  const std::size_t sizes = table_mark.size() + name_size, count = frames.size() - 2;
  if (table.size != sizes + count * sizeof(std::uint64_t)) return frames;
  const auto seen = view(name_at(table.data + table_mark.size()));
  if (!seen) return frames;
  const std::shared_ptr<const void> owner(
      nullptr, [seen](const void*) { seen->memory.head().lent.store(0, std::memory_order_release); });
  Frames out{frames[1]};
  std::size_t at = line_size;
  for (std::size_t k = 0; k < count; ++k) {
    const auto size = value_at<std::uint64_t>(table.data + sizes + k * sizeof(std::uint64_t));
    if (at > seen->memory.size || size > seen->memory.size - at) return frames;
    out.push_back({owner, seen->memory.bytes + at, size});
    at += aligned(size);
  }
  return out;
}

namespace sharing {

std::string routing_id(const std::optional<MemoryName>& name) { return name ? text_of(routing_mark, *name) : ""; }

std::optional<MemoryName> read_routing_id(const std::string& id) {
  if (id.size() != routing_mark.size() + name_size || !id.starts_with(routing_mark)) return std::nullopt;
  return name_at(id.data() + routing_mark.size());
}

Frames offer(const MemoryName& name) { return {Frame::of(text_of(offer_mark, name))}; }

std::optional<MemoryName> read_offer(const Frames& frames) {
  if (frames.size() != 1 || !begins_with(frames.front(), offer_mark) ||
      frames.front().size != offer_mark.size() + name_size)
    return std::nullopt;
  return name_at(frames.front().data + offer_mark.size());
}

bool is_table(const Frames& frames) { return !frames.empty() && begins_with(frames.front(), table_mark); }

Frames accept() { return {Frame::of(std::string(accept_mark))}; }

bool is_accept(const Frames& frames) {
  return frames.size() == 1 && frames.front().size == accept_mark.size() && begins_with(frames.front(), accept_mark);
}

}  // namespace sharing
}  // namespace poretwin::coupling
