#include "pore_solver/pore_phase.hpp"

#include "common/core/error.hpp"
#include "common/coupling/standard_contract.hpp"
#include "common/geometry/pieces.hpp"
#include "common/geometry/shapes.hpp"
#include "common/media/predicted_modulus.hpp"
#include "common/media/seepage.hpp"
#include "pore_solver/numerics/steps.hpp"

#include <algorithm>

namespace poretwin::pore {

namespace {

namespace field = coupling::field;

/// Smoothing length, in spacings, of a point in the mapping between the processes: half of the kernel's support.
constexpr double reach = 1.2;

}  // namespace

PoreWater::PoreWater(const Case& scene, bool (*give_up)())
    : scene_(scene),
      give_up_(give_up),
      drawn_network_(make_network(scene_)),
      network_(drawn_network_),
      stepper_(std::make_unique<Stepper>(scene_, network_, give_up_)),
      gauges_(std::make_unique<Gauges>(scene_, network_)),
      state_(stepper_->first_state(scene_)),
      drawn_(rigid_pores(scene_, network_)) {
  if (!scene_.coupled() || !has_basins(scene_.water_faces)) return;
  for (const auto& x : drawn_network_.position) {
    std::optional<std::size_t> basin;
    double nearest = HUGE_VAL;
    for (std::size_t f = 0; f < scene_.water_faces.size(); ++f) {
      if (!scene_.water_faces[f].basin_area) continue;
      const double distance = distance_from(scene_.water_faces[f].face, x, scene_.general.dimension);
      if (basin && !(distance < nearest)) continue;
      basin = f;
      nearest = distance;
    }
    nearest_basin_.push_back(*basin);
  }
}

coupling::Contract PoreWater::contract() const {
  const int dimension = scene_.general.dimension;
  coupling::Contract out{dimension, scene_.digest(), {}, {}};
  if (!scene_.coupled()) return out;
  out.gives = coupling::standard_fields(coupling::Role::fluid, dimension, coupling::WaterAs::field);
  if (has_basins(scene_.water_faces)) out.gives.push_back(coupling::basin_level_field());
  for (auto& spec : coupling::standard_fields(coupling::Role::solid, dimension)) {
    const bool pores = spec.name == field::solid_volume_fraction;
    if (!pores && spec.name != field::constrained_modulus && spec.name != field::hydraulic_conductivity &&
        !(scene_.can_yield() && spec.name == field::mean_solid_velocity))
      continue;
    spec.found = pores && scene_.predicts();
    out.takes.push_back(std::move(spec));
  }
  return out;
}

coupling::Publication PoreWater::publish() const {
  coupling::Publication out;
  out.time = state_.time;
  auto& points = out.points;
  points.dimension = scene_.general.dimension;
  std::tie(out.proposed_interval, out.limited_by) = proposal();
  if (!scene_.coupled()) return out;
  const std::size_t n = network_.size();
  points.revision = 1 + static_cast<std::uint64_t>(state_.counts.carried);
  points.n_active = n;
  points.volume = drawn_network_.volume;
  const auto& position = state_.position.empty() ? network_.position : state_.position;
  points.smoothing_length.assign(n, reach * scene_.fluid.particle_spacing);
  const FlowModel& flow = stepper_->flow(state_);
  coupling::Field pressure{std::string(field::pore_pressure), 1, ScalarArray(n)},
      degree{std::string(field::degree_of_saturation), 1, ScalarArray(n)};
  const double weight = porous::specific_weight(scene_);
  for (std::size_t a = 0; a < n; ++a) {
    points.owner.push_back(static_cast<double>(a));
    for (int d = 0; d < points.dimension; ++d) points.position.push_back(position[a][d]);
    pressure.values[a] = weight * flow.borne_head(static_cast<Index>(a)).value;
    degree.values[a] = std::clamp(degree_of_saturation(a), 0.0, 1.0);
  }
  out.fields = {std::move(pressure), std::move(degree)};
  if (has_basins(scene_.water_faces)) {
    coupling::Field level{std::string(field::basin_level), 1, ScalarArray(n)};
    for (std::size_t a = 0; a < n; ++a) level.values[a] = state_.level[*stepper_->level_of(nearest_basin_[a])];
    out.fields.push_back(std::move(level));
  }
  return out;
}

double PoreWater::degree_of_saturation(std::size_t a) const {
  const double initial = scene_.soils[network_.soil[a]].initial_saturation;
  return initial + (1.0 - initial) * saturation(state_, static_cast<Index>(a));
}

std::pair<double, std::string> PoreWater::proposal() const {
  return {stepper_->proposal(state_), "the error of a step"};
}

void PoreWater::initialise(const coupling::Inbox& inbox) {
  if (inbox.fields.empty()) return;
  see_soil(inbox, 0);
  state_.wanted = std::min(state_.wanted, stepper_->time_of_a_cell(skeleton_));
  // The first window stores the soil's state at rest; at this time the soil has not come to rest yet.
  state_.rest_solid.clear();
  state_.rest_conductivity.clear();
}

void PoreWater::see_soil(const coupling::Inbox& inbox, unsigned pass) {
  const std::size_t n = network_.size();
  const ScalarArray &solid = inbox.at(field::solid_volume_fraction).values,
                    &conductivity = inbox.at(field::hydraulic_conductivity).values,
                    &modulus = inbox.at(field::constrained_modulus).values;
  if (state_.rest_solid.empty()) {
    state_.rest_solid = solid;
    state_.rest_conductivity = conductivity;
  }
  // Pores follow from the volume fraction of the grains: at rest they are those of the case; after that, the grains
  // keep their volume. At points to which no value was mapped (0), the pores remain the same.
  const auto pores_of = [&](const ScalarArray& share) {
    ScalarArray pores(n);
    for (std::size_t a = 0; a < n; ++a)
      pores[a] = share[a] > 0.0 && state_.rest_solid[a] > 0.0
                     ? drawn_.volume[a] + drawn_network_.volume[a] * (state_.rest_solid[a] / share[a] - 1.0)
                     : state_.pores[a];
    return pores;
  };
  Skeleton& s = skeleton_;
  s.pores = pores_of(solid);
  s.conductivity.resize(n);
  for (std::size_t a = 0; a < n; ++a)
    s.conductivity[a] = conductivity[a] > 0.0 && state_.rest_conductivity[a] > 0.0
                            ? drawn_.conductivity[a] * conductivity[a] / state_.rest_conductivity[a]
                            : drawn_.conductivity[a];
  const FlowModel& flow = stepper_->flow(state_);
  s.head.resize(n);
  for (std::size_t a = 0; a < n; ++a) s.head[a] = flow.borne_head(static_cast<Index>(a)).value;
  s.found = pass > 0 ? pores_of(inbox.found_at(field::solid_volume_fraction).values) : s.pores;
  s.found_head = pass > 0 ? passed_head_ : s.head;
  s.give.assign(n, 0.0);
  const double weight = porous::specific_weight(scene_);
  for (std::size_t a = 0; a < n && scene_.predicts(); ++a)
    if (modulus[a] > 0.0) {
      const double ratio = scene_.soils[network_.soil[a]].poissons_ratio;
      s.give[a] = drawn_network_.volume[a] * weight /
                  (modulus[a] * porous::predicted_modulus(ratio, scene_.general.dimension, pass > 0));
    }
}

void PoreWater::link() {
  if (linked_ == state_.linked) return;
  linked_ = state_.linked;
  const bool drawn = linked_.empty() || linked_ == drawn_network_.position;
  network_ = drawn ? drawn_network_ : make_network(scene_, drawn_network_, linked_);
  stepper_ = std::make_unique<Stepper>(scene_, network_, give_up_);
  gauges_ = std::make_unique<Gauges>(scene_, network_);
}

void PoreWater::follow_soil(const coupling::Inbox& inbox) {
  if (!scene_.can_yield() || state_.last_interval <= 0.0) return;
  const ScalarArray& velocity = inbox.at(field::mean_solid_velocity).values;
  auto& position = state_.position;
  if (position.empty()) position = state_.linked = linked_ = network_.position;
  ++state_.counts.carried;
  double farthest = 0.0;
  for (std::size_t a = 0; a < position.size(); ++a) {
    for (int d = 0; d < 2; ++d) position[a][d] += state_.last_interval * velocity[2 * a + static_cast<std::size_t>(d)];
    farthest = std::max(farthest, (position[a] - state_.linked[a]).norm());
  }
  if (farthest < steps::carried_far * scene_.fluid.particle_spacing) return;
  state_.linked = position;
  link();
  ++state_.counts.links;
  state_.segments.assign(network_.segments.size(), {});
  state_.inflow.assign(network_.segments.size(), 0.0);
  state_.flow.assign(network_.links.size(), 0.0);
}

coupling::Outcome PoreWater::advance(const coupling::Window& window, const coupling::Inbox& inbox) {
  const bool moves = !inbox.fields.empty();
  if (moves) {
    follow_soil(inbox);
    see_soil(inbox, window.pass);
  }
  const auto outcome = stepper_->step(window.interval, moves ? &skeleton_ : nullptr, state_);
  if (!outcome.accepted) return outcome;
  state_.time = window.time + window.interval;
  state_.last_interval = window.interval;
  if (moves) {
    const FlowModel& flow = stepper_->flow(state_);
    passed_head_.resize(network_.size());
    for (std::size_t a = 0; a < network_.size(); ++a) passed_head_[a] = flow.borne_head(static_cast<Index>(a)).value;
  }
  return outcome;
}

void PoreWater::compute_flux() const {
  flux_.assign(network_.size(), Point3::Zero());
  const auto add = [&](Index a, const Point3& from_point, double out) {
    flux_[a] += out / network_.volume[a] * (from_point - network_.position[a]);
  };
  for (std::size_t i = 0; i < network_.links.size(); ++i) {
    const Link& link = network_.links[i];
    add(link.a, link.centre, state_.flow[i]);
    add(link.b, link.centre - link.shift, -state_.flow[i]);
  }
  for (std::size_t i = 0; i < network_.segments.size(); ++i)
    add(network_.segments[i].point, network_.segments[i].centre, -state_.inflow[i]);
}

OutputFrame PoreWater::frame() const {
  const FlowModel& flow = stepper_->flow(state_);
  head_.resize(network_.size());
  for (std::size_t a = 0; a < network_.size(); ++a) head_[a] = flow.pressure_head(static_cast<Index>(a));
  compute_flux();
  OutputFrame out;
  out.time = state_.time;
  out.count = network_.size();
  out.position = write_vectors<3>(network_.position);
  const double weight = porous::specific_weight(scene_);
  out.fields = {{{"pressure_head", "m", "pressure over the water's specific weight; below zero under suction", 1},
                 write_scalars([this](std::size_t a) { return head_[a]; })},
                {{"pore_pressure", "Pa", "pressure of the water; below zero under suction", 1},
                 write_scalars([this, weight](std::size_t a) { return weight * head_[a]; })},
                {{"degree_of_saturation", "1", "water's share of the pores", 1},
                 write_scalars([this](std::size_t a) { return saturation(state_, static_cast<Index>(a)); })},
                {{"water_content", "1", "volume of water per volume of soil", 1},
                 write_scalars([this](std::size_t a) { return state_.water[a] / network_.volume[a]; })},
                {{"relative_flux", "m/s", "discharge through the skeleton, per area", 3}, write_vectors<3>(flux_)},
                {{"volume", scene_.general.dimension == 3 ? "m3" : "m2", "of the soil that the point stands for", 1},
                 write_scalars([this](std::size_t a) { return network_.volume[a]; })}};
  return out;
}

std::vector<GaugeReading> PoreWater::gauges() const { return gauges_->read(stepper_->flow(state_), *stepper_, state_); }

std::vector<PoreWater::Opening> PoreWater::openings() const {
  std::vector<Opening> openings;
  for (const Segment& s : network_.segments)
    if (is_open(s)) openings.push_back({s.centre, -pieces_of(scene_.water_faces[s.face].face).front().left(), s.area});
  return openings;
}

void PoreWater::set_standing(std::span<const Standing> standing) {
  auto next = standing.begin();
  for (std::size_t i = 0; i < network_.segments.size(); ++i) {
    if (!is_open(network_.segments[i])) continue;
    state_.segments[i].pond = next->volume;
    state_.segments[i].head = next->head;
    ++next;
  }
}

ScalarArray PoreWater::left_standing() const {
  ScalarArray left;
  for (std::size_t i = 0; i < network_.segments.size(); ++i)
    if (is_open(network_.segments[i])) left.push_back(state_.segments[i].pond);
  return left;
}

Account PoreWater::through_faces() const {
  Account all;
  const auto& boundaries = stepper_->boundaries();
  for (std::size_t b = 0; b < boundaries.size(); ++b) {
    const std::size_t face = boundaries[b].face;
    if (face != Segment::none && scene_.water_faces[face].free_water) continue;
    all.in += state_.accounts[b].in;
    all.out += state_.accounts[b].out;
  }
  return all;
}

double PoreWater::through_openings() const {
  double gained = 0.0;
  for (std::size_t b = 0; b < state_.accounts.size(); ++b) {
    const std::size_t face = stepper_->boundaries()[b].face;
    if (face != Segment::none && scene_.water_faces[face].free_water) gained += state_.accounts[b].gained();
  }
  return gained;
}

double PoreWater::stored() const {
  double sum = 0.0;
  for (const double w : state_.water) sum += w;
  return sum;
}

std::map<std::string, double> PoreWater::counters() const {
  const Counts& c = state_.counts;
  return {{"points", static_cast<double>(network_.size())},
          {"Newton iterations", c.iterations},
          {"linear iterations", c.linear_iterations},
          {"times linked anew", c.links}};
}

std::unique_ptr<Phase> make_pore_water(const Case& scene) { return std::make_unique<PoreWater>(scene); }

}  // namespace poretwin::pore
