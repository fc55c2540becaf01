#include "common/tiles/mpi_ranks.hpp"

#include "common/core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace poretwin::tiles {

void MpiRanks::sum(std::span<double> values) const {
  const auto all = all_->gather(std::span<const double>(values), '+');
  std::fill(values.begin(), values.end(), 0.0);
  for (std::size_t k = 0; k < all.size(); ++k) values[k % values.size()] += all[k];
}

void MpiRanks::max(std::span<double> values) const {
  const auto all = all_->gather(std::span<const double>(values), '>');
  std::fill(values.begin(), values.end(), -std::numeric_limits<double>::infinity());
  for (std::size_t k = 0; k < all.size(); ++k) {
    double& most = values[k % values.size()];
    if (std::isnan(all[k]) || all[k] > most) most = all[k];
  }
}

MpiRanks::Exchange MpiRanks::begin_words(std::span<std::byte> values, std::size_t each) const {
  constexpr std::size_t word = sizeof(double);
  const std::size_t bytes = each * word;
  if (values.size() != (plan_.owned + plan_.halo) * bytes)
    throw Error(
        ExitCode::failure,
        fmt::format("rank {}: exchange of {} numbers for each of {} owned particles and {} copies, but the array "
                    "has {} numbers",
                    all_->rank(), each, plan_.owned, plan_.halo, values.size() / word));
  std::size_t n = 0;
  for (const auto& neighbour : plan_.neighbours) n += neighbour.sent.size();
  UnsetArray<std::byte> packed(n * bytes);
  std::vector<Outgoing> out;
  std::vector<Incoming> in;
  std::byte* to = packed.data();
  std::byte* halo = values.data() + plan_.owned * bytes;
  for (const auto& neighbour : plan_.neighbours) {
    const std::byte* const first = to;
    if (each == 1)  // the length is known to the compiler: no call for each number
      for (const Index i : neighbour.sent) {
        std::memcpy(to, values.data() + i * word, word);
        to += word;
      }
    else
      for (const Index i : neighbour.sent) {
        std::memcpy(to, values.data() + i * bytes, bytes);
        to += bytes;
      }
    if (!neighbour.sent.empty()) out.push_back({neighbour.rank, {first, to}});
    if (neighbour.received > 0) in.push_back({neighbour.rank, {halo, neighbour.received * bytes}});
    halo += neighbour.received * bytes;
  }
  // Moving the array does not move the bytes that are being sent.
  Transfer transfer = all_->begin(out, in);
  return {std::move(packed), std::move(transfer)};
}

}  // namespace poretwin::tiles
