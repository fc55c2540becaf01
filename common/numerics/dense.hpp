// Small dense systems. They are compiled in one place, since instantiating Eigen's decompositions takes seconds.
#pragma once

#include <Eigen/Core>

namespace poretwin {

/// x of A x = b by Cholesky's L D L^T with pivots. A: symmetric positive definite, N = 3 or 4 rows.
template <int N>
Eigen::Matrix<double, N, 1> solve_symmetric(const Eigen::Matrix<double, N, N>& a, const Eigen::Matrix<double, N, 1>& b);

/// Whether all eigenvalues of a symmetric matrix of N = 3 or 4 rows exceed a bound. This follows from the inertia of A
/// - bound I (Sylvester's law).
template <int N>
bool all_eigenvalues_above(const Eigen::Matrix<double, N, N>& a, double bound);

/// The shortest x that minimises |A x - b|, by Householder's QR with pivots. Pivots below `independent` times the
/// largest pivot count as zero.
Eigen::VectorXd least_squares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, double independent);

/// R of A = Q R, by Householder's QR: of as many rows as A has, at most as many as it has columns.
Eigen::MatrixXd upper_triangle(const Eigen::MatrixXd& a);

/// The shortest x that minimises |A x - b|, by a complete orthogonal decomposition.
Eigen::VectorXd shortest_solution(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);

}  // namespace poretwin
