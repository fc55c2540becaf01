// The fuzz targets without libFuzzer: the stored corpus, then COUNT mutations of it with a fixed seed, as part of every
// test run; `cmake --preset fuzz` is for long runs. Usage: FOLDER COUNT
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

using Bytes = std::vector<std::uint8_t>;

void mutate(Bytes& bytes, const std::vector<Bytes>& corpus, std::mt19937_64& random) {
  const auto below = [&](std::size_t n) { return n == 0 ? std::size_t{0} : static_cast<std::size_t>(random() % n); };
  for (auto changes = 1 + below(4); changes > 0; --changes) {
    const auto at = static_cast<std::ptrdiff_t>(below(bytes.size() + 1));
    const auto length =
        static_cast<std::ptrdiff_t>(below(1 + std::min<std::size_t>(16, bytes.size() - static_cast<std::size_t>(at))));
    const auto& other = corpus[below(corpus.size())];
    const auto from = static_cast<std::ptrdiff_t>(below(other.size() + 1));
    const auto piece = static_cast<std::ptrdiff_t>(
        below(1 + std::min<std::size_t>(32, other.size() - static_cast<std::size_t>(from))));
    switch (below(5)) {
      case 0:
        if (at < std::ssize(bytes)) bytes[static_cast<std::size_t>(at)] ^= static_cast<std::uint8_t>(1u << below(8));
        break;
      case 1:
        if (at < std::ssize(bytes)) bytes[static_cast<std::size_t>(at)] = static_cast<std::uint8_t>(below(256));
        break;
      case 2:
        bytes.erase(bytes.begin() + at, bytes.begin() + at + length);
        break;
      case 3:
        bytes.insert(bytes.begin() + at, other.begin() + from, other.begin() + from + piece);
        break;
      default:
        bytes.resize(static_cast<std::size_t>(at));
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(argv[1])) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<Bytes> corpus;
  for (const auto& file : files) {
    std::ifstream stream(file, std::ios::binary);
    corpus.emplace_back(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
    LLVMFuzzerTestOneInput(corpus.back().data(), corpus.back().size());
  }
  if (corpus.empty()) return 1;
  std::mt19937_64 random(1);
  const long count = std::atol(argv[2]);
  for (long k = 0; k < count; ++k) {
    Bytes bytes = corpus[random() % corpus.size()];
    mutate(bytes, corpus, random);
    LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
  }
  std::printf("%zu files, %ld mutations\n", corpus.size(), count);
}
