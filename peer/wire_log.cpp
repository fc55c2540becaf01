#include "peer/wire_log.hpp"

#include <array>
#include <bit>

namespace poretwin::peer {
namespace {

constexpr std::string_view first_line = "poretwin wire log 1\n";
static_assert(std::endian::native == std::endian::little, "the log's numbers are little-endian");

template <class T>
void put(std::ofstream& stream, T value) {
  std::array<char, sizeof(T)> bytes = std::bit_cast<std::array<char, sizeof(T)>>(value);
  stream.write(bytes.data(), bytes.size());
}

}  // namespace

WireLogWriter::WireLogWriter(const std::filesystem::path& path) : path_(path), stream_(path, std::ios::binary) {
  stream_ << first_line;
  if (!stream_.flush())
    throw FileError("cannot write " + path.string() + ": is there such a folder, and may you write in it?");
}

void WireLogWriter::write(Direction direction, const coupling::Frames& frames) {
  put(stream_, static_cast<char>(direction));
  put(stream_,
      static_cast<std::uint64_t>(
          std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now() - start_).count()));
  put(stream_, static_cast<std::uint32_t>(frames.size()));
  for (const auto& frame : frames) {
    put(stream_, static_cast<std::uint64_t>(frame.size));
    stream_.write(frame.data, static_cast<std::streamsize>(frame.size));
  }
  if (!stream_.flush()) throw FileError("cannot write " + path_.string() + ": is the disk full?");
}

WireLogReader::WireLogReader(const std::filesystem::path& path) : path_(path), stream_(path, std::ios::binary) {
  std::error_code error;
  left_ = std::filesystem::file_size(path, error);
  std::string line(first_line.size(), '\0');
  if (error || !stream_.read(line.data(), static_cast<std::streamsize>(line.size())) || line != first_line)
    throw FileError(path.string() + ": expected a wire log made by `poretwin peer record`, found " +
                    (error ? error.message() : "something else"));
  left_ -= first_line.size();
}

template <class T>
bool WireLogReader::read(T& value) {
  std::array<char, sizeof(T)> bytes{};
  if (left_ < bytes.size() || !stream_.read(bytes.data(), bytes.size())) return false;
  left_ -= bytes.size();
  value = std::bit_cast<T>(bytes);
  return true;
}

std::optional<WireLogReader::Record> WireLogReader::next() {
  Record record;
  char direction = 0;
  std::uint32_t count = 0;
  if (!read(direction) || !read(record.nanoseconds) || !read(count)) return std::nullopt;
  if (direction != '>' && direction != '<')
    throw FileError(path_.string() + ": damaged: a record begins with neither '>' nor '<'");
  record.direction = static_cast<Direction>(direction);
  for (std::uint32_t k = 0; k < count; ++k) {
    std::uint64_t size = 0;
    if (!read(size) || size > left_) return std::nullopt;
    std::string bytes(size, '\0');
    if (!stream_.read(bytes.data(), static_cast<std::streamsize>(size))) return std::nullopt;
    left_ -= size;
    record.frames.push_back(coupling::Frame::of(std::move(bytes)));
  }
  return record;
}

}  // namespace poretwin::peer
