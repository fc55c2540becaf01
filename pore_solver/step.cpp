#include "pore_solver/step.hpp"

#include "common/geometry/shapes.hpp"
#include "common/numerics/csr.hpp"
#include "pore_solver/numerics/basins.hpp"
#include "pore_solver/numerics/steps.hpp"
#include "pore_solver/numerics/wells.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace poretwin::pore {

Stepper::Stepper(const Case& scene, const Network& network, bool (*give_up)())
    : network_(network),
      give_up_(give_up),
      spacing_(scene.fluid.particle_spacing),
      space_(scene.general.dimension == 3),
      flow_(make_flow_model(scene, network)) {
  // Boundaries of single faces and rains come first, so that their indices stay the same when a network is made anew.
  for (std::size_t f = 0; f < scene.water_faces.size(); ++f)
    boundaries_.push_back({f, Segment::none, make_boundary(scene, f, Segment::none)});
  for (std::size_t r = 0; r < scene.rains.size(); ++r)
    boundaries_.push_back({Segment::none, r, make_boundary(scene, Segment::none, r)});
  for (std::size_t w = 0; w < scene.wells.size(); ++w)
    boundaries_.push_back({Segment::none, Segment::none, make_well(scene.wells[w]), w});
  for (const auto& segment : network.segments) {
    auto found = std::find_if(boundaries_.begin(), boundaries_.end(), [&](const Along& along) {
      return along.face == segment.face && along.rain == segment.rain && along.well == segment.well;
    });
    if (found == boundaries_.end()) {
      boundaries_.push_back({segment.face, segment.rain, make_boundary(scene, segment.face, segment.rain)});
      found = boundaries_.end() - 1;
    }
    boundary_of_.push_back(static_cast<std::size_t>(found - boundaries_.begin()));
  }
  for (const double volume : flow_->pores().volume) pores_ += volume;
  std::vector<std::pair<Index, Index>> entries;
  for (const auto& link : network.links) {
    entries.emplace_back(link.a, link.b);
    entries.emplace_back(link.b, link.a);
  }
  for (std::size_t b = 0; b < boundaries_.size(); ++b) {
    if (!boundaries_[b].boundary->finds_level()) continue;
    OwnLevel own;
    own.boundary = b;
    double low = HUGE_VAL, high = -HUGE_VAL;
    const auto row = static_cast<Index>(network.size() + levels_.size());
    for (std::size_t i = 0; i < network.segments.size(); ++i) {
      const Segment& segment = network.segments[i];
      if (boundary_of_[i] != b) continue;
      own.segments.push_back(i);
      low = std::min(low, segment.low);
      high = std::max(high, segment.high);
      entries.emplace_back(segment.point, row);
      entries.emplace_back(row, segment.point);
    }
    own.range = boundaries_[b].boundary->levels(low, high);
    own.level = own.range.first;
    levels_.push_back(std::move(own));
  }
  matrix_ = SparseRows(network.size() + levels_.size(), std::move(entries));
  for (std::size_t k = 0; k < levels_.size(); ++k)
    for (const std::size_t i : levels_[k].segments) {
      const auto row = static_cast<Index>(network.size() + k);
      const Index point = network.segments[i].point;
      levels_[k].places.emplace_back(matrix_.place(point, row), matrix_.place(row, point));
    }
  for (const auto& link : network.links)
    places_.emplace_back(matrix_.place(link.a, link.b), matrix_.place(link.b, link.a));
  residual_.resize(network.size() + levels_.size());
  net_.resize(network.size());
  link_flow_.resize(network.links.size());
  inflow_.resize(network.segments.size());
  evens_.assign(network.links.size(), 0.0);
  for (auto* volume : {&passed_, &before_}) volume->assign(network.size(), 0.0);
}

