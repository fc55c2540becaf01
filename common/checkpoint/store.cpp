#include "common/checkpoint/store.hpp"

#include "common/core/fault.hpp"
#include "common/core/hash.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <sstream>

namespace poretwin {
namespace fs = std::filesystem;
namespace {

constexpr std::string_view magic = "poretwin checkpoint 1\n", ending = ".state";

[[noreturn]] void fail(const fs::path& path, const std::string& what, int error) {
  throw FileError(fmt::format("{}: {}: {}", path.string(), what, std::strerror(error)));
}

class Descriptor {
 public:
  Descriptor(const fs::path& path, int flags)
      : value_(fails(Fallible::open) ? -1 : ::open(path.c_str(), flags | O_CLOEXEC, 0666)) {
    if (value_ < 0) fail(path, "cannot be opened", errno);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() { ::close(value_); }
  [[nodiscard]] int get() const { return value_; }

 private:
  int value_;
};

void write_durably(const fs::path& path, std::initializer_list<std::string_view> pieces) {
  const Descriptor file(path, O_WRONLY | O_CREAT | O_TRUNC);
  for (std::string_view rest : pieces)
    while (!rest.empty()) {
      const auto written = fails(Fallible::write) ? -1 : ::write(file.get(), rest.data(), rest.size());
      if (written < 0 && errno != EINTR) fail(path, "cannot be written", errno);
      if (written > 0) rest.remove_prefix(static_cast<std::size_t>(written));
    }
  if (::fsync(file.get()) != 0) fail(path, "cannot be written", errno);
}

std::string checksum_of(std::string_view head, std::string_view state) {
  return fmt::format("{:016x}", fnv1a(state, fnv1a(head)));
}

}  // namespace

void expect_same(const std::string& place, const RunIdentity& expected, const RunIdentity& found,
                 bool accept_changed_program) {
  for (const auto& [name, value] : expected) {
    const auto same = std::ranges::find(found, name, &RunIdentity::value_type::first);
    const std::string other = same == found.end() ? "nothing" : same->second;
    const bool program = name == program_entry;
    if (other == value || (program && accept_changed_program)) continue;
    throw CaseError(fmt::format(
        "{}: {}: expected that of the run to be resumed, {}, found {}; {}", place, name, other, value,
        program ? "resume with the program that wrote it, or go on with this one by --accept-changed-program (the "
                  "results are then of two programs)"
                : "resume with the same, or begin anew in another folder"));
  }
}

CheckpointStore::CheckpointStore(const fs::path& out, std::string process, RunIdentity identity, Say say,
                                 bool accept_changed_program)
    : folder_(out / "checkpoints"),
      process_(std::move(process)),
      identity_(std::move(identity)),
      say_(std::move(say)),
      accept_changed_program_(accept_changed_program) {}

fs::path CheckpointStore::file_of(const std::string& name) const {
  // Names come from other processes: none may lead to a file outside the folder.
  const auto plain = [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || c == '-'; };
  if (name.empty() || name.size() > 64 || !std::all_of(name.begin(), name.end(), plain))
    throw PeerError(fmt::format("checkpoint '{}': expected a name of at most 64 digits, small letters and hyphens",
                                name.substr(0, 64)));
  return folder_ / fmt::format("{}-{}{}", process_, name, ending);
}

std::vector<fs::path> CheckpointStore::files() const {
  std::vector<fs::path> found;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder_, none))
    if (entry.path().filename().string().starts_with(process_ + "-")) found.push_back(entry.path());
  return found;
}

CheckpointStore::Content CheckpointStore::content_of(const fs::path& file) const {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) fail(file, "cannot be opened", errno);
  std::stringstream all;
  all << stream.rdbuf();
  const std::string text = std::move(all).str();
  const std::size_t head = magic.size() + checksum_of({}, {}).size();
  if (!text.starts_with(magic) || text.size() < head)
    throw FileError(file.string() + ": is no checkpoint, or one that was cut off");
  std::string bytes = text.substr(head);
  if (checksum_of({}, bytes) != text.substr(magic.size(), head - magic.size()))
    throw FileError(file.string() + ": is damaged: its checksum differs");
  Content content;
  Archive archive(std::move(bytes));
  archive(content.checkpoint, content.identity, content.state);
  archive.expect_end();
  return content;
}

std::vector<Checkpoint> CheckpointStore::whole() const {
  std::vector<Checkpoint> found;
  for (const auto& file : files()) {
    if (file.extension() != ending) continue;
    try {
      const Content content = content_of(file);
      expect_same(file.string(), identity_, content.identity, accept_changed_program_);
      found.push_back(content.checkpoint);
    } catch (const FileError& error) {
      if (say_) say_(process_ + ": left out: " + error.what());
    }
  }
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.step > b.step; });
  return found;
}

void CheckpointStore::write(const Checkpoint& checkpoint, const Archive& state) const {
  std::error_code error;
  fs::create_directories(folder_, error);
  if (error) throw FileError(fmt::format("{}: the folder cannot be made: {}", folder_.string(), error.message()));
  // Writes the format that content_of() reads; the state itself is not copied.
  Checkpoint about = checkpoint;
  RunIdentity identity = identity_;
  std::uint64_t size = state.bytes().size();
  Archive head;
  head(about, identity, size);
  const auto target = file_of(checkpoint.name);
  auto fresh = target;
  fresh += ".part";
  try {
    write_durably(fresh, {magic, checksum_of(head.bytes(), state.bytes()), head.bytes(), state.bytes()});
  } catch (const FileError&) {
    fs::remove(fresh, error);
    throw;
  }
  fs::rename(fresh, target);
  // Makes the file's entry in the folder survive a loss of power, too.
  const Descriptor folder(folder_, O_RDONLY | O_DIRECTORY);
  if (::fsync(folder.get()) != 0) fail(folder_, "cannot be written", errno);
}

Archive CheckpointStore::read(const std::string& name) const {
  return Archive(std::move(content_of(file_of(name)).state));
}

void CheckpointStore::keep_only(const std::vector<std::string>& names) const {
  std::error_code ignored;
  for (const auto& file : files())
    if (std::none_of(names.begin(), names.end(), [&](const auto& name) { return file == file_of(name); }))
      fs::remove(file, ignored);
}

bool has_checkpoints(const fs::path& out, const std::string& process) {
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(out / "checkpoints", none)) {
    const auto name = entry.path().filename().string();
    if (name.starts_with(process + "-") && name.ends_with(ending)) return true;
  }
  return false;
}

}  // namespace poretwin
