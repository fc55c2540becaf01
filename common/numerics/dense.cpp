#include "common/numerics/dense.hpp"

#include <Eigen/Dense>

#include <algorithm>

namespace poretwin {

template <int N>
Eigen::Matrix<double, N, 1> solve_symmetric(const Eigen::Matrix<double, N, N>& a,
                                            const Eigen::Matrix<double, N, 1>& b) {
  return a.ldlt().solve(b);
}

template <int N>
bool all_eigenvalues_above(const Eigen::Matrix<double, N, N>& a, double bound) {
  const Eigen::Matrix<double, N, N> departure = a - bound * Eigen::Matrix<double, N, N>::Identity();
  return departure.ldlt().vectorD().minCoeff() > 0.0;
}

Eigen::VectorXd least_squares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, double independent) {
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(a);
  qr.setThreshold(independent);
  if (qr.rank() == a.cols()) return qr.solve(b);  // with full rank, the threshold does not matter
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> complete;
  complete.setThreshold(independent);
  return complete.compute(a).solve(b);
}

Eigen::MatrixXd upper_triangle(const Eigen::MatrixXd& a) {
  if (a.rows() == 0) return a;
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(a);
  return qr.matrixQR().topRows(std::min(a.rows(), a.cols())).triangularView<Eigen::Upper>();
}

Eigen::VectorXd shortest_solution(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  return a.completeOrthogonalDecomposition().solve(b);
}

template Eigen::Vector3d solve_symmetric<3>(const Eigen::Matrix3d&, const Eigen::Vector3d&);
template Eigen::Vector4d solve_symmetric<4>(const Eigen::Matrix4d&, const Eigen::Vector4d&);
template bool all_eigenvalues_above<3>(const Eigen::Matrix3d&, double);
template bool all_eigenvalues_above<4>(const Eigen::Matrix4d&, double);

}  // namespace poretwin