State Stepper::first_state(const Case& scene) {
  State state;
  const auto& f = scene.fluid;
  for (std::size_t a = 0; a < network_.size(); ++a) {
    const auto point = static_cast<Index>(a);
    const double z = network_.elevation[a];
    const bool wet = std::any_of(f.regions.begin(), f.regions.end(), [&](const Shape& region) {
      return contains(region, network_.position[a], scene.general.dimension);
    });
    // Without a head or a water table in the case, soil without capillarity is dry, however low it lies.
    const double head = f.initial_pressure_head ? f.initial_pressure_head->at(z)
                        : f.initial_water_table ? *f.initial_water_table - z
                                                : -HUGE_VAL;
    state.variable.push_back(wet ? flow_->full(point) : flow_->variable_at(point, head));
  }
  flow_->set(state.variable);
  for (std::size_t a = 0; a < network_.size(); ++a) state.water.push_back(flow_->content(static_cast<Index>(a)).value);
  for (const double w : state.water) state.initial_water += w;
  state.pores = flow_->pores().volume;
  state.segments.resize(network_.segments.size());
  state.accounts.resize(boundaries_.size());
  state.inflow.assign(network_.segments.size(), 0.0);
  state.flow.assign(network_.links.size(), 0.0);
  for (const auto& own : levels_) {
    state.level.push_back(own.range.first);
    state.basin.push_back({.stored = boundary(own).first_volume(), .first = boundary(own).first_volume()});
  }
  state.wanted = first_interval(scene, state);
  return state;
}

/// Length of the first step: in it, the flows at time zero at points that are not full move a given fraction of the
/// water.
double Stepper::first_interval(const Case& scene, const State& state) {
  const double end = scene.general.end_time;
  begin({0.0, 1e-9 * end, 0.0});
  variable_ = state.variable;
  base_ = state.water;
  flow_->set(variable_);
  for (std::size_t k = 0; k < levels_.size(); ++k) levels_[k].base = state.basin[k].stored;
  begin_stage(state, 1e-9 * end, 1.0);
  find_levels();
  balance(1.0, state, false);
  double moved = 0.0;
  for (std::size_t a = 0; a < network_.size(); ++a)
    if (flow_->content(static_cast<Index>(a)).slope > 0.0) moved += std::abs(net_[a]);
  double first = moved * end > steps::first_share * pores_ ? steps::first_share * pores_ / moved : end;
  find_rates();
  for (const auto& own : levels_)
    if (const double rise = std::abs(own.rates.gain) / boundary(own).area(); rise > 0.0)
      first = std::min(first, steps::first_share * depth_scale(own) / rise);
  return first;
}

void Stepper::begin(const StepTimes& times) {
  for (const auto& along : boundaries_) along.boundary->begin(times);
}

double Stepper::proposal(const State& state) const {
  double next = HUGE_VAL;
  for (const auto& along : boundaries_) next = std::min(next, along.boundary->next_corner(state.time));
  return std::min(state.wanted, next - state.time);
}

void Stepper::link_full_points(const Skeleton& soil, const State& state) {
  const auto full = [&](Index a) {
    return std::max(0.0, 1.0 - (1.0 - state.water[a] / state.pores[a]) / steps::air_in_full_soil);
  };
  // Square of a cell's width [m2] times the increase of its pores, per volume of soil and metre of head.
  const auto yields = [&](Index a) { return space_ ? soil.give[a] / std::cbrt(network_.volume[a]) : soil.give[a]; };
  for (std::size_t i = 0; i < network_.links.size(); ++i) {
    const Link& link = network_.links[i];
    evens_[i] = 0.125 * link.transmissibility * (yields(link.a) + yields(link.b)) * full(link.a) * full(link.b);
  }
}

Flow Stepper::passed_since_zero(std::size_t i) const {
  if (evens_[i] == 0.0) return {};
  const Content a = flow_->borne_head(network_.links[i].a), b = flow_->borne_head(network_.links[i].b);
  return {evens_[i] * (a.value - b.value), evens_[i] * a.slope, -evens_[i] * b.slope};
}

