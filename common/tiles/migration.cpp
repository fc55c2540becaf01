#include "common/tiles/migration.hpp"

#include "common/core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>

namespace poretwin::tiles {
namespace {

/// Number of particles and a sum of scrambled ids, modulo 2^64: equal sums mean equal sets but for a chance of 2^-64.
struct Census {
  std::uint64_t particles = 0, ids = 0;
  std::uint64_t doubled = 0;  ///< 1 where the particle `twice` is here two times
  GlobalId twice = 0;
  void count(GlobalId id) {
    ++particles;
    // The finaliser of splitmix64 (Steele, Lea and Flood 2014).
    id += 0x9e3779b97f4a7c15ULL;
    id = (id ^ (id >> 30U)) * 0xbf58476d1ce4e5b9ULL;
    id = (id ^ (id >> 27U)) * 0x94d049bb133111ebULL;
    ids += id ^ (id >> 31U);
  }
};

/// Throws on every rank where any has lost or doubled a particle.
void expect_same_particles(const Communicator& all, const Census& before, const Census& after) {
  const std::array<Census, 2> own{before, after};
  Census sum_before, sum_after;
  const auto of_ranks = all.gather(std::span<const Census>(own), 'm');
  for (std::size_t r = 0; r < of_ranks.size(); r += 2) {
    if (of_ranks[r + 1].doubled)
      throw Error(ExitCode::failure,
                  fmt::format("rank {} has two particles with the id {}", r / 2, of_ranks[r + 1].twice));
    sum_before.particles += of_ranks[r].particles;
    sum_before.ids += of_ranks[r].ids;
    sum_after.particles += of_ranks[r + 1].particles;
    sum_after.ids += of_ranks[r + 1].ids;
  }
  if (sum_before.particles != sum_after.particles || sum_before.ids != sum_after.ids)
    throw Error(
        ExitCode::failure,
        fmt::format("migration between ranks: {} particles before, {} after it{}", sum_before.particles,
                    sum_after.particles, sum_before.particles == sum_after.particles ? ", not the same ones" : ""));
}

}  // namespace

Migrated migrate(const Communicator& all, std::span<const int> owner, std::vector<GlobalId>& ids,
                 const ParticleArrays& arrays) {
  const std::size_t n = ids.size();
  if (owner.size() != n)
    throw Error(ExitCode::failure, fmt::format("migration of {} particles with {} owners", n, owner.size()));
  std::size_t record = sizeof(GlobalId);
  for (std::size_t k = 0; k < arrays.arrays().size(); ++k) {
    const auto& array = arrays.arrays()[k];
    if (array.bytes().size() != n * array.each)
      throw Error(ExitCode::failure, fmt::format("migration of {} particles: array number {} has {} bytes, not {} each",
                                                 n, k, array.bytes().size(), array.each));
    record += array.each;
  }

  // A particle that leaves is a record: its id, then its entries in each array.
  Migrated moved;
  Census before, after;
  std::vector<Bytes> to(static_cast<std::size_t>(all.size()));
  for (std::size_t i = 0; i < n; ++i) {
    before.count(ids[i]);
    if (owner[i] == all.rank()) continue;
    Bytes& message = to.at(static_cast<std::size_t>(owner[i]));
    std::size_t at = message.size();
    message.resize(at + record);
    std::memcpy(&message[at], &ids[i], sizeof(GlobalId));
    at += sizeof(GlobalId);
    for (const auto& array : arrays.arrays()) {
      std::memcpy(&message[at], array.bytes().data() + i * array.each, array.each);
      at += array.each;
    }
    ++moved.left;
  }
  const std::vector<Bytes> from = all.trade(to);

  // Where each particle of the new order is now: at an old place, or in a message.
  struct Source {
    GlobalId id;
    std::size_t old;
    const std::byte* message;
  };
  std::vector<Source> sources;
  for (std::size_t i = 0; i < n; ++i)
    if (owner[i] == all.rank()) sources.push_back({ids[i], i, nullptr});
  for (const auto& message : from)
    for (std::size_t at = 0; at < message.size(); at += record) {
      Source source{0, 0, &message[at]};
      std::memcpy(&source.id, source.message, sizeof(GlobalId));
      source.message += sizeof(GlobalId);
      sources.push_back(source);
      ++moved.came;
    }
  std::ranges::sort(sources, {}, &Source::id);
  for (std::size_t i = 0; i < sources.size(); ++i) {
    after.count(sources[i].id);
    if (i > 0 && sources[i].id == sources[i - 1].id) {
      after.doubled = 1;
      after.twice = sources[i].id;
    }
  }
  expect_same_particles(all, before, after);

  std::size_t offset = 0;
  Bytes next;
  for (const auto& array : arrays.arrays()) {
    next.resize(sources.size() * array.each);
    const std::byte* const old = array.bytes().data();
    for (std::size_t i = 0; i < sources.size(); ++i) {
      const auto& source = sources[i];
      std::memcpy(next.data() + i * array.each,
                  source.message ? source.message + offset : old + source.old * array.each, array.each);
    }
    array.resize(sources.size());
    if (!next.empty()) std::memcpy(array.bytes().data(), next.data(), next.size());
    offset += array.each;
  }
  ids.resize(sources.size());
  std::ranges::transform(sources, ids.begin(), &Source::id);
  return moved;
}

}  // namespace poretwin::tiles
