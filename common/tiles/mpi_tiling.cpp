#include "common/tiles/mpi_tiling.hpp"

namespace poretwin::tiles {

template <int D>
void MpiTiling<D>::send_to_owners(const VecArray<D>& x, std::vector<GlobalId>& ids, const ParticleArrays& arrays) {
  if (imbalance_ && (!partition_ || imbalance(all_, static_cast<double>(x.size())) > *imbalance_)) {
    if (partition_) ++cut_;
    partition_ = bisect<D>(all_, x, ScalarArray(x.size(), 1.0));
  }
  left_ += migrate(all_, partition_->owners(x, all_.rank()), ids, arrays).left;
}

template <int D>
std::size_t MpiTiling<D>::find_copies(const VecArray<D>& x, std::span<const GlobalId> ids, double reach,
                                      std::span<const Vec<D>> views) {
  ranks_ = MpiRanks(all_, find_halo<D>(all_, x, ids, reach, {}, views));
  return ranks_.plan().halo;
}

template <int D>
void MpiTiling<D>::send_to_leader(std::vector<GlobalId>& ids, const ParticleArrays& arrays) const {
  migrate(all_, std::vector<int>(ids.size(), 0), ids, arrays);
}

template <int D>
std::string MpiTiling<D>::from_leader(const std::string& bytes) const {
  return all_.from_first(bytes);
}

template class MpiTiling<2>;
template class MpiTiling<3>;

}  // namespace poretwin::tiles