void Stepper::see(const Skeleton& soil, double share) {
  const std::size_t n = network_.size();
  Pores pores{ScalarArray(n), ScalarArray(n), soil.give, soil.conductivity};
  for (std::size_t a = 0; a < n; ++a) {
    pores.volume[a] = soil.pores[a] + share * (soil.found[a] - soil.pores[a]);
    pores.at[a] = soil.head[a] + share * (soil.found_head[a] - soil.head[a]);
  }
  flow_->set_pores(std::move(pores));
}

double Stepper::time_of_a_cell(const Skeleton& soil) const {
  ScalarArray passes(network_.size(), 0.0);  // m2/s (2D: m/s), discharge for each metre of head
  for (const auto& link : network_.links)
    for (const auto& [a, along] : {std::pair{link.a, link.of_a}, {link.b, link.of_b}})
      passes[a] += along * soil.conductivity[a] * link.transmissibility;
  double shortest = HUGE_VAL;
  for (std::size_t a = 0; a < passes.size(); ++a)
    if (soil.give[a] > 0.0 && passes[a] > 0.0) shortest = std::min(shortest, soil.give[a] / passes[a]);
  return shortest;
}

coupling::Outcome Stepper::step(double interval, const Skeleton* soil, State& state) {
  const Attempt attempted = attempt(interval, soil, state);
  if (!attempted.solved)
    return coupling::Outcome::reject(steps::shrink_unsolved * interval, give_up_() ? "given up" : "no solution");
  const double scale = std::max({state.largest_head, attempted.largest_head, spacing_});
  const double error = std::max(attempted.error, attempted.head_error / scale);
  const double allowed = error > 0.0 ? steps::caution * std::sqrt(steps::wanted_error / error) : HUGE_VAL;
  if (error > steps::largest_error * steps::wanted_error)
    return coupling::Outcome::reject(std::max(steps::shrink, allowed) * interval, "the error of a step");
  accept(interval, state);
  state.largest_head = std::max(state.largest_head, attempted.largest_head);
  // Growth is relative to `wanted`, so that a step cut short at an output instant does not limit the next step.
  state.wanted = std::clamp(allowed, steps::shrink, std::max(steps::grow, state.wanted / interval)) * interval;
  return coupling::Outcome::accept();
}

void Stepper::balance(double interval, const State& state, bool with_matrix) {
  std::fill(net_.begin(), net_.end(), 0.0);
  std::fill(passed_.begin(), passed_.end(), 0.0);
  if (with_matrix) matrix_.clear();
  for (std::size_t i = 0; i < network_.links.size(); ++i) {
    const Link& link = network_.links[i];
    const Flow f = flow_->through(link);
    link_flow_[i] = f.value;
    net_[link.a] -= f.value;
    net_[link.b] += f.value;
    Flow all{0.0, interval * f.by_a, interval * f.by_b};
    const Flow passed = passed_since_zero(i);
    passed_[link.a] += passed.value;
    passed_[link.b] -= passed.value;
    all.by_a += passed.by_a;
    all.by_b += passed.by_b;
    if (!with_matrix) continue;
    matrix_[matrix_.diagonal(link.a)] += all.by_a;
    matrix_[places_[i].first] += all.by_b;
    matrix_[matrix_.diagonal(link.b)] -= all.by_b;
    matrix_[places_[i].second] -= all.by_a;
  }
  for (std::size_t i = 0; i < network_.segments.size(); ++i) {
    const Segment& segment = network_.segments[i];
    const Inflow in = boundaries_[boundary_of_[i]].boundary->inflow(*flow_, segment, state.segments[i]);
    inflow_[i] = in.value;
    net_[segment.point] += in.value;
    if (with_matrix) matrix_[matrix_.diagonal(segment.point)] -= interval * in.slope;
  }
  // The levels already satisfy their rows. These rows only show the points how the levels will follow.
  const double step = wells::level_step * spacing_;
  for (std::size_t k = 0; k < levels_.size(); ++k) {
    const OwnLevel& own = levels_[k];
    const std::size_t row = network_.size() + k;
    residual_[row] = 0.0;
    if (!with_matrix) continue;
    double all = 0.0;
    for (std::size_t j = 0; j < own.segments.size() && !own.at_end; ++j) {
      const Segment& segment = network_.segments[own.segments[j]];
      const Inflow in = boundary(own).inflow_at(*flow_, segment, own.level);
      const double ahead = boundary(own).inflow_at(*flow_, segment, own.level + step).value;
      const double by_level = interval * (ahead - in.value) / step;
      all += by_level;
      matrix_[own.places[j].first] -= by_level;
      matrix_[own.places[j].second] += interval * in.slope;
    }
    if (!own.at_end) all += interval * (boundary(own).wants(own.level + step) - boundary(own).wants(own.level)) / step;
    matrix_[matrix_.diagonal(row)] = all > 0.0 ? all : pores_;
  }
  for (std::size_t a = 0; a < network_.size(); ++a) {
    const Content c = flow_->content(static_cast<Index>(a));
    residual_[a] = c.value + passed_[a] - base_[a] - interval * net_[a];
    if (with_matrix) matrix_[matrix_.diagonal(a)] += c.slope;
  }
}

