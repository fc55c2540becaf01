// HDF5 rewrites its index in place: a process that dies in the middle would leave a file nobody can read, all earlier
// frames with it. This driver of the library first copies what a write is about to replace to FILE.undo; a flush
// empties it. Whatever happens, the file can be brought back to its last flush.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace poretwin::hdf5 {

/// The driver's handle (hid_t), registered on first use.
std::int64_t undo_driver();

/// Why a write to the file of this object has failed ("cannot be written: No space left on device"); empty: none has.
/// The library itself does not hear of it. From then on nothing reaches the file; closing brings it back to its last
/// flush.
std::string undo_failure(std::int64_t object);

/// Brings a file that nobody has open back to its last flush, if it was left in the middle. Throws FileError.
void roll_back(const std::filesystem::path& path);

}  // namespace poretwin::hdf5
