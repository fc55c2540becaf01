// Steps in time, of the length that the error allows: the L-stable method of second order in two implicit stages of
// Alexander (1977), each solved by Newton's iteration.
#pragma once

#include "common/case/case.hpp"
#include "common/coupling/exchange.hpp"
#include "common/numerics/ilu0.hpp"
#include "pore_solver/flow.hpp"
#include "pore_solver/network.hpp"
#include "pore_solver/state.hpp"

#include <memory>
#include <vector>

namespace poretwin::pore {

class Stepper {
 public:
  Stepper(const Case& scene, const Network& network);

  /// The state at time zero.
  [[nodiscard]] State first_state(const Case& scene);
  /// The longest step [s] that its error and the corners of what the boundaries prescribe allow next.
  [[nodiscard]] double proposal(const State& state) const;
  /// One step. Where its error is too large, or no solution is found, the state stays as it is and a shorter step is
  /// suggested. soil: where it moves; null: rigid.
  coupling::Outcome step(double interval, const Skeleton* soil, State& state);

  /// In which the pressure of the cell that drains fastest would follow its neighbours', s: a first step of soil that
  /// moves.
  [[nodiscard]] double time_of_a_cell(const Skeleton& soil) const;

  /// The flow model with the state's variables.
  [[nodiscard]] const FlowModel& flow(const State& state) {
    flow_->set(state.variable);
    return *flow_;
  }
  /// The boundary of each segment, index in `boundary`.
  [[nodiscard]] std::size_t boundary_of(std::size_t segment) const { return boundary_of_[segment]; }
  struct Along {
    std::size_t face = Segment::none, rain = Segment::none;  ///< what a boundary stands for
    std::unique_ptr<PoreBoundary> boundary;
  };
  [[nodiscard]] const std::vector<Along>& boundaries() const { return boundaries_; }
  /// Volume of all pores, m3 (2D: m2).
  [[nodiscard]] double pores() const { return pores_; }

 private:
  struct Attempt {
    bool solved = false;
    double error = 0.0;         ///< of the water content, pore volumes
    double head_error = 0.0;    ///< m, of the head that the skeleton bears, mean over the soil
    double largest_head = 0.0;  ///< m, that it bears
  };
  /// A step of this length from the state, which it leaves as it is.
  Attempt attempt(double interval, const Skeleton* soil, State& state);
  /// Soil on points does not answer to pressures that alternate from point to point, so that water which nothing drains
  /// would find no pressure with which its pores fit. A flow T V / (4 M) d(p_a - p_b)/dt between neighbours, of second
  /// order in their distance, takes what alternates from the one to the other (Aguilar et al. 2008).
  void link_full_points(const Skeleton& soil, const State& state);
  /// Mean over the soil of the head [m] by which an error of each point's content [m3, 2D: m2] changes what the
  /// skeleton bears at the step's end, what flows meanwhile counted, and the largest head borne.
  std::pair<double, double> borne_error(std::span<const double> content_error);
  /// Takes the pores at a share of the step.
  void see(const Skeleton& soil, double share);
  /// Finds the variables at which water(u) = base + interval * net(u), from those there are on; false where it does
  /// not.
  bool solve(double interval, State& state);
  /// x of the matrix for a right side, to a share of its norm; returns the iterations.
  double solve_linear(std::span<const double> right, double tolerance, ScalarArray& x) const;
  /// Flows and, where asked to, the matrix of `interval` times their derivatives; the residual of each point.
  void balance(double interval, const State& state, bool with_matrix);
  void begin(const StepTimes& times);
  void accept(double interval, State& state);
  [[nodiscard]] double first_interval(const Case& scene, const State& state);

  const Network& network_;
  double spacing_;  ///< m
  std::unique_ptr<FlowModel> flow_;
  std::vector<Along> boundaries_;
  std::vector<std::size_t> boundary_of_;
  double pores_ = 0.0;
  SparseRows matrix_;
  std::vector<std::pair<Index, Index>> places_;  ///< of each link: of (a, b) and (b, a) in the matrix
  // Of the stage under way.
  ScalarArray variable_, base_, residual_, net_, link_flow_, inflow_;
  ScalarArray mean_net_, mean_inflow_;  ///< over the step
  double give_ = 0.0;                   ///< m2 (2D: m), of all pores for each metre of head
  /// Of each link between full points of soil that moves, m2 (2D: m): volume of water that it passes for each metre by
  /// which the heads that the skeleton bears come to differ.
  ScalarArray evens_;
  ScalarArray passed_, before_;  ///< m3 (2D: m2), what leaves each point that way as heads rise from zero; at the start
  double carried_ = 0.0;         ///< sum of what the step's start has of water that its variables have not, m3 (2D: m2)
  std::vector<char> stopped_;
};

}  // namespace poretwin::pore
