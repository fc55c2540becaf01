// Keys of an encrypted run: two files made together, one for the coupler, one for the participants on any machine.
#pragma once

#include <filesystem>
#include <string>

namespace poretwin::coupling {

/// One side's key pair and the other side's public key, all in Z85 (40 characters).
struct CurveKeys {
  std::string public_key, secret_key;
  std::string peer_key;  ///< coupler: of the only participants admitted; participant: of the only coupler accepted
};

enum class KeyHolder { coupler, participant };

/// Makes `folder`/coupler.key and `folder`/participant.key, readable by their owner only. Never replaces a key.
void write_curve_keys(const std::filesystem::path& folder);

/// Throws Error that says what is wrong: not there, not a key file, the other side's file, readable by others.
CurveKeys read_curve_keys(const std::filesystem::path& path, KeyHolder holder);

}  // namespace poretwin::coupling