double Stepper::into_soil(const OwnLevel& own, double level) const {
  double sum = 0.0;
  for (const std::size_t i : own.segments) sum += boundary(own).inflow_at(*flow_, network_.segments[i], level).value;
  return sum;
}

void Stepper::find_levels() {
  for (auto& own : levels_) {
    const PoreBoundary& water = boundary(own);
    const auto excess = [&](double level) { return into_soil(own, level) + water.wants(level); };
    double low = own.range.least, at_low = excess(low);
    own.at_end = at_low >= 0.0;
    double found = low;
    if (!own.at_end) {
      double high = std::min(std::max(own.level, low + spacing_), own.range.most), at_high = excess(high);
      for (double step = spacing_; at_high < 0.0 && high < own.range.most; step *= 2.0) {
        low = high;
        at_low = at_high;
        high = std::min(high + step, own.range.most);
        at_high = excess(high);
      }
      own.at_end = at_high < 0.0;
      // The level is found by false position with halved weights (Dowell & Jarratt 1971).
      const double close = wells::level_accuracy * spacing_;
      for (int side = 0, i = 0; high - low > close && at_high > 0.0 && i < wells::most_searches; ++i) {
        const double level = low + (high - low) * at_low / (at_low - at_high), value = excess(level);
        if (value >= 0.0) {
          if (side == 1) at_low *= 0.5;
          side = 1;
          high = level;
          at_high = value;
        } else {
          if (side == -1) at_high *= 0.5;
          side = -1;
          low = level;
          at_low = value;
        }
      }
      found = high;
    }
    own.level = found;
    boundary(own).set_level(found);
  }
}

void Stepper::begin_stage(const State& state, double interval, double share) {
  for (std::size_t k = 0; k < levels_.size(); ++k) {
    const double stored = state.basin[k].stored;
    boundary(levels_[k]).begin_stage({stored, levels_[k].base, interval, share});
  }
}

void Stepper::find_rates() {
  for (auto& own : levels_) own.rates = boundary(own).rates(into_soil(own, own.level), own.at_end);
}

double Stepper::depth_scale(const OwnLevel& own) const {
  return std::max(boundary(own).depth(), basins::least_depth * spacing_);
}

