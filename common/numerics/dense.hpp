// Small dense systems. Compiled once: decompositions take the compiler seconds wherever they are instantiated.
#pragma once

#include <Eigen/Core>

namespace poretwin {

/// x of A x = b by Cholesky's L D L^T with pivots. A: symmetric, positive, N = 3 or 4 rows.
template <int N>
Eigen::Matrix<double, N, 1> solve_symmetric(const Eigen::Matrix<double, N, N>& a, const Eigen::Matrix<double, N, 1>& b);

/// Are all eigenvalues of a symmetric matrix of N = 3 or 4 rows above a bound? By the inertia of A - bound I
/// (Sylvester's law).
template <int N>
bool all_eigenvalues_above(const Eigen::Matrix<double, N, N>& a, double bound);

/// The shortest x for which |A x - b| is least, by Householder's QR with pivots. What the columns of A say beyond one
/// another counts only where it is more than a share `independent` of the largest pivot.
Eigen::VectorXd least_squares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, double independent);

/// The shortest x for which |A x - b| is least, by a complete orthogonal decomposition.
Eigen::VectorXd shortest_solution(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);

}  // namespace poretwin
