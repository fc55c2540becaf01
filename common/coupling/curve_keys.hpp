// Keys of an encrypted run: two files made together, one for the coupler, one for the participants on all machines.
#pragma once

#include <filesystem>
#include <string>

namespace poretwin::coupling {

/// One side's key pair and the other side's public key, all in Z85 (40 characters).
struct CurveKeys {
  std::string public_key, secret_key;
  std::string peer_key;  ///< the only admitted participants' (in the coupler's file), or the only accepted coupler's
};

enum class KeyHolder { coupler, participant };

/// Makes `folder`/coupler.key and `folder`/participant.key, readable by their owner only. Never replaces a key.
void write_curve_keys(const std::filesystem::path& folder);

/// Reads a key file. Throws Error saying what is wrong: missing, not a key file, the other side's file, readable by
/// others.
CurveKeys read_curve_keys(const std::filesystem::path& path, KeyHolder holder);

}  // namespace poretwin::coupling
