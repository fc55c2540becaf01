// The messages between a participant and the coupler as a file: all messages in both directions, byte for byte.
//
// The file begins with the line "poretwin wire log 1\n"; records follow. A record is one byte ('>' participant to
// coupler, '<' coupler to participant), the time since the file was begun [ns, u64], the number of frames [u32], and
// for each frame its length [u64] and its bytes. Numbers are little-endian. If the file was cut short, the incomplete
// record at its end is ignored.
#pragma once

#include "common/coupling/message.hpp"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <optional>

namespace poretwin::peer {

enum class Direction : char { to_coupler = '>', from_coupler = '<' };

class WireLogWriter {
 public:
  explicit WireLogWriter(const std::filesystem::path& path);
  void write(Direction direction, const coupling::Frames& frames);

 private:
  std::filesystem::path path_;
  std::ofstream stream_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

class WireLogReader {
 public:
  struct Record {
    Direction direction = Direction::to_coupler;
    std::uint64_t nanoseconds = 0;
    coupling::Frames frames;
  };
  /// Throws FileError where this is not a wire log.
  explicit WireLogReader(const std::filesystem::path& path);
  /// The next record; empty at the end of the file, also where it was cut short. Sizes are compared with the size of
  /// the file before memory is allocated.
  std::optional<Record> next();

 private:
  template <class T>
  bool read(T& value);
  std::filesystem::path path_;
  std::ifstream stream_;
  std::uint64_t left_ = 0;  ///< bytes not read yet
};

}  // namespace poretwin::peer
