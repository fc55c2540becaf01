#include "common/output/undo_driver.hpp"

#include "common/core/error.hpp"
#include "common/core/fault.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <hdf5.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <memory>
#include <string>
#include <vector>

namespace poretwin::hdf5 {
namespace {

// FILE.undo contains the length of FILE at the last flush, then pieces (position, length, the bytes that were there) in
// the order of writing. The bytes of an incomplete piece have not been overwritten yet. The first piece has no bytes:
// its position is the stamp (time) of that flush. Before the first write after a flush, FILE.undo is empty and its
// modification time is the stamp. A reader that finds the same stamp before and after it reads both files has the state
// of that flush, even while FILE is being written (docs/view.md).

std::string undo_of(const std::string& path) { return path + ".undo"; }

bool write_all(int descriptor, const void* data, std::size_t size, off_t at) {
  const auto* bytes = static_cast<const char*>(data);
  if (fails(Fallible::write)) return false;
  while (size > 0) {
    const auto count = ::pwrite(descriptor, bytes, size, at);
    if (count < 0 && errno != EINTR) return false;
    if (count <= 0) continue;
    bytes += count;
    at += count;
    size -= static_cast<std::size_t>(count);
  }
  return true;
}

/// Reads `size` bytes; beyond the end of the file they are zero.
bool read_all(int descriptor, void* data, std::size_t size, off_t at) {
  auto* bytes = static_cast<char*>(data);
  while (size > 0) {
    const auto count = ::pread(descriptor, bytes, size, at);
    if (count < 0 && errno != EINTR) return false;
    if (count == 0) {
      std::memset(bytes, 0, size);
      return true;
    }
    if (count < 0) continue;
    bytes += count;
    at += count;
    size -= static_cast<std::size_t>(count);
  }
  return true;
}

std::uint64_t length_of(int descriptor) {
  struct stat status {};
  return ::fstat(descriptor, &status) == 0 ? static_cast<std::uint64_t>(status.st_size) : 0;
}

off_t offset(std::uint64_t x) { return static_cast<off_t>(x); }

struct Piece {
  std::uint64_t where = 0, size = 0;
};

bool undo_all(int file, int undo) {
  const std::uint64_t end = length_of(undo);
  std::uint64_t length = 0, at = sizeof length;
  if (end < at) return true;
  std::vector<std::uint64_t> pieces;
  for (Piece piece; at + sizeof piece <= end; at += sizeof piece + piece.size) {
    if (!read_all(undo, &piece, sizeof piece, offset(at))) return false;
    if (piece.size > end - at - sizeof piece) break;
    pieces.push_back(at);
  }
  std::vector<char> bytes;
  for (auto start = pieces.rbegin(); start != pieces.rend(); ++start) {
    Piece piece;
    if (!read_all(undo, &piece, sizeof piece, offset(*start))) return false;
    bytes.resize(piece.size);
    if (!read_all(undo, bytes.data(), bytes.size(), offset(*start + sizeof piece)) ||
        !write_all(file, bytes.data(), bytes.size(), offset(piece.where)))
      return false;
  }
  return read_all(undo, &length, sizeof length, 0) && ::ftruncate(file, offset(length)) == 0;
}

struct UndoFile {
  H5FD_t general{};  // must be the first member: the library knows only this part of the struct
  std::string path;
  int file = -1, undo = -1;
  std::uint64_t address_end = 0, end = 0;  ///< end of the allocated addresses; end of the file
  std::uint64_t flushed = 0;               ///< length of the file at the last flush
  std::uint64_t stamp = 0;                 ///< time of the last flush, ns since 1970
  std::uint64_t undo_end = 0;              ///< 0: nothing to undo
  bool writable = false;
  std::string failure;  ///< message of the first failed write; empty: none
  // The driver hides a failed write from the library. Otherwise the library could not close the file or data set, and
  // would retry at the process's end and crash. Data written after the failure are kept here for it to read.
  std::vector<std::pair<std::uint64_t, std::vector<char>>> unwritten;

