// Messages among the ranks of one solver: the processes that mpirun started together. MPI is called in
// communicator.cpp only, and its handle is passed to the partitioner; no header but mpi.hpp includes its own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace poretwin::tiles {

using Bytes = std::vector<std::byte>;

/// Values as a message, and a message as values. Types whose bytes are their value (Plain in particle_arrays.hpp).
template <class Values>
Bytes bytes_of(const Values& values) {
  const auto bytes = std::as_bytes(std::span(values));
  return {bytes.begin(), bytes.end()};
}
template <class T>
std::vector<T> values_of(const Bytes& bytes) {
  std::vector<T> values(bytes.size() / sizeof(T));
  if (!bytes.empty()) std::memcpy(static_cast<void*>(values.data()), bytes.data(), bytes.size());
  return values;
}

/// A message to another rank, and the room for one from another rank, whose length is known.
struct Outgoing {
  int rank;
  std::span<const std::byte> bytes;
};
struct Incoming {
  int rank;
  std::span<std::byte> bytes;
};

/// What this rank has sent to others since the start.
struct Traffic {
  std::uint64_t messages = 0, bytes = 0;
};

/// Messages on their way. The memory of all of them must stay where it is, and must not be changed (incoming: not be
/// read), until finish() returns.
class Transfer {
 public:
  struct State;
  explicit Transfer(std::unique_ptr<State> state);
  Transfer(Transfer&&) noexcept;
  Transfer& operator=(Transfer&&) noexcept;
  /// Without finish() the messages are given up: for the way out after an exception.
  ~Transfer();
  /// Waits for all messages. Throws PeerError where one has another length than expected, or where its sender was at
  /// another call than this rank.
  void finish();

 private:
  std::unique_ptr<State> state_;
};

/// The ranks of a solver, as one of them sees them. Every function is called by all ranks, in the same order. Errors of
/// MPI become a PeerError that names this rank, the call and, where it is known, the other rank.
class Communicator {
 public:
  struct Mpi;
  explicit Communicator(std::unique_ptr<Mpi> mpi);
  ~Communicator();
  Communicator(const Communicator&) = delete;
  Communicator& operator=(const Communicator&) = delete;

  [[nodiscard]] int rank() const;
  [[nodiscard]] int size() const;
  [[nodiscard]] const Traffic& traffic() const;
  /// The window that this rank computes, for messages about it: set by the thread that computes, read by any thread.
  void at_step(std::uint64_t step) const;
  [[nodiscard]] std::uint64_t step() const;
  [[nodiscard]] const Mpi& mpi() const { return *mpi_; }

  /// What each rank gives, in the order of the ranks: [size * own.size()]. All give equally many values. `purpose`
  /// distinguishes calls: ranks that gather for different purposes are found out.
  template <class T>
  requires std::is_trivially_copyable_v<T>
  [[nodiscard]] std::vector<T> gather(std::span<const T> own, char purpose = 'g') const {
    std::vector<T> all(own.size() * static_cast<std::size_t>(size()));
    gather_bytes(std::as_bytes(own), std::as_writable_bytes(std::span(all)), purpose);
    return all;
  }

  /// Sends to[r] to each rank r, and returns what each rank sent to this one, in the order of the ranks; lengths as
  /// they come.
  [[nodiscard]] std::vector<Bytes> trade(std::span<const Bytes> to) const;

  /// On every rank the text or bytes that rank 0 gives; what the others give does not count.
  [[nodiscard]] std::string from_first(const std::string& own) const;

  /// What each rank gives, in the order of the ranks, however many values each has.
  template <class T>
  [[nodiscard]] std::vector<T> gather_all(const std::vector<T>& own) const {
    std::vector<T> all;
    for (const Bytes& from : trade(std::vector<Bytes>(static_cast<std::size_t>(size()), bytes_of(own)))) {
      const std::vector<T> theirs = values_of<T>(from);
      all.insert(all.end(), theirs.begin(), theirs.end());
    }
    return all;
  }

  /// Begins to send and receive messages whose lengths both sides know, at most one from each rank to each.
  [[nodiscard]] Transfer begin(std::span<const Outgoing> out, std::span<const Incoming> in) const;

 private:
  void gather_bytes(std::span<const std::byte> own, std::span<std::byte> all, char purpose) const;

  std::unique_ptr<Mpi> mpi_;
};

/// Begins MPI, calls work(all ranks), ends MPI; returns what work returns, the exit code of this process. An exception
/// that leaves `work` is written to stderr with the number of this rank and ends all ranks with its exit code: the
/// others would wait for this one for ever.
int run_as_rank(int argc, char** argv, const std::function<int(const Communicator&)>& work);

}  // namespace poretwin::tiles
