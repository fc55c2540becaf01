// Quantities that depend only on the particles' positions. They are evaluated on demand, once for each revision of the
// positions.
#pragma once

#include "common/media/seepage.hpp"
#include "solid_solver/exchange/saturation.hpp"

#include <cstdint>
#include <vector>

namespace poretwin::solid {

template <int D>
class PositionCache {
 public:
  /// own_coverage() of the present positions.
  const ScalarArray& coverage(const Setup<D>& setup, const State<D>& state) {
    renew(state);
    if (coverage_.empty()) coverage_ = own_coverage(setup, state);
    return coverage_;
  }
  /// The law of seepage of every particle at its porosity.
  const std::vector<porous::Seepage>& seepage(const Setup<D>& setup, const State<D>& state) {
    renew(state);
    const Particles<D>& p = state.particles;
    for (std::size_t i = seepage_.size(); i < p.size(); ++i)
      seepage_.push_back(seepage_at(setup.water, setup.soils[p.material[i]], void_fraction(setup, p, i)));
    return seepage_;
  }
  /// To be called after positions have changed without a new revision.
  void forget() { *this = {}; }

 private:
  void renew(const State<D>& state) {
    if (revision_ == state.revision) return;
    forget();
    revision_ = state.revision;
  }

  std::uint64_t revision_ = 0;
  ScalarArray coverage_;
  std::vector<porous::Seepage> seepage_;
};

}  // namespace poretwin::solid
