#include "common/coupling/curve_keys.hpp"

#include "common/core/error.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zmq.h>

#include <array>
#include <cstring>
#include <fstream>
#include <map>

namespace poretwin::coupling {
namespace {

constexpr std::size_t key_length = 40;  // characters: 32 bytes in Z85

std::string name_of(KeyHolder holder) { return holder == KeyHolder::coupler ? "coupler" : "participant"; }

struct Pair {
  std::array<char, key_length + 1> open{}, secret{};
};

Pair new_pair() {
  Pair pair;
  if (zmq_curve_keypair(pair.open.data(), pair.secret.data()) != 0)
    throw Error(ExitCode::failure, "this ZeroMQ was built without CURVE: no keys can be made");
  return pair;
}

void write_one(const std::filesystem::path& path, KeyHolder holder, const Pair& own, const Pair& other) {
  const std::string text =
      fmt::format("# poretwin {} key: secret. Made together with the {}'s.\nholder {}\npublic {}\nsecret {}\npeer {}\n",
                  name_of(holder), name_of(holder == KeyHolder::coupler ? KeyHolder::participant : KeyHolder::coupler),
                  name_of(holder), own.open.data(), own.secret.data(), other.open.data());
  // Never replaces an existing key; the file is created with permissions for its owner only.
  const int file = ::open(path.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, S_IRUSR | S_IWUSR);
  if (file < 0) throw FileError("cannot make " + path.string() + ": " + std::strerror(errno));
  const bool written = ::write(file, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  if (::close(file) != 0 || !written) throw FileError("cannot write " + path.string() + ": is the disk full?");
}

}  // namespace

void write_curve_keys(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw FileError(fmt::format("{}: the folder cannot be made: {}", folder.string(), error.message()));
  const Pair coupler = new_pair(), participant = new_pair();
  write_one(folder / "coupler.key", KeyHolder::coupler, coupler, participant);
  write_one(folder / "participant.key", KeyHolder::participant, participant, coupler);
}

CurveKeys read_curve_keys(const std::filesystem::path& path, KeyHolder holder) {
  std::ifstream stream(path);
  if (!stream) throw FileError(fmt::format("cannot read the key {}: {}", path.string(), std::strerror(errno)));
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0 && (status.st_mode & (S_IRWXG | S_IRWXO)) != 0)
    throw CaseError(fmt::format("{}: others may read this secret key; `chmod 600` it", path.string()));
  std::map<std::string, std::string> values;
  for (std::string line; std::getline(stream, line) && line.size() < 1000;)
    if (const auto space = line.find(' '); space != std::string::npos && line[0] != '#')
      values[line.substr(0, space)] = line.substr(space + 1);
  if (values["holder"] != name_of(holder))
    throw CaseError(fmt::format("{}: expected a {} key made by `poretwin keys`, found {}", path.string(),
                                name_of(holder),
                                values["holder"].empty() ? "something else" : "a " + values["holder"] + " key"));
  for (const char* key : {"public", "secret", "peer"})
    if (values[key].size() != key_length)
      throw CaseError(fmt::format("{}: expected '{}' with {} characters, found {}", path.string(), key, key_length,
                                  values[key].size()));
  return {values["public"], values["secret"], values["peer"]};
}

}  // namespace poretwin::coupling
