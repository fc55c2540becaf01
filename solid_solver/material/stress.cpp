#include "solid_solver/material/stress.hpp"

#include <Eigen/Eigenvalues>

namespace poretwin::solid {

std::pair<double, double> extreme_stresses(const Tensor& t) {
  Eigen::SelfAdjointEigenSolver<Mat<3>> solver;
  solver.computeDirect(matrix_of<3>(t), Eigen::EigenvaluesOnly);
  return {solver.eigenvalues()[2], solver.eigenvalues()[0]};
}

}  // namespace poretwin::solid
