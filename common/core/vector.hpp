// Small vectors and tensors, and aliases for arrays of them. A set of particles consists of such plain arrays.
#pragma once

#include <Eigen/Core>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace poretwin {

template <int D>
using Vec = Eigen::Matrix<double, D, 1>;
template <int D>
using Mat = Eigen::Matrix<double, D, D>;
template <int D>
using VecArray = std::vector<Vec<D>>;
template <int D>
using MatArray = std::vector<Mat<D>>;
using ScalarArray = std::vector<double>;
using Index = std::uint32_t;

}  // namespace poretwin
