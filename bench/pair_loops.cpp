// Pair loops compared with what this machine can do: one fused pass of density divergence, pressure gradient and
// Laplacian over the pairs of a jittered lattice, with a neighbour list, a list in lanes and a half list in lanes; and
// the loops of both solvers on the same points. Run by hand: `ninja pair_loops && bin/pair_loops [PARTICLES]`.
#include "bench/timing.hpp"
#include "common/particles/for_pairs.hpp"
#include "fluid_solver/discretisation/operators.hpp"
#include "solid_solver/discretisation/operators.hpp"

#include <fmt/format.h>

#include <random>

using namespace poretwin;

namespace {

/// Values that the pass reads: x, y, u, v, p, V; and that it sums: divergence, gradient, Laplacian.
struct alignas(64) Point {
  double x[8]{};
  [[nodiscard]] const double* row() const { return x; }
};

double scale_of(double h) { return 5.0 * sph::WendlandC2<2>::normalisation(h) / (h * h); }

/// With a list of all neighbours, one pair at a time.
void plain_pass(const std::vector<Point>& points, const sph::PairList& list, double h,
                std::vector<solid::Sums<4>>& sums) {
  const double scale = scale_of(h);
  for (std::size_t i = 0; i < list.size(); ++i) {
    const double* const a = points[i].x;
    double divergence = 0.0, gx = 0.0, gy = 0.0, laplacian = 0.0;
    for (const Index j : list.of(i)) {
      const double* const b = points[j].x;
      const double rx = b[0] - a[0], ry = b[1] - a[1], u = std::max(0.0, 1.0 - 0.5 / h * std::sqrt(rx * rx + ry * ry));
      const double factor = scale * u * u * u * b[5], difference = b[4] - a[4];
      divergence += factor * ((b[2] - a[2]) * rx + (b[3] - a[3]) * ry);
      gx += factor * difference * rx;
      gy += factor * difference * ry;
      laplacian += 2.0 * factor * difference;
    }
    sums[i].x = {divergence, gx, gy, laplacian};
  }
}

/// Four pairs at a time, each stored once or twice.
void lane_pass(const std::vector<Point>& points, const solid::Pairs& pairs, double h,
               std::vector<solid::Sums<4>>& sums) {
  sums.assign(points.size(), {});
  const double scale = scale_of(h), half_inverse = 0.5 / h;
  solid::Sums<4>* const sum_of = sums.data();
  for_pairs<SumsOf<4>::Row>(
      pairs.rows(0, pairs.size()), PairInputs{points.data()},
      [=](const auto& pair, auto& own) __attribute__((always_inline)) {
        using Number = NumberOf<decltype(pair)>;
        const double* const a = pair.self;
        Number b[8], r[2], u, contribution[4];
        gather<0, 8>(pair.rows(), b);
        for (int d = 0; d < 2; ++d) r[d] = b[d] - a[d];
        u = r[0] * r[0] + r[1] * r[1];
        sqrt_in_place(u);
        u = 1.0 - half_inverse * u;
        max_in_place(u, Number{});
        const Number factor = scale * u * u * u, difference = factor * (b[4] - a[4]);
        contribution[0] = factor * ((b[2] - a[2]) * r[0] + (b[3] - a[3]) * r[1]);
        contribution[1] = difference * r[0];
        contribution[2] = difference * r[1];
        contribution[3] = 2.0 * difference;
        for (int n = 0; n < 4; ++n) own.sum[n] += b[5] * contribution[n];
        if (!pair.both) return;
        contribution[0] *= a[5];
        for (int n = 1; n < 3; ++n) contribution[n] *= a[5];
        contribution[3] *= -a[5];
        pair.template give<4>(contribution, [=](Index j) { return sum_of[j].x.data(); });
      },
      [=](std::size_t i, const auto& own) __attribute__((always_inline)) { own.add_to(sum_of[i].x.data()); });
}

/// The same pairs, each stored for both of its particles.
solid::Pairs doubled(const sph::PairList& list) {
  solid::Pairs pairs;
  pairs.part = {0, static_cast<Index>(list.size())};
  for (std::size_t i = 0; i < list.size(); ++i) {
    pairs.alone.push_back(static_cast<Index>(pairs.index.size()));
    for (const Index j : list.of(i)) pairs.index.push_back(j);
    while (pairs.index.size() % n_lanes != 0) pairs.index.push_back(static_cast<Index>(i));
    pairs.offset.push_back(static_cast<Index>(pairs.index.size()));
  }
  return pairs;
}

}  // namespace

