// Walls thinner than the kernel's support: a point does not see points behind such a wall, but sees the images that it
// makes. It sees another point along a straight line that no wall crosses, and an image along a line that is reflected
// by walls, which is equally long in both directions. In every direction a point sees either the water behind a wall or
// the image there, never both, also past free tips and corners, so that its surroundings are filled once.
#pragma once

#include "common/particles/images.hpp"

namespace poretwin::sph {

/// Images by all orders of mirrors: past a corner some points see the one order, some the other. At most a range away.
template <int D>
Images<D> images_in_all_orders(std::span<const Vec<D>> points, std::span<const ImagePlane<D>> planes, double range);

/// What is seen past the walls of a scene (2D). Without any, everything is.
template <int D>
class Sight {
 public:
  using Near = std::vector<Index>;

  Sight() = default;
  /// planes: with their screens, the wall's pieces that stand in the way; slack [m]: of coordinates, by rounding.
  Sight(std::vector<ImagePlane<D>> planes, double slack);
  [[nodiscard]] bool limited() const { return !screens_.empty(); }
  [[nodiscard]] std::span<const ImagePlane<D>> planes() const { return planes_; }

  /// The screens within reach of x.
  void find_near(const Vec<D>& x, double reach, Near& near) const;

  /// Is the straight way from x to y open? Two screens, those on which it begins and ends, do not count.
  [[nodiscard]] bool open(const Vec<D>& x, const Vec<D>& y, const Near& near, int but = -1, int nor = -1) const;

  /// Does x see image j of `position`, base points and then the images of them? by, of: as in Images.
  [[nodiscard]] bool sees(const Vec<D>& x, Index j, std::size_t n_base, std::span<const Vec<D>> position,
                          std::span<const Index> by, std::span<const Index> of, const Near& near) const;

  /// A point that has moved from `before` through mirrors is thrown back by them; its velocity towards them [m/s] is
  /// stopped.
  void keep_inside(const Vec<D>& before, Vec<D>& x, Vec<D>& v) const;

 private:
  std::vector<ImagePlane<D>> planes_, screens_;
  double slack_ = 0.0;
};

}  // namespace poretwin::sph
