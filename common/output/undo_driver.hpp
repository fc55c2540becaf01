// An HDF5 file driver that protects finished frames. HDF5 changes its index in place: if the process ended during such
// a change, the whole file would be unreadable. The driver first copies the data that a write replaces to FILE.undo. A
// flush empties FILE.undo, so that the data file can always be restored to its last flush.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace poretwin::hdf5 {

/// The driver's handle (hid_t), registered on first use.
std::int64_t undo_driver();

/// The message of the first failed write to the file of this object ("cannot be written: No space left on device");
/// empty if no write failed. The HDF5 library does not see the failure. After it, nothing more is written; closing
/// restores the file to its last flush.
std::string undo_failure(std::int64_t object);

/// Restores a file that no process has open to its last flush if a write to it was interrupted. Throws FileError.
void roll_back(const std::filesystem::path& path);

}  // namespace poretwin::hdf5
