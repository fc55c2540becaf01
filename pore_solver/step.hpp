// Time steps whose length the error controls, with the L-stable second-order method of Alexander (1977). Each of its
// two implicit stages is solved by Newton's iteration.
#pragma once

#include "common/case/case.hpp"
#include "common/coupling/exchange.hpp"
#include "common/numerics/ilu0.hpp"
#include "pore_solver/flow.hpp"
#include "pore_solver/network.hpp"
#include "pore_solver/state.hpp"

#include <memory>
#include <optional>
#include <vector>

namespace poretwin::pore {

class Stepper {
 public:
  /// give_up: asked between iterations; where it says yes, a step ends without a result.
  Stepper(const Case& scene, const Network& network, bool (*give_up)());

  /// The state at time zero.
  [[nodiscard]] State first_state(const Case& scene);
  /// The longest next step [s] that the error and the next corner of prescribed boundary values allow.
  [[nodiscard]] double proposal(const State& state) const;
  /// Advances the state by one step. If the error is too large, no solution is found or the step is given up, the state
  /// does not change, and the result suggests a shorter step. soil: the soil that moves; null for rigid soil.
  coupling::Outcome step(double interval, const Skeleton* soil, State& state);

  /// Time [s] in which the cell that drains fastest adapts its pressure to its neighbours'. It is used for the first
  /// step in soil that moves.
  [[nodiscard]] double time_of_a_cell(const Skeleton& soil) const;

  /// The flow model with the state's variables set.
  [[nodiscard]] const FlowModel& flow(const State& state) {
    flow_->set(state.variable);
    return *flow_;
  }
  /// Index in boundaries() of a segment's boundary.
  [[nodiscard]] std::size_t boundary_of(std::size_t segment) const { return boundary_of_[segment]; }
  /// Boundaries of single faces come first: the boundary of a face without rain has the face's index.
  struct Along {
    std::size_t face = Segment::none, rain = Segment::none;  ///< the boundary's face and rain
    std::unique_ptr<PoreBoundary> boundary;
    std::size_t well = Segment::none;  ///< the boundary's well
  };
  [[nodiscard]] const std::vector<Along>& boundaries() const { return boundaries_; }
  /// Index in State::level of the level of boundary b, which follows from a balance; empty for another boundary.
  [[nodiscard]] std::optional<std::size_t> level_of(std::size_t b) const {
    for (std::size_t k = 0; k < levels_.size(); ++k)
      if (levels_[k].boundary == b) return k;
    return std::nullopt;
  }
  /// Volume of all pores [m3, 2D: m2].
  [[nodiscard]] double pores() const { return pores_; }

 private:
  struct Attempt {
    bool solved = false;
    double error = 0.0;         ///< error of the water content, over the volume of the pores; or, where that is larger,
                                ///< of a basin's level, over its depth
    double head_error = 0.0;    ///< m, mean over the soil of the error of the head that the skeleton bears
    double largest_head = 0.0;  ///< m, largest head that the skeleton bears
  };
  /// Computes a step of length `interval`. Of `state` only the counters change.
  Attempt attempt(double interval, const Skeleton* soil, State& state);
  /// Sets the links' resistance to pressures that alternate from point to point. Soil on points does not respond to
  /// such pressures, so that undrained water would find no pressure for which it fits its pores. Neighbours in full
  /// soil therefore exchange a flow T L^2 / (4 M) d(p_a - p_b)/dt, of second order in their distance (Aguilar et al.
  /// 2008). T is the transmissibility, M the constrained modulus, and L the width of a cell of volume V: V^(1/2) in 2D,
  /// V^(1/3) in 3D.
  void link_full_points(const Skeleton& soil, const State& state);
  /// Volume [m3, 2D: m2] that link i has passed from a to b by this exchange as heads rose from zero to the present
  /// ones.
  [[nodiscard]] Flow passed_since_zero(std::size_t i) const;
  /// content_error: errors of the points' contents [m3, 2D: m2]. Returns the error that they cause, with the resulting
  /// flows, in the head [m] that the skeleton bears at the step's end, as mean over the soil; and the largest head that
  /// the skeleton bears.
  std::pair<double, double> borne_error(std::span<const double> content_error);
  /// Sets the pores to their volumes at a fraction `share` of the step.
  void see(const Skeleton& soil, double share);
  /// Solves a stage by Newton's iteration from the present variables u. The water in each cell is its content without
  /// this stage's flow (base_) plus interval [s] times its net inflow at u (net_). Returns whether it converges.
  bool solve(double interval, State& state);
  /// Solves the matrix for x, to a residual of `tolerance` times the norm of `right`. Returns the number of iterations.
  double solve_linear(std::span<const double> right, double tolerance, ScalarArray& x) const;
  /// Computes flows and the residual of each point; if with_matrix, also the residuals' derivatives.
  void balance(double interval, const State& state, bool with_matrix);
  void begin(const StepTimes& times);
  void accept(double interval, State& state);
  [[nodiscard]] double first_interval(const Case& scene, const State& state);

