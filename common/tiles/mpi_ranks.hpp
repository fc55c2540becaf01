// The ranks of a solver over MPI, and which copies of particles pass between them.
#pragma once

#include "common/core/unset.hpp"
#include "common/core/vector.hpp"
#include "common/particles/domain.hpp"
#include "common/tiles/communicator.hpp"

#include <type_traits>

namespace poretwin::tiles {

/// Which copies of particles a rank sends to its neighbours, and how many it receives. Its halo lies behind its owned
/// particles in the order of `neighbours`.
struct HaloPlan {
  struct Neighbour {
    int rank;
    std::vector<Index> sent;  ///< owned particles of which that rank has copies, in the order of its halo
    std::size_t received;     ///< copies of its particles in this rank's halo
  };
  std::vector<Neighbour> neighbours;  ///< ascending by rank
  std::size_t owned = 0, halo = 0;    ///< particles of this rank
};

/// The ranks of a solver with the halo of one set of particles. The communicator must outlive this.
class MpiRanks final : public Ranks {
 public:
  /// An exchange that has begun.
  struct Exchange {
    UnsetArray<std::byte> packed;
    Transfer transfer;
  };

  explicit MpiRanks(const Communicator& all, HaloPlan plan = {}) : all_(&all), plan_(std::move(plan)) {}

  /// Every rank gathers the values of all ranks and adds them in the order of the ranks. The result therefore has the
  /// same bits on every rank, and in every run with as many ranks, whatever way MPI takes between them.
  void sum(std::span<double> values) const override;
  /// NaN where the value of any rank is NaN: a comparison with it must not come out differently on different ranks.
  void max(std::span<double> values) const override;
  void exchange(std::span<double> values, std::size_t each) const override {
    end_exchange(begin_exchange(values, each));
  }

  /// The two halves of exchange(), between which a rank computes what needs no halo. Owned values may be changed in
  /// between: they are sent as they were at the beginning. Several exchanges may be under way at once, and each ends
  /// with the whole halo filled. Values may be of any
  /// plain type, without pointers, whose size is a multiple of 8 bytes.
  template <class T>
  [[nodiscard]] Exchange begin_exchange(std::span<T> values, std::size_t each) const {
    static_assert(sizeof(T) % sizeof(double) == 0, "values are sent in words of 8 bytes");
    return begin_words(std::as_writable_bytes(values), each * (sizeof(T) / sizeof(double)));
  }
  void end_exchange(Exchange exchange) const { exchange.transfer.finish(); }

  [[nodiscard]] const HaloPlan& plan() const { return plan_; }
  /// The particles of this rank, for functions that ask for them.
  [[nodiscard]] Domain domain() const { return {*this, plan_.owned, plan_.halo}; }

 private:
  Exchange begin_words(std::span<std::byte> values, std::size_t each) const;

  const Communicator* all_;
  HaloPlan plan_;
};

}  // namespace poretwin::tiles
