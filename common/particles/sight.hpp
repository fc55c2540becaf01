// Lines of sight past walls thinner than the kernel's support. A point does not see points behind such a wall, but sees
// the wall's images. It sees another point along a straight line that no wall crosses, and an image along the line that
// the walls reflect, of equal length in both directions. In each direction it sees either the water behind a wall or an
// image, but not both, also past free tips and corners: its surroundings are filled exactly once.
#pragma once

#include "common/particles/images.hpp"

namespace poretwin::sph {

/// Reflections in a row that are followed. Near a corner of 90 degrees two fill the surroundings.
inline constexpr int most_reflections = 3;

/// Images by all orders of mirrors, within `range` [m]: near a corner, different points see different orders.
template <int D>
Images<D> images_in_all_orders(std::span<const Vec<D>> points, std::span<const ImagePlane<D>> planes, double range);

/// Which points see each other past the walls of a scene (2D). Without walls all points see each other.
template <int D>
class Sight {
 public:
  using Near = std::vector<Index>;

  Sight() = default;
  /// planes: the mirrors, with their screens (the wall pieces that block sight); slack [m]: rounding error of
  /// coordinates.
  Sight(std::vector<ImagePlane<D>> planes, double slack);
  [[nodiscard]] bool limited() const { return !screens_.empty(); }
  [[nodiscard]] std::span<const ImagePlane<D>> planes() const { return planes_; }

  /// Finds the screens within reach [m] of x.
  void find_near(const Vec<D>& x, double reach, Near& near) const;

  /// Whether no screen blocks the straight line from x to y. The screens `but` and `nor`, on which the line begins and
  /// ends, are ignored.
  [[nodiscard]] bool open(const Vec<D>& x, const Vec<D>& y, const Near& near, int but = -1, int nor = -1) const;

  /// Whether x sees image j of `position`, which contains n_base points, then their images. by, of: those of Images.
  [[nodiscard]] bool sees(const Vec<D>& x, Index j, std::size_t n_base, std::span<const Vec<D>> position,
                          std::span<const Index> by, std::span<const Index> of, const Near& near) const;

  /// Whether point a and point or image j see each other. The result is the same to the last bit with two points
  /// exchanged, so that a pair is in the rows of both or of neither. near: the screens near point a.
  [[nodiscard]] bool pairs(Index a, Index j, std::size_t n_base, std::span<const Vec<D>> position,
                           std::span<const Index> by, std::span<const Index> of, const Near& near) const {
    return j >= n_base ? sees(position[a], j, n_base, position, by, of, near)
                       : open(position[std::min(a, j)], position[std::max(a, j)], near);
  }

  /// Reflects a point that has moved from `before` through mirrors. Removes its velocity [m/s] towards each mirror,
  /// relative to the mirror.
  void keep_inside(const Vec<D>& before, Vec<D>& x, Vec<D>& v) const;

 private:
  std::vector<ImagePlane<D>> planes_, screens_;
  double slack_ = 0.0;
};

}  // namespace poretwin::sph
