// A small wrapper of HDF5: handles close themselves, errors become FileError with path and cause, and HDF5 prints no
// error stack on stderr. Only hdf5.cpp and undo_driver.cpp include the library's header.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace poretwin::hdf5 {

/// Element types on disk, little-endian.
enum class Type { float64, int64, uint8 };

/// A handle (hid_t) of any kind.
class Id {
 public:
  using Value = std::int64_t;
  using Close = int (*)(Value);
  Id() = default;
  Id(Value value, Close close) : value_(value), close_(close) {}
  Id(const Id&) = delete;
  Id& operator=(const Id&) = delete;
  Id(Id&& other) noexcept;
  Id& operator=(Id&& other) noexcept;
  ~Id() { reset(); }
  [[nodiscard]] Value get() const { return value_; }
  void reset() noexcept;

 private:
  Value value_ = -1;
  Close close_ = nullptr;
};

/// A chunked, compressed array that grows by rows. Its rank is 1 with `columns` = 0, otherwise 2.
class Dataset {
 public:
  Dataset() = default;
  void append(std::span<const double> values);
  void append(std::span<const std::int64_t> values);
  void append(std::span<const std::uint8_t> values);

 private:
  friend class File;
  void append_raw(const void* data, std::size_t count, Id::Value memory_type);
  Id id_;
  std::string what_;  ///< "file: data set", for messages
  std::size_t columns_ = 0, rows_ = 0;
};

class File {
 public:
  static File create(
      const std::filesystem::path& path);  ///< replaces an existing file; not locked, so that others may read it
  static File open_to_read(const std::filesystem::path& path);
  /// Calls roll_back() first.
  static File open_to_write(const std::filesystem::path& path);

  /// Creates a group and its parents.
  void group(const std::string& name);
  Dataset dataset(const std::string& name, Type type, std::size_t columns, std::size_t chunk_rows);
  /// An existing data set, cut off after `rows`. Throws FileError if the data set has fewer rows.
  Dataset cut_dataset(const std::string& name, std::size_t rows);
  void remove(const std::string& name);  ///< a group or data set

  /// Attributes of a group or data set.
  void attribute(const std::string& object, const std::string& name, const std::string& text);
  void attribute(const std::string& object, const std::string& name, std::span<const std::int64_t> values);
  void attribute(const std::string& object, const std::string& name,
                 std::int64_t value);  ///< scalar; may be overwritten
  /// A scalar data set: text of any length.
  void text(const std::string& name, const std::string& value);

  void flush();

  [[nodiscard]] bool has(const std::string& name) const;
  [[nodiscard]] std::vector<std::string> names(const std::string& group) const;
  [[nodiscard]] std::vector<std::size_t> shape(const std::string& dataset) const;
  [[nodiscard]] std::vector<double> read_numbers(const std::string& dataset) const;
  /// The rows [first, first + count) of a data set, row after row. Throws FileError if the data set has fewer rows.
  [[nodiscard]] std::vector<double> read_rows(const std::string& dataset, std::size_t first, std::size_t count) const;
  [[nodiscard]] std::vector<std::int64_t> read_integers(const std::string& dataset) const;
  [[nodiscard]] std::string read_text(const std::string& dataset) const;
  [[nodiscard]] std::string attribute_text(const std::string& object, const std::string& name) const;
  [[nodiscard]] std::vector<std::int64_t> attribute_integers(const std::string& object, const std::string& name) const;
  /// Whether the data set in the file contains 64-bit floats (otherwise integers).
  [[nodiscard]] bool is_float64(const std::string& dataset) const;

 private:
  enum class Mode { create, read, write };
  File(const std::filesystem::path& path, Mode mode);
  [[noreturn]] void fail(const std::string& action) const;
  [[nodiscard]] Id check(Id::Value value, Id::Close close, const std::string& action) const;
  void check(int status, const std::string& action) const;
  [[nodiscard]] Id cache_of_a_chunk(const std::string& action) const;
  std::string path_;
  Id id_;
};

}  // namespace poretwin::hdf5
