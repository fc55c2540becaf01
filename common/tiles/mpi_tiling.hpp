// Tiles of space for the ranks of a solver over MPI: partition, migration and halo behind the interface that solvers
// see.
#pragma once

#include "common/particles/tiling.hpp"
#include "common/tiles/halo.hpp"
#include "common/tiles/partition.hpp"

#include <optional>

namespace poretwin::tiles {

template <int D>
class MpiTiling final : public Tiling<D> {
 public:
  /// Tiles of about equally many particles, cut anew where a rank's number exceeds the mean by more than the fraction
  /// `imbalance`. The communicator must outlive this.
  MpiTiling(const Communicator& all, double imbalance) : all_(all), ranks_(all), imbalance_(imbalance) {}
  /// These tiles, for the whole run.
  MpiTiling(const Communicator& all, Partition<D> fixed) : all_(all), ranks_(all), partition_(std::move(fixed)) {}
  MpiTiling(const MpiTiling&) = delete;
  MpiTiling& operator=(const MpiTiling&) = delete;

  [[nodiscard]] const Ranks& ranks() const override { return ranks_; }
  [[nodiscard]] bool begins_with(GlobalId id) const override {
    return id % static_cast<GlobalId>(all_.size()) == static_cast<GlobalId>(all_.rank());
  }
  void send_to_owners(const VecArray<D>& x, std::vector<GlobalId>& ids, const ParticleArrays& arrays) override;
  [[nodiscard]] std::size_t find_copies(const VecArray<D>& x, std::span<const GlobalId> ids, double reach,
                                        std::span<const Vec<D>> views) override;
  [[nodiscard]] VecArray<D> gather(const VecArray<D>& places) const override { return all_.gather_all(places); }
  [[nodiscard]] ScalarArray gather_numbers(const ScalarArray& numbers) const override {
    return all_.gather_all(numbers);
  }
  [[nodiscard]] bool leads() const override { return all_.rank() == 0; }
  void send_to_leader(std::vector<GlobalId>& ids, const ParticleArrays& arrays) const override;
  [[nodiscard]] std::string from_leader(const std::string& bytes) const override;

  /// What has happened so far: particles that left this rank, and how often space was cut anew.
  [[nodiscard]] std::size_t left() const { return left_; }
  [[nodiscard]] std::size_t cut() const { return cut_; }

 private:
  const Communicator& all_;
  MpiRanks ranks_;
  std::optional<double> imbalance_;  ///< empty: the tiles stay as they are
  std::optional<Partition<D>> partition_;
  std::size_t left_ = 0, cut_ = 0;
};

}  // namespace poretwin::tiles
