#include "common/particles/sight.hpp"

#include <cmath>

namespace poretwin::sph {
namespace {

/// Coordinate along the plane at which the line from x to y crosses it, given the distances of x and y from the plane.
/// Exchanging x and y gives the same result to the last bit.
template <int D>
double crossing(const ImagePlane<D>& plane, const Vec<D>& x, const Vec<D>& y, double from, double to) {
  const double sum = from + to;
  if (sum == 0.0) return 0.5 * plane.tangent.dot(x + y);
  return (from * plane.tangent.dot(y) + to * plane.tangent.dot(x)) / sum;
}

}  // namespace

template <int D>
Images<D> images_in_all_orders(std::span<const Vec<D>> points, std::span<const ImagePlane<D>> planes, double range) {
  Images<D> images;
  const auto add = [&](std::size_t p, const Vec<D>& x, std::size_t of, const Index* maker) {
    const auto& plane = planes[p];
    const double distance = plane.normal.dot(x - plane.point);
    if (distance < 0.0 || distance > range || !plane.faces(x)) return;
    const bool mirror = plane.kind == ImagePlane<D>::Kind::mirror;
    Mat<D> own = Mat<D>::Identity();
    if (mirror) own -= 2.0 * plane.normal * plane.normal.transpose();
    const std::size_t made = of - points.size();
    images.position.push_back(mirror ? Vec<D>(x - 2.0 * distance * plane.normal) : Vec<D>(x + plane.shift));
    images.parent.push_back(maker ? images.parent[made] : static_cast<Index>(of));
    images.map.push_back(maker ? Mat<D>(own * images.map[made]) : own);
    images.carried.push_back((maker ? Vec<D>(own * images.carried[made]) : Vec<D>(Vec<D>::Zero())) +
                             2.0 * plane.speed * plane.normal);
    images.boundaries.push_back((maker ? images.boundaries[made] : 0u) | (1u << plane.boundary));
    images.by.push_back(static_cast<Index>(p));
    images.of.push_back(static_cast<Index>(of));
  };
  for (std::size_t p = 0; p < planes.size(); ++p)
    for (std::size_t i = 0; i < points.size(); ++i) add(p, points[i], i, nullptr);
  // Two mirrors reflect each other's images only if each of them lies in front of the other.
  const auto before = [&](const ImagePlane<D>& seen, const ImagePlane<D>& mirror) {
    for (const double along : {seen.seen_from, seen.seen_to})
      if (mirror.normal.dot(seen.at(along) - mirror.point) > 1e-6 * range) return true;
    return false;
  };
  std::vector<std::vector<Index>> next(planes.size());
  for (std::size_t q = 0; q < planes.size(); ++q)
    for (std::size_t p = 0; p < planes.size(); ++p)
      if (p != q && before(planes[q], planes[p]) && before(planes[p], planes[q]))
        next[q].push_back(static_cast<Index>(p));
  std::size_t first = 0;
  for (int reflections = 2; reflections <= most_reflections; ++reflections) {
    const std::size_t last = images.size();
    for (std::size_t k = first; k < last; ++k) {
      const Index maker = images.by[k];
      for (const Index p : next[maker]) add(p, Vec<D>(images.position[k]), points.size() + k, &maker);
    }
    first = last;
  }
  return images;
}

template <int D>
Sight<D>::Sight(std::vector<ImagePlane<D>> planes, double slack) : planes_(std::move(planes)), slack_(slack) {
  for (const auto& plane : planes_) {
    if (plane.screen < 0) continue;
    const auto s = static_cast<std::size_t>(plane.screen);
    if (s >= screens_.size()) screens_.resize(s + 1);
    if (!plane.back) screens_[s] = plane;
  }
}

template <int D>
void Sight<D>::find_near(const Vec<D>& x, double reach, Near& near) const {
  near.clear();
  for (std::size_t s = 0; s < screens_.size(); ++s) {
    const auto& screen = screens_[s];
    if (std::abs(screen.normal.dot(x - screen.point)) > reach) continue;
    const double along = screen.tangent.dot(x);
    if (along > screen.seen_from - reach && along < screen.seen_to + reach) near.push_back(static_cast<Index>(s));
  }
}

template <int D>
bool Sight<D>::open(const Vec<D>& x, const Vec<D>& y, const Near& near, int but, int nor) const {
  for (const Index s : near) {
    if (static_cast<int>(s) == but || static_cast<int>(s) == nor) continue;
    const auto& screen = screens_[s];
    const double from = screen.normal.dot(x - screen.point), to = screen.normal.dot(y - screen.point);
    if ((from >= -slack_) == (to >= -slack_)) continue;
    const double along = crossing(screen, x, y, std::abs(from), std::abs(to));
    if (along >= screen.seen_from - slack_ && along <= screen.seen_to + slack_) return false;
  }
  return true;
}

template <int D>
bool Sight<D>::sees(const Vec<D>& x, Index j, std::size_t n_base, std::span<const Vec<D>> position,
                    std::span<const Index> by, std::span<const Index> of, const Near& near) const {
  Vec<D> here = x;
  int behind = -1;  // screen of the last reflection
  Index last = 0;   // plane of the last reflection
  bool thrown = false;
  while (j >= n_base) {
    const Index mirror = by[j - n_base];
    const auto& plane = planes_[mirror];
    const Vec<D>& target = position[of[j - n_base]];
    j = of[j - n_base];
    if (plane.kind == ImagePlane<D>::Kind::periodic) {
      here -= plane.shift;
      continue;
    }
    const double from = plane.normal.dot(here - plane.point), to = plane.normal.dot(target - plane.point);
    if (from < (plane.back && !thrown ? slack_ : -slack_)) return false;
    const double along = crossing(plane, here, target, std::abs(from), std::abs(to));
    if (along < plane.seen_from + (plane.taken ? slack_ : -slack_) || along > plane.seen_to + slack_) return false;
    const Vec<D> foot = plane.at(along);
    // At a corner, both orders of the two mirrors give an image; only one of the two counts.
    if (thrown && (foot - here).squaredNorm() < 1e4 * slack_ * slack_ && last > mirror) return false;
    // The path stops slightly before the wall, on the side from which it comes: other walls may end there.
    const Vec<D> back = here - foot;
    const double way = back.norm();
    const Vec<D> turn = foot + slack_ * plane.normal + (way > 10.0 * slack_ ? 10.0 * slack_ / way : 0.0) * back;
    if (!open(here, turn, near, plane.screen, behind)) return false;
    here = turn;
    behind = plane.screen;
    last = mirror;
    thrown = true;
  }
  return open(here, position[j], near, behind);
}

template <int D>
void Sight<D>::keep_inside(const Vec<D>& before, Vec<D>& x, Vec<D>& v) const {
  constexpr int most_walls = 4;
  Vec<D> from = before;
  for (int k = 0; k < most_walls; ++k) {
    const ImagePlane<D>* hit = nullptr;
    double nearest = 2.0;
    for (const auto& plane : planes_) {
      if (plane.kind != ImagePlane<D>::Kind::mirror) continue;
      const double inside = plane.normal.dot(from - plane.point), outside = plane.normal.dot(plane.point - x);
      if (inside < (plane.back ? slack_ : -slack_) || outside <= 0.0) continue;
      const double along = crossing(plane, from, x, std::abs(inside), outside);
      if (along < plane.seen_from - slack_ || along > plane.seen_to + slack_) continue;
      const double way = std::abs(inside) / (std::abs(inside) + outside);
      if (way < nearest) {
        nearest = way;
        hit = &plane;
      }
    }
    if (!hit) return;
    from += nearest * (x - from) + 10.0 * slack_ * hit->normal;
    x -= 2.0 * hit->normal.dot(x - hit->point) * hit->normal;
    v -= std::min(0.0, hit->normal.dot(v) - hit->speed) * hit->normal;
  }
}

template Images<2> images_in_all_orders<2>(std::span<const Vec<2>>, std::span<const ImagePlane<2>>, double);
template Images<3> images_in_all_orders<3>(std::span<const Vec<3>>, std::span<const ImagePlane<3>>, double);
template class Sight<2>;
template class Sight<3>;

}  // namespace poretwin::sph
