// Small dense systems, tested by their definitions.
#include "common/numerics/dense.hpp"

#include <gtest/gtest.h>
#include <Eigen/Dense>

namespace poretwin {
namespace {

TEST(Dense, SymmetricSystemsAreSolved) {
  Eigen::Matrix3d a;
  a << 4, 1, 0.5, 1, 3, -1, 0.5, -1, 5;
  const Eigen::Vector3d x(1, -2, 3);
  EXPECT_LT((solve_symmetric<3>(a, a * x) - x).norm(), 1e-14);
}

TEST(Dense, EigenvaluesAreToldFromABound) {
  const Eigen::Matrix4d turn = Eigen::Matrix4d(Eigen::Matrix4d::Random().householderQr().householderQ());
  const Eigen::Vector4d values(0.2, 1, 1, 7);
  const Eigen::Matrix4d a = turn * values.asDiagonal() * turn.transpose();
  EXPECT_TRUE(all_eigenvalues_above<4>(a, 0.199));
  EXPECT_FALSE(all_eigenvalues_above<4>(a, 0.201));
  EXPECT_FALSE(all_eigenvalues_above<4>(a, 2.0)) << "of either sign";
  EXPECT_FALSE(all_eigenvalues_above<4>(-a, 0.0));
}

TEST(Dense, LeastSquaresAreNotLedAstrayByColumnsThatSayNothingNew) {
  Eigen::MatrixXd a(4, 3);
  a << 1, 0, 1, 0, 1, 1, 1, 1, 2, 2, 0, 2;  // the third column is the sum of the others
  a.col(2) += 1e-12 * Eigen::Vector4d(1, -1, 2, 0);
  const Eigen::VectorXd b = a.leftCols(2) * Eigen::Vector2d(1, 2) + 1e-6 * Eigen::Vector4d(1, 1, -1, 0);
  for (const Eigen::VectorXd& x : {least_squares(a, b, 1e-9), shortest_solution(a.leftCols(2), b)}) {
    EXPECT_LT(x.norm(), 3.0) << "1e6 with the third";
    EXPECT_LT((a.leftCols(x.size()) * x - b).norm(), 1e-5);
  }
  Eigen::MatrixXd two = a.leftCols(2);
  EXPECT_LT((two.transpose() * (two * least_squares(two, b, 1e-9) - b)).norm(), 1e-14);
}

TEST(Dense, TrianglesOfPartsHaveTheLeastSquaresOfTheWhole) {
  const Eigen::MatrixXd a = Eigen::MatrixXd::Random(9, 3), first = upper_triangle(a.topRows(7)),
                        rest = upper_triangle(a.bottomRows(2));
  EXPECT_EQ(first.rows(), 3);
  EXPECT_EQ(rest.rows(), 2) << "fewer rows than columns";
  EXPECT_EQ(upper_triangle(Eigen::MatrixXd(0, 3)).rows(), 0);
  Eigen::MatrixXd both(5, 3);
  both << first, rest;
  EXPECT_LT((both.transpose() * both - a.transpose() * a).norm(), 1e-14);
}

}  // namespace
}  // namespace poretwin
