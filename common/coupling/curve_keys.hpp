// Keys of an encrypted run: two files made together, one for the coupler, one for the participants on all machines.
#pragma once

#include <filesystem>
#include <string>

namespace poretwin::coupling {

/// One side's key pair and the other side's public key, all in Z85 (40 characters).
struct CurveKeys {
  std::string public_key, secret_key;
  std::string peer_key;  ///< of the only admitted participants (coupler's file) or the only accepted coupler
};

enum class KeyHolder { coupler, participant };

/// Makes `folder`/coupler.key and `folder`/participant.key, which only their owner can read. Never replaces a key.
void write_curve_keys(const std::filesystem::path& folder);

/// Reads a key file. Throws Error with the fault: the file is missing, not a key file, the other side's file, or
/// readable by others.
CurveKeys read_curve_keys(const std::filesystem::path& path, KeyHolder holder);

}  // namespace poretwin::coupling