bool Stepper::solve(double interval, State& state) {
  const std::size_t n = network_.size();
  stopped_.assign(n, 0);
  ScalarArray change(n + levels_.size()), before;
  double part = 1.0, left_before = HUGE_VAL;
  for (int iteration = 0;; ++iteration) {
    flow_->set(variable_);
    find_levels();
    balance(interval, state, true);
    // A point without water cannot supply the residual left by earlier steps. It keeps this residual until enough water
    // comes; until then it stays empty, whatever its neighbours do.
    for (std::size_t a = 0; a < n; ++a) {
      if (!(residual_[a] > 0.0) || !flow_->is_empty(static_cast<Index>(a))) continue;
      residual_[a] = 0.0;
      for (Index k = matrix_.begin(a); k < matrix_.end(a); ++k) matrix_[k] = 0.0;
      matrix_[matrix_.diagonal(a)] = pores_;
    }
    double left = 0.0, moved = 0.0;
    for (const double r : residual_) left += std::abs(r);
    for (const double w : net_) moved += interval * std::abs(w);
    double enough = std::clamp(steps::residual * moved, steps::least_residual * pores_, steps::most_residual * pores_);
    if (give_ > 0.0) enough = std::min(enough, steps::borne_residual * std::max(state.largest_head, spacing_) * give_);
    if (left < carried_ + enough) return true;
    if (!std::isfinite(left) || iteration == steps::most_iterations || give_up_()) return false;
    const auto move = [&](std::size_t a) {
      return flow_->limited(static_cast<Index>(a), before[a], before[a] + part * change[a], stopped_[a]);
    };
    // Between two pieces of the curves, Newton's steps could go back and forth for ever: shorter steps end that.
    if (iteration >= steps::whole_steps && left > left_before && part > steps::least_part) {
      part *= 0.5;
      for (std::size_t a = 0; a < n; ++a) variable_[a] = move(a);
      continue;
    }
    // The content of a full point without flow does not depend on its variable: the row needs some diagonal.
    for (std::size_t a = 0; a < n; ++a)
      if (matrix_[matrix_.diagonal(a)] == 0.0) matrix_[matrix_.diagonal(a)] = pores_;
    for (double& r : residual_) r = -r;
    ++state.counts.iterations;
    state.counts.linear_iterations += solve_linear(residual_, steps::linear_residual, change);
    before = variable_;
    left_before = left;
    part = 1.0;
    for (std::size_t a = 0; a < n; ++a) variable_[a] = move(a);
  }
}

double Stepper::solve_linear(std::span<const double> right, double tolerance, ScalarArray& x) const {
  const Ilu0 factors(matrix_);
  const Domain domain;  // one process has the whole field
  return static_cast<double>(flexible_gmres(
                                 domain, [this](auto u, auto y) { matrix_.apply(u, y); },
                                 [&factors](auto r, auto z) { factors.apply(r, z); }, right, x,
                                 tolerance * domain.norm(right), steps::most_linear_iterations)
                                 .iterations);
}

