#include "common/coupling/mock.hpp"

#include "common/core/error.hpp"
#include "common/coupling/standard_contract.hpp"

#include <cmath>
#include <limits>
#include <thread>

namespace poretwin::coupling {

PointSet lattice_points(int dimension, const std::vector<double>& lower, const std::vector<double>& extent,
                        double spacing, double smoothing_per_spacing) {
  PointSet points;
  points.dimension = dimension;
  const auto size = static_cast<std::size_t>(dimension);
  std::vector<long> count(size), at(size, 0);
  for (std::size_t d = 0; d < size; ++d) count[d] = std::lround(extent[d] / spacing);
  for (std::size_t d = 0; d < size; ++d)
    if (count[d] <= 0) return points;
  for (;;) {
    for (std::size_t d = 0; d < size; ++d)
      points.position.push_back(lower[d] + (static_cast<double>(at[d]) + 0.5) * spacing);
    points.volume.push_back(std::pow(spacing, dimension));
    points.smoothing_length.push_back(smoothing_per_spacing * spacing);
    points.owner.push_back(static_cast<double>(points.owner.size()));
    std::size_t d = 0;
    while (d < size && ++at[d] == count[d]) at[d++] = 0;
    if (d == size) break;
  }
  points.n_active = points.size();
  return points;
}

Publication formula_publication(Role role, double t, PointSet points, const FieldFormula& formula) {
  Publication out;
  out.time = t;
  const auto n = points.size();
  for (const auto& spec : standard_fields(role, points.dimension)) {
    Field field{spec.name, spec.components, {}};
    const double at_rest = standard_field(spec.name)->at_rest;
    for (std::size_t i = 0; i < n; ++i)
      for (int c = 0; c < spec.components; ++c)
        field.values.push_back(
            formula ? formula(spec.name, c, &points.position[i * static_cast<std::size_t>(points.dimension)], t)
                    : at_rest);
    out.fields.push_back(std::move(field));
  }
  out.points = std::move(points);
  return out;
}

MockPhase::MockPhase(Role role, int dimension, Formula formula, MockKnobs knobs)
    : role_(role), formula_(std::move(formula)), knobs_(std::move(knobs)) {
  contract_.dimension = dimension;
  contract_.case_digest = knobs_.digest;
  contract_.gives = standard_fields(role, dimension);
  contract_.takes = standard_fields(role == Role::fluid ? Role::solid : Role::fluid, dimension);
}

Contract MockPhase::contract() const { return contract_; }

Publication MockPhase::publish() const {
  Publication out = formula_(state_.time);
  out.time = state_.time;
  if (knobs_.nan_at != 0 && state_.step == knobs_.nan_at)
    for (auto& field : out.fields)
      if (field.name == knobs_.nan_field && !field.values.empty())
        field.values.back() = std::numeric_limits<double>::quiet_NaN();
  return out;
}

void MockPhase::initialise(const Inbox& inbox) { seen_.inboxes.push_back(inbox); }

Outcome MockPhase::advance(const Window& window, const Inbox& inbox) {
  seen_.windows.push_back(window);
  seen_.inboxes.push_back(inbox);
  if (knobs_.die_at == window.step) throw MockDeath{};
  if (knobs_.diverge_at == window.step)
    throw DivergedError("mock: diverged on purpose in step " + std::to_string(window.step));
  if (knobs_.freeze_at == window.step) {
    if (knobs_.on_freeze) knobs_.on_freeze();
    std::this_thread::sleep_for(knobs_.freeze_for);
  }
  std::this_thread::sleep_for(knobs_.per_step);
  state_.time = window.time + window.interval;
  state_.step = window.step;
  if (const auto found = knobs_.rejections.find(window.step); found != knobs_.rejections.end() && found->second > 0) {
    --found->second;
    return Outcome::reject(0.5 * window.interval, "mock: on purpose");
  }
  return Outcome::accept();
}

void MockPhase::save() { saved_ = state_; }

void MockPhase::restore() {
  state_ = saved_;
  ++seen_.restores;
}

OutputFrame MockPhase::frame() const {
  OutputFrame out;
  out.time = state_.time;
  const auto points = formula_(state_.time).points;
  out.count = points.size();
  out.position = [points](std::size_t i, double* x) {
    const auto dimension = static_cast<std::size_t>(points.dimension);
    for (std::size_t d = 0; d < 3; ++d) x[d] = d < dimension ? points.position[i * dimension + d] : 0.0;
  };
  return out;
}

std::vector<GaugeReading> MockPhase::gauges() const { return {{"time", state_.time, "s"}}; }

std::map<std::string, double> MockPhase::counters() const { return {{"windows", static_cast<double>(state_.step)}}; }

}  // namespace poretwin::coupling
