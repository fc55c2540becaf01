// Passes through one window, repeated until the soil moves as the fluid predicted: interface quasi-Newton (IQN-ILS;
// Degroote, Bathe & Vierendeels 2009) on the skeleton's motion. The fluid's prediction is the preconditioner: each pass
// solves for the departure from the motion that the solid found in the last pass, at which the force is known.
#pragma once

#include "common/numerics/dense.hpp"
#include "common/particles/tiling.hpp"
#include "fluid_solver/exchange/soil_view.hpp"
#include "fluid_solver/numerics/exchange.hpp"

#include <optional>

namespace poretwin::fluid {

template <int D>
class Passes {
 public:
  /// Called before a pass. Extrapolates view.found_velocity and view.found_force, which the solid found in the last
  /// pass, to the state from which this pass departs. Removes the fluid's own force of the last pass from found_force.
  /// tiling: of the ranks that share the water, all of which call this; null: this process has all particles.
  void begin(unsigned pass, SoilView<D>& view, const Tiling<D>* tiling = nullptr) {
    const Domain domain = tiling != nullptr ? Domain(tiling->ranks(), 0, 0) : Domain();
    if (pass == 0 || !domain.any(view.found_velocity.is_allocated()) || domain.any(predicted_.size() != view.size())) {
      columns_ = {};
      last_.reset();
      view.found_velocity = view.found_force = {};
      found_ = {};
      pressure_ = {};
      return;
    }
    const auto n = static_cast<Eigen::Index>(view.size() * D);
    Pass now{Eigen::VectorXd::Zero(n), Eigen::VectorXd::Zero(n), Eigen::VectorXd::Zero(n)};
    for (std::size_t a = 0; a < view.size(); ++a) {
      if (view.mask[a] <= 0.0) continue;
      const auto at = static_cast<Eigen::Index>(a * D);
      now.motion.template segment<D>(at) = view.found_velocity[a];
      now.force.template segment<D>(at) = view.found_force[a] - given_[a];
      now.departure.template segment<D>(at) = view.found_velocity[a] - predicted_[a];
    }
    found_ = view.found_velocity;
    if (last_)
      columns_.push_back({now.motion - last_->motion, now.force - last_->force, now.departure - last_->departure});
    last_ = now;
    if (columns_.size() > exchange::most_changes) columns_.erase(columns_.begin());
    if (!columns_.empty()) {
      Eigen::MatrixXd departures(n, static_cast<Eigen::Index>(columns_.size()));
      for (std::size_t k = 0; k < columns_.size(); ++k)
        departures.col(static_cast<Eigen::Index>(k)) = columns_[k].departure;
      const Eigen::VectorXd share = shares_of(std::move(departures), now.departure, tiling);
      for (std::size_t k = 0; k < columns_.size(); ++k) {
        now.motion -= share[static_cast<Eigen::Index>(k)] * columns_[k].motion;
        now.force -= share[static_cast<Eigen::Index>(k)] * columns_[k].force;
      }
    }
    for (std::size_t a = 0; a < view.size(); ++a) {
      const auto at = static_cast<Eigen::Index>(a * D);
      view.found_velocity.set(a, now.motion.template segment<D>(at));
      view.found_force.set(a, now.force.template segment<D>(at));
    }
  }

  /// Called after a pass. predicted: predicted motion of the skeleton [m/s]; given: force of pressure and drag on it
  /// [N/m3].
  void end(const ScalarArray& pressure, const OrZero<Vec<D>>& predicted, const OrZero<Vec<D>>& given) {
    pressure_ = pressure;
    predicted_.assign(predicted.begin(), predicted.end());
    given_ = given;
  }

  /// Pressure at the end of the last pass [Pa]; empty before the first pass.
  [[nodiscard]] const ScalarArray& pressure() const { return pressure_; }
  /// Velocity of the skeleton that the last pass predicted [m/s].
  [[nodiscard]] const VecArray<D>& predicted() const { return predicted_; }
  /// Velocity of the skeleton that the solid found in the last pass [m/s].
  [[nodiscard]] const OrZero<Vec<D>>& found() const { return found_; }

 private:
  struct Pass {
    Eigen::VectorXd motion, force, departure;
  };
  /// The shares x of the changes for which |A x - b| is least, over the rows of all ranks. A: departures of the changes
  /// [n * D rows], b: this pass's departure. Each rank reduces its own rows to a triangle, and all solve for what these
  /// have in common (TSQR; Demmel, Grigori, Hoemmen & Langou 2012).
  static Eigen::VectorXd shares_of(Eigen::MatrixXd a, Eigen::VectorXd b, const Tiling<D>* tiling) {
    if (tiling != nullptr) {
      using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
      const Eigen::Index n = a.cols();
      Rows both(a.rows(), n + 1);
      both << a, b;
      const Rows own = upper_triangle(both);
      const ScalarArray all = tiling->gather_numbers(ScalarArray(own.data(), own.data() + own.size()));
      const Eigen::Map<const Rows> rows(all.data(), static_cast<Eigen::Index>(all.size()) / (n + 1), n + 1);
      a = rows.leftCols(n);
      b = rows.col(n);
    }
    return least_squares(a, b, exchange::independent_change);
  }

  std::vector<Pass> columns_;  ///< changes from pass to pass
  std::optional<Pass> last_;
  ScalarArray pressure_;
  VecArray<D> predicted_;
  OrZero<Vec<D>> given_, found_;
};

}  // namespace poretwin::fluid
