// What the tests of soil in beds share: turned points, and a Poisson equation with an exact solution.
#pragma once

#include "common/case/case.hpp"
#include "common/core/vector.hpp"

#include <Eigen/Sparse>

#include <cmath>
#include <vector>

namespace poretwin::test {

/// A point turned around the origin by an angle [degrees].
inline Point3 turned(double x, double y, double angle) {
  const double c = std::cos(angle * M_PI / 180.0), s = std::sin(angle * M_PI / 180.0);
  return {c * x - s * y, s * x + c * y, 0.0};
}

/// Conductivities of 1 along beds that rise at an angle [degrees], and 1 / ratio across them.
inline Mat<2> bedded_tensor(double angle, double ratio) {
  const Vec<2> n = turned(0.0, 1.0, angle).head<2>();
  return Mat<2>::Identity() - (1.0 - 1.0 / ratio) * n * n.transpose();
}

/// -div(K grad u) = f on points of a unit square, with u = cos(pi x) cos(pi y) prescribed along a rim.
struct PoissonsEquation {
  /// The flow from a point to another one is `conductance` times the difference of u.
  struct Link {
    std::size_t from, to;
    double conductance;
  };

  Mat<2> K;
  double rim;          ///< width
  VecArray<2> x;       ///< [n]
  ScalarArray volume;  ///< [n]

  [[nodiscard]] bool on_rim(std::size_t a) const { return (x[a] - Vec<2>(0.5, 0.5)).cwiseAbs().maxCoeff() > 0.5 - rim; }
  [[nodiscard]] double exact(std::size_t a) const { return std::cos(M_PI * x[a].x()) * std::cos(M_PI * x[a].y()); }

  /// Root mean square error of u where each point off the rim balances its links with the source.
  [[nodiscard]] double error(const std::vector<Link>& links) const {
    const auto n = static_cast<Eigen::Index>(x.size());
    std::vector<Eigen::Triplet<double>> entries;
    for (const auto& [from, to, conductance] : links) {
      if (on_rim(from)) continue;
      const auto row = static_cast<Eigen::Index>(from);
      entries.emplace_back(row, row, conductance);
      entries.emplace_back(row, static_cast<Eigen::Index>(to), -conductance);
    }
    Eigen::VectorXd b(n), u(n);
    for (std::size_t a = 0; a < x.size(); ++a) {
      const auto row = static_cast<Eigen::Index>(a);
      u[row] = exact(a);
      const double mixed = std::sin(M_PI * x[a].x()) * std::sin(M_PI * x[a].y());
      b[row] = volume[a] * M_PI * M_PI * (K.trace() * u[row] - 2.0 * K(0, 1) * mixed);
      if (!on_rim(a)) continue;
      entries.emplace_back(row, row, 1.0);
      b[row] = u[row];
    }
    Eigen::SparseMatrix<double> matrix(n, n);
    matrix.setFromTriplets(entries.begin(), entries.end());
    const Eigen::VectorXd solved = Eigen::SparseLU<Eigen::SparseMatrix<double>>(matrix).solve(b);
    return (solved - u).norm() / std::sqrt(static_cast<double>(n));
  }
};

}  // namespace poretwin::test