Stepper::Attempt Stepper::attempt(double interval, const Skeleton* soil, State& state) {
  // Two stages, with g = 1 - 1/sqrt(2): w1 = w + g dt net(u1), w2 = w + (1 - g) dt net(u1) + g dt net(u2).
  const double g = 1.0 - std::sqrt(0.5);
  const std::size_t n = network_.size();
  variable_ = state.variable;
  base_ = state.water;
  for (std::size_t k = 0; k < levels_.size(); ++k) {
    levels_[k].level = state.level[k];
    levels_[k].base = state.basin[k].stored;
  }
  // Residuals of earlier steps, for example in full cells, cannot be removed in a short step: the tolerance allows for
  // them (carried_).
  std::fill(evens_.begin(), evens_.end(), 0.0);
  if (soil) {
    link_full_points(*soil, state);
    see(*soil, g);
  }
  flow_->set(variable_);
  before_.assign(n, 0.0);
  for (std::size_t i = 0; i < network_.links.size(); ++i) {
    const double volume = passed_since_zero(i).value;
    before_[network_.links[i].a] += volume;
    before_[network_.links[i].b] -= volume;
  }
  for (std::size_t a = 0; a < n; ++a) base_[a] += before_[a];
  carried_ = give_ = 0.0;
  for (const double give : flow_->pores().give) give_ += give;
  for (std::size_t a = 0; a < n && give_ == 0.0; ++a) {
    const double excess = flow_->content(static_cast<Index>(a)).value - state.water[a];
    if (!(excess > 0.0 && flow_->is_empty(static_cast<Index>(a)))) carried_ += std::abs(excess);
  }
  begin({state.time, interval, state.time + g * interval});
  begin_stage(state, g * interval, g);
  if (!solve(g * interval, state)) return {};
  find_rates();
  for (auto& own : levels_) {
    own.mean_rates = own.rates;
    own.base += (1.0 - g) * interval * own.rates.gain;
  }
  mean_net_ = net_;
  mean_inflow_ = inflow_;
  for (std::size_t a = 0; a < n; ++a) base_[a] += (1.0 - g) * interval * net_[a];
  begin({state.time, interval, state.time + interval});
  begin_stage(state, g * interval, 1.0);
  if (soil) see(*soil, 1.0);
  // The initial guess of the second stage extrapolates the first stage.
  for (std::size_t a = 0; a < n; ++a) {
    const double before = state.variable[a], ahead = before + (variable_[a] - before) / g;
    char stopped = 1;
    variable_[a] = flow_->limited(static_cast<Index>(a), variable_[a], ahead, stopped);
  }
  if (!solve(g * interval, state)) return {};
  const double euler = 0.5 * interval / (1.0 - g);  // the error of implicit Euler, per change of the rates
  double differ = 0.0;
  ScalarArray difference(n);
  for (std::size_t a = 0; a < n; ++a) {
    difference[a] = euler * (net_[a] - mean_net_[a]);
    differ += std::abs(difference[a]);
    mean_net_[a] += g * (net_[a] - mean_net_[a]);
  }
  for (std::size_t i = 0; i < inflow_.size(); ++i) mean_inflow_[i] += g * (inflow_[i] - mean_inflow_[i]);
  Attempt result{true, differ / pores_};
  find_rates();
  for (auto& own : levels_) {
    BasinRates& mean = own.mean_rates;
    if (const double area = boundary(own).area(); area > 0.0)
      result.error = std::max(result.error, euler * std::abs(own.rates.gain - mean.gain) / area / depth_scale(own));
    for (double BasinRates::*rate : {&BasinRates::in, &BasinRates::out, &BasinRates::spilled, &BasinRates::gain})
      mean.*rate += g * (own.rates.*rate - mean.*rate);
  }
  if (soil) std::tie(result.head_error, result.largest_head) = borne_error(difference);
  return result;
}

std::pair<double, double> Stepper::borne_error(std::span<const double> content_error) {
  const std::size_t n = network_.size();
  ScalarArray change(n + levels_.size()), right(content_error.begin(), content_error.end());
  right.resize(n + levels_.size(), 0.0);
  solve_linear(right, steps::error_residual, change);
  double error = 0.0, volume = 0.0, largest = 0.0;
  for (std::size_t a = 0; a < n; ++a) {
    const Content head = flow_->borne_head(static_cast<Index>(a));
    largest = std::max(largest, std::abs(head.value));
    error += network_.volume[a] * std::abs(head.slope * change[a]);
    volume += network_.volume[a];
  }
  return {error / volume, largest};
}

void Stepper::accept(double interval, State& state) {
  for (std::size_t a = 0; a < network_.size(); ++a) state.water[a] += interval * mean_net_[a] - passed_[a] + before_[a];
  for (std::size_t i = 0; i < network_.segments.size(); ++i) {
    const std::size_t b = boundary_of_[i];
    boundaries_[b].boundary->accept(network_.segments[i], mean_inflow_[i], state.segments[i], state.accounts[b]);
  }
  state.variable = variable_;
  for (std::size_t a = 0; a < network_.size(); ++a) state.pores[a] = flow_->pore_volume(static_cast<Index>(a));
  state.flow = link_flow_;
  state.inflow = inflow_;
  for (std::size_t k = 0; k < levels_.size(); ++k) {
    state.level[k] = *boundary(levels_[k]).level();
    const BasinRates& mean = levels_[k].mean_rates;
    BasinWater& basin = state.basin[k];
    basin.stored += interval * mean.gain;
    basin.in += interval * mean.in;
    basin.out += interval * mean.out;
    basin.spilled += interval * mean.spilled;
  }
}

}  // namespace poretwin::pore