int main(int argc, char** argv) {
  const std::size_t n = argc > 1 ? std::stoul(argv[1]) : 100000;
  const auto side = static_cast<std::size_t>(std::sqrt(static_cast<double>(n)));
  const double dx = 1.0 / static_cast<double>(side), volume = dx * dx, h = 1.25 * dx;
  std::mt19937_64 generator(1);
  std::uniform_real_distribution<double> jitter(-0.2 * dx, 0.2 * dx), any(-1.0, 1.0);
  VecArray<2> x, v;
  ScalarArray p, volumes(side * side, volume);
  for (std::size_t j = 0; j < side; ++j)
    for (std::size_t i = 0; i < side; ++i) {
      x.emplace_back((static_cast<double>(i) + 0.5) * dx + jitter(generator),
                     (static_cast<double>(j) + 0.5) * dx + jitter(generator));
      v.emplace_back(any(generator), any(generator));
      p.push_back(any(generator));
    }
  std::vector<Point> points(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) points[i] = {{x[i][0], x[i][1], v[i][0], v[i][1], p[i], volume, 0.0, 0.0}};
  const ScalarArray radius(x.size(), 2.0 * h);
  const auto list = sph::find_pairs<2>(x, x, radius, true);
  const auto n_pairs = static_cast<double>(list.index.size());
  fmt::print(
      "Speed of the solvers' loops over pairs of particles, for {} particles with {:.1f} neighbours, on one thread, in "
      "million directed pairs per CPU second (each pair counts once for each of its two particles). The rows \"floor\" "
      "are the simplest possible loops; the last column divides by the fastest of these\n",
      x.size(), n_pairs / static_cast<double>(x.size()));
  double floor = 0.0;
  const auto report = [&](const char* name, double pairs, double time, bool is_floor) {
    const double rate = 1e-6 * pairs / time;
    if (is_floor) floor = std::max(floor, rate);
    fmt::print("| {} | {:.0f} | {} |\n", name, rate, is_floor ? "" : fmt::format("{:.0f} %", 100.0 * rate / floor));
  };
  fmt::print("| loop | rate | of the floor |\n| --- | --- | --- |\n");
  std::vector<solid::Sums<4>> sums(x.size());
  report("floor: list, one pair at a time", n_pairs, seconds([&] { plain_pass(points, list, h, sums); }), true);
  const solid::Pairs both = doubled(list);
  report("floor: list, four at a time", n_pairs, seconds([&] { lane_pass(points, both, h, sums); }), true);
  solid::Pairs half;
  solid::pair_up<2>(x, x.size(), x.size(), 2.0 * h, 1, {}, {}, half);
  report("floor: half list, four at a time", n_pairs, seconds([&] { lane_pass(points, half, h, sums); }), true);

  // The water's loops, on its own smoothing length.
  fluid::Stencil<2> s;
  const double search = seconds([&] { s = fluid::make_stencil<2>(x, volumes, {}, {}); });
  double in_rows = 0.0;  // without the padding of rows
  for (std::size_t a = 0; a < x.size(); ++a)
    for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k) in_rows += s.other[k] != a ? 1.0 : 0.0;
  report("fluid: search, kernels, moments", in_rows, search, false);
  report("fluid: velocity gradient", in_rows, seconds([&] { fluid::velocity_gradient<2>(s, v); }), false);
  report("fluid: divergence", in_rows, seconds([&] { fluid::divergence<2>(s, v); }), false);
  const auto none = [](std::size_t) { return 0.0; };
  report("fluid: pressure gradient", in_rows,
         seconds([&] { fluid::pressure_gradient<2>(s, p, none, {}, Vec<2>::Zero(), none); }), false);
  PairMatrix matrix;
  report("fluid: Laplacian's matrix", in_rows, seconds([&] { matrix = fluid::laplacian<2>(s, {}); }), false);
  ScalarArray y(p.size());
  report("fluid: matrix pass", in_rows,
         seconds([&] { matrix.apply(std::span<const double>(p), std::span<double>(y)); }), false);

  // The soil's loops, with the margin of its own lists.
  const double soil_h = 1.2 * dx, range = 2.0 * soil_h + 0.2 * dx;
  solid::Neighbourhood<2> around;
  solid::Pairs& pairs = around.pairs;
  const double pairing = seconds([&] { solid::pair_up<2>(x, x.size(), x.size(), range, 1, {}, {}, pairs); });
  double near = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i)
    for (Index m = pairs.offset[i]; m < pairs.offset[i + 1]; ++m)
      if (pairs.index[m] != i && (x[pairs.index[m]] - x[i]).norm() < 2.0 * soil_h) near += 2.0;
  report("solid: pair list", near, pairing, false);
  std::vector<solid::Node<2>> nodes(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    nodes[i].position = x[i];
    nodes[i].velocity = v[i];
    nodes[i].volume = volume;
    nodes[i].density = 1560.0;
    nodes[i].flux = 1e3 * Mat<2>::Identity();
  }
  solid::Kernels kernel;
  solid::Stabilisers stabilisers;
  stabilisers.modulus = 1e6;
  stabilisers.sound_speed = 30.0;
  const VecArray<2> displacement(x.size(), Vec<2>::Zero());
  std::vector<solid::Force<2>> forces(x.size());
  const auto force = [&] {
    solid::internal_force<2>(nodes, around, displacement, x.size(), soil_h, stabilisers, kernel, forces);
  };
  report("solid: force, elastic", near, seconds(force), false);
  for (auto& node : nodes) node.hourglass_level = solid::Node<2>::flows;
  report("solid: force, flowing", near, seconds(force), false);
  report("solid: velocity gradient", near, seconds([&] { solid::velocity_gradient<2>(pairs, kernel, nodes); }), false);
}