  /// Saves the bytes in [where, where + size), which a write is about to replace.
  bool keep(std::uint64_t where, std::uint64_t size) {
    if (where >= flushed) size = 0;
    size = std::min(size, flushed - std::min(where, flushed));
    if (undo_end == 0) {
      const std::array<std::uint64_t, 3> header{flushed, stamp, 0};
      if (!write_all(undo, header.data(), sizeof header, 0)) return false;
      undo_end = sizeof header;
    }
    if (size == 0) return true;
    std::vector<char> bytes(sizeof(Piece) + size);
    const Piece piece{where, size};
    std::memcpy(bytes.data(), &piece, sizeof piece);
    if (!read_all(file, bytes.data() + sizeof piece, size, offset(where)) ||
        !write_all(undo, bytes.data(), bytes.size(), offset(undo_end)))
      return false;
    undo_end += bytes.size();
    return true;
  }

  bool commit() {
    if (undo_end > 0 && ::ftruncate(undo, 0) != 0) return false;
    undo_end = 0;
    flushed = end;
    renew_stamp();
    return true;
  }

  /// The clock of file systems advances every few milliseconds; two flushes within one tick must have different stamps.
  void renew_stamp() {
    timespec now{};
    ::clock_gettime(CLOCK_REALTIME, &now);
    stamp = std::max(stamp + 1, std::uint64_t{1000000000} * static_cast<std::uint64_t>(now.tv_sec) +
                                    static_cast<std::uint64_t>(now.tv_nsec));
    const timespec time{static_cast<time_t>(stamp / 1000000000), static_cast<long>(stamp % 1000000000)};
    const std::array<timespec, 2> times{time, time};
    ::futimens(undo, times.data());
  }
};

// The library passes pointers to its own struct, which is the beginning of UndoFile.
UndoFile& own(H5FD_t* file) { return *reinterpret_cast<UndoFile*>(file); }
const UndoFile& own(const H5FD_t* file) { return *reinterpret_cast<const UndoFile*>(file); }

void note_failure(UndoFile& file) { file.failure = fmt::format("cannot be written: {}", std::strerror(errno)); }

herr_t fail(const char* action) {
  const int error = errno;
  H5Epush2(H5E_DEFAULT, "undo_driver.cpp", "undo_driver", 0, H5E_ERR_CLS, H5E_IO, H5E_WRITEERROR, "%s: %s", action,
           std::strerror(error));
  return -1;
}

H5FD_t* open_file(const char* name, unsigned flags, hid_t, haddr_t) {
  auto made = std::make_unique<UndoFile>();
  made->path = name;
  made->writable = (flags & H5F_ACC_RDWR) != 0;
  int how = made->writable ? O_RDWR : O_RDONLY;
  if ((flags & H5F_ACC_TRUNC) != 0) how |= O_TRUNC;
  if ((flags & H5F_ACC_CREAT) != 0) how |= O_CREAT;
  if ((flags & H5F_ACC_EXCL) != 0) how |= O_EXCL;
  made->file = fails(Fallible::open) ? -1 : ::open(name, how | O_CLOEXEC, 0666);
  if (made->file >= 0 && made->writable) {
    if (!fails(Fallible::open))
      made->undo = ::open(undo_of(name).c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (made->undo < 0) {
      const int error = errno;
      ::close(made->file);
      made->file = -1;
      errno = error;
    }
  }
  if (made->file < 0) {
    fail("cannot be opened");
    return nullptr;
  }
  made->end = made->flushed = length_of(made->file);
  if (made->writable) made->renew_stamp();
  return &made.release()->general;
}

herr_t close_file(H5FD_t* general) {
  const std::unique_ptr<UndoFile> file(&own(general));
  // Undoes what the library could not complete. After a process has died, roll_back() does the same.
  const bool good = file->failure.empty() || undo_all(file->file, file->undo);
  if (file->undo >= 0) {
    ::close(file->undo);
    if (good) ::unlink(undo_of(file->path).c_str());
  }
  ::close(file->file);
  return 0;
}

int compare(const H5FD_t* a, const H5FD_t* b) {
  struct stat one {
  }, other{};
  ::fstat(own(a).file, &one);
  ::fstat(own(b).file, &other);
  if (one.st_dev != other.st_dev) return one.st_dev < other.st_dev ? -1 : 1;
  return one.st_ino < other.st_ino ? -1 : one.st_ino > other.st_ino ? 1 : 0;
}

herr_t query(const H5FD_t*, unsigned long* flags) {
  *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
           H5FD_FEAT_AGGREGATE_SMALLDATA | H5FD_FEAT_DEFAULT_VFD_COMPATIBLE;
  return 0;
}

haddr_t address_end(const H5FD_t* file, H5FD_mem_t) { return own(file).address_end; }
haddr_t file_end(const H5FD_t* file, H5FD_mem_t) { return own(file).end; }
herr_t set_address_end(H5FD_t* file, H5FD_mem_t, haddr_t address) {
  own(file).address_end = address;
  return 0;
}

herr_t read(H5FD_t* general, H5FD_mem_t, hid_t, haddr_t at, size_t size, void* data) {
  auto& file = own(general);
  if (!read_all(file.file, data, size, offset(at))) return fail("cannot be read");
  for (const auto& [where, bytes] : file.unwritten) {
    const std::uint64_t first = std::max<std::uint64_t>(at, where), last = std::min(at + size, where + bytes.size());
    if (first < last)
      std::memcpy(static_cast<char*>(data) + (first - at), bytes.data() + (first - where), last - first);
  }
  return 0;
}

herr_t write(H5FD_t* general, H5FD_mem_t, hid_t, haddr_t at, size_t size, const void* data) {
  auto& file = own(general);
  if (file.failure.empty() && (!file.keep(at, size) || !write_all(file.file, data, size, offset(at))))
    note_failure(file);
  const auto* bytes = static_cast<const char*>(data);
  if (!file.failure.empty()) file.unwritten.emplace_back(at, std::vector<char>(bytes, bytes + size));
  file.end = std::max<std::uint64_t>(file.end, at + size);
  return 0;
}

herr_t truncate(H5FD_t* general, hid_t, hbool_t) {
  auto& file = own(general);
  if (file.end == file.address_end || !file.failure.empty()) return 0;
  if (!file.keep(file.address_end, file.flushed) || ::ftruncate(file.file, offset(file.address_end)) != 0)
    note_failure(file);
  file.end = file.address_end;
  return 0;
}

/// The last call of H5Fflush: the file now holds a complete state.
herr_t flush(H5FD_t* general, hid_t, hbool_t) {
  auto& file = own(general);
  if (file.failure.empty() && !file.commit()) note_failure(file);
  return 0;
}

herr_t handle(H5FD_t* general, hid_t, void** out) {
  *out = &own(general).failure;
  return 0;
}

herr_t no_lock(H5FD_t*, hbool_t) { return 0; }
herr_t no_unlock(H5FD_t*) { return 0; }

}  // namespace

std::int64_t undo_driver() {
  static const hid_t driver = [] {
    H5open();
    H5FD_class_t c{};
    c.name = "poretwin_undo";
    c.maxaddr = HADDR_MAX / 2;
    c.fc_degree = H5F_CLOSE_WEAK;
    c.open = open_file;
    c.close = close_file;
    c.cmp = compare;
    c.query = query;
    c.get_eoa = address_end;
    c.set_eoa = set_address_end;
    c.get_eof = file_end;
    c.read = read;
    c.write = write;
    c.flush = flush;
    c.truncate = truncate;
    c.get_handle = handle;
    c.lock = no_lock;
    c.unlock = no_unlock;
    const H5FD_mem_t map[] = H5FD_FLMAP_DICHOTOMY;
    std::copy(std::begin(map), std::end(map), c.fl_map);
    return H5FDregister(&c);
  }();
  return driver;
}

std::string undo_failure(std::int64_t object) {
  std::string found;
  const hid_t file = H5Iget_file_id(object);
  if (file < 0) return found;
  const hid_t access = H5Fget_access_plist(file);
  void* failure = nullptr;
  if (access >= 0 && H5Pget_driver(access) == undo_driver() && H5Fget_vfd_handle(file, access, &failure) >= 0)
    found = *static_cast<const std::string*>(failure);
  if (access >= 0) H5Pclose(access);
  H5Fclose(file);
  return found;
}

void roll_back(const std::filesystem::path& path) {
  const std::string undo = undo_of(path.string());
  const int journal = ::open(undo.c_str(), O_RDONLY | O_CLOEXEC);
  if (journal < 0) return;
  const int file = ::open(path.c_str(), O_RDWR | O_CLOEXEC);
  const bool good = file >= 0 && undo_all(file, journal);
  const int error = errno;
  ::close(journal);
  if (file >= 0) ::close(file);
  if (!good)
    throw FileError(
        fmt::format("{}: cannot be brought back to its last frame: {}", path.string(), std::strerror(error)));
  ::unlink(undo.c_str());
}

}  // namespace poretwin::hdf5