  const Network& network_;
  bool (*give_up_)();
  double spacing_;  ///< m
  bool space_;      ///< whether the case is in 3D
  std::unique_ptr<FlowModel> flow_;
  std::vector<Along> boundaries_;
  std::vector<std::size_t> boundary_of_;
  double pores_ = 0.0;
  SparseRows matrix_;
  std::vector<std::pair<Index, Index>> places_;  ///< for each link, the places of (a, b) and (b, a) in the matrix
  /// A boundary whose level follows from a balance: a well that pumps a discharge, or a basin. The level is an
  /// additional unknown, after those of the points.
  struct OwnLevel {
    std::size_t boundary = 0;
    std::vector<std::size_t> segments;
    std::vector<std::pair<Index, Index>> places;  ///< for each segment, the places of (point, level), (level, point)
    LevelRange range;
    double level = 0.0;   ///< m
    bool at_end = false;  ///< the balance closes at no level of the range: the well is empty, or the basin is or spills
    double base = 0.0;    ///< m3 (2D: m2), water of a basin without what comes and goes in the stage
    BasinRates rates, mean_rates;  ///< of a basin: of the stage, and means over the step
  };
  [[nodiscard]] PoreBoundary& boundary(const OwnLevel& own) const { return *boundaries_[own.boundary].boundary; }
  /// Finds the levels that follow from a balance, for the present variables.
  void find_levels();
  /// Flow into the soil [m3/s, 2D: m2/s] through the segments of such a boundary if its water stands at `level` [m].
  [[nodiscard]] double into_soil(const OwnLevel& own, double level) const;
  /// Begins a stage of the step, whose end is at the fraction `share` of the step.
  void begin_stage(const State& state, double interval, double share);
  /// The rates of the basins in the stage that has been solved.
  void find_rates();
  /// Depth [m] against which the error of a basin's level is measured.
  [[nodiscard]] double depth_scale(const OwnLevel& own) const;

  std::vector<OwnLevel> levels_;
  // Quantities of the present stage.
  ScalarArray variable_, base_, residual_, net_, link_flow_, inflow_;
  ScalarArray mean_net_, mean_inflow_;  ///< means over the step
  double give_ = 0.0;                   ///< m2 (2D: m), increase of the total pore volume per metre of head
  /// For each link between full points of soil that moves [m2, 2D: m]: volume of water that the link passes per metre
  /// of change in the difference between the two heads that the skeleton bears.
  ScalarArray evens_;
  ScalarArray passed_, before_;  ///< m3 (2D: m2), volume that has left each point through these links as heads rose
                                 ///< from zero: now, and at the step's start
  double carried_ = 0.0;         ///< m3 (2D: m2), sum over the points of the difference between stored water and the
                                 ///< variables' water at the step's start
  std::vector<char> stopped_;
};

}  // namespace poretwin::pore
