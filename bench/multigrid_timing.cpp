// Iterations and time of the pressure solve against the number of particles, with the diagonal, aggregates or multigrid
// as preconditioner, in a tank and a Darcy column of disordered particles; costs of a matrix product and of a cycle per
// particle. Not a test: run by hand.
#include "common/numerics/aggregates.hpp"
#include "common/numerics/multigrid.hpp"
#include "fluid_solver/discretisation/operators.hpp"

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <random>

using namespace poretwin;
using namespace poretwin::fluid;

namespace {

double cpu() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// A unit square (or cube) of about n particles between walls. Tank: prescribed pressure in its top rows. Layered: two
/// soils whose conductivities differ by a factor of 1e3.
template <int D>
void measure(std::size_t n, bool layered) {
  const int side = static_cast<int>(std::lround(std::pow(static_cast<double>(n), 1.0 / D)));
  const double dx = 1.0 / side;
  std::mt19937_64 generator(1);
  std::uniform_real_distribution<double> jitter(-0.2 * dx, 0.2 * dx);
  VecArray<D> x;
  for (int k = 0; k < (D == 3 ? side : 1); ++k)
    for (int j = 0; j < side; ++j)
      for (int i = 0; i < side; ++i) {
        Vec<D> p;
        const int at[3] = {i, j, k};
        for (int d = 0; d < D; ++d) p[d] = (at[d] + 0.5) * dx + jitter(generator);
        x.push_back(p);
      }
  const ScalarArray volume(x.size(), std::pow(dx, D));
  const double begin = cpu();
  const auto s = make_stencil<D>(x, volume, std::span<const Buffer<D>>(), {});
  const double stencil = cpu() - begin;
  const auto mobility = [&](std::size_t a) { return layered && x[a][0] > 0.5 ? 1e-3 : 1.0; };
  ScalarArray mobilities(x.size());
  for (std::size_t a = 0; a < x.size(); ++a) mobilities[a] = mobility(a);
  PairMatrix A = laplacian<D>(s, mobilities);
  ScalarArray b(x.size()), known(x.size(), 0.0);
  std::uniform_real_distribution<double> noise(-1.0, 1.0);
  for (std::size_t a = 0; a < x.size(); ++a) {
    b[a] = s.volume[a] * noise(generator);
    if (x[a][D - 1] > 1.0 - 1.2 * dx) {
      b[a] = 0.0;
      A.diagonal[a] *= 1e3;
    }
  }
  const auto apply = [&](std::span<const double> u, std::span<double> y) { A.apply(u, y); };
  ScalarArray p(x.size(), 0.0);
  const auto by_diagonal = [&](std::span<const double> r, std::span<double> z) {
    for (std::size_t a = 0; a < r.size(); ++a) z[a] = r[a] / A.diagonal[a];
  };
  double t = cpu();
  const auto plain = conjugate_gradients(Domain(), apply, by_diagonal, b, p, 1e-4 * Domain().norm(b), 5000);
  const double diagonal = cpu() - t;
  std::fill(p.begin(), p.end(), 0.0);
  t = cpu();
  Aggregates<D> aggregates(x, dx * std::pow(static_cast<double>(x.size()), 0.5 / D),
                           [&](std::size_t a) { return x[a][D - 1] <= 1.0 - 1.2 * dx; });
  aggregates.factorise([&](std::size_t a, const auto& add) {
    add(a, A.diagonal[a]);
    for (std::size_t k = A.begin(a); k < A.end(a); ++k) add(A.column(a, k), -static_cast<double>(A.weight[k]));
  });
  const auto corrected = conjugate_gradients(
      Domain(), apply,
      [&](std::span<const double> r, std::span<double> z) {
        by_diagonal(r, z);
        aggregates.template correct<1>(r, z);
      },
      b, p, 1e-4 * Domain().norm(b), 5000);
  const double in_aggregates = cpu() - t;
  std::fill(p.begin(), p.end(), 0.0);
  t = cpu();
  Multigrid multigrid(A);
  const double build = cpu() - t;
  const auto quick = conjugate_gradients(
      Domain(), apply, [&](std::span<const double> r, std::span<double> z) { multigrid.cycle(r, z); }, b, p, 1e-4 * Domain().norm(b), 500);
  const double whole = cpu() - t;
  const auto nanoseconds = [&](const auto& pass) {  // per particle; the shortest of five rounds
    const int passes = static_cast<int>(std::max<std::size_t>(2, 1000000 / x.size()));
    double least = 1e300;
    for (int round = 0; round < 5; ++round) {
      const double start = cpu();
      for (int i = 0; i < passes; ++i) pass();
      least = std::min(least, (cpu() - start) / passes);
    }
    return 1e9 * least / static_cast<double>(x.size());
  };
  ScalarArray q(x.size());
  const double product = nanoseconds([&] { A.apply(p, q); }), cycle = nanoseconds([&] { multigrid.cycle(b, q); });
  std::printf("| %dD %s | %zu | %.3f | %d | %.3f | %d | %.3f | %d | %.3f | %.3f | %.1f | %.1f |\n", D,
              layered ? "layered" : "tank", x.size(), stencil, plain.iterations, diagonal, corrected.iterations,
              in_aggregates, quick.iterations, whole, build, product, cycle);
  std::fflush(stdout);
}

}  // namespace

int main() {
  std::puts(
      "Times in CPU seconds: to build the stencil; to solve for the pressure to a tolerance of 1e-4 with the matrix's "
      "diagonal as preconditioner, with aggregates, and by multigrid (the time to build aggregates or multigrid "
      "included); to build multigrid (\"building\"). The last two columns give nanoseconds per particle for one product "
      "with the matrix and for one multigrid cycle. The points are in disorder; one run each");
  std::puts(
      "| scene | particles | stencil | on the diagonal: iterations | s | with aggregates | s | by multigrid: cycles | "
      "s | "
      "building | product "
      "| cycle |");
  std::puts("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |");
  for (const bool layered : {false, true})
    for (const std::size_t n : {1000, 10000, 100000, 1000000}) measure<2>(n, layered);
  for (const std::size_t n : {1000, 10000, 100000}) measure<3>(n, false);
}
