#include "fluid_solver/exchange/soil_exchange.hpp"

#include "common/core/error.hpp"
#include "common/core/threads.hpp"
#include "fluid_solver/discretisation/operators.hpp"
#include "fluid_solver/discretisation/ranks.hpp"
#include "fluid_solver/numerics/erosion.hpp"

#include <fmt/format.h>

namespace poretwin::fluid {

template <int D>
SoilView<D> see_soil(const Setup<D>& setup, std::span<const sph::ImagePlane<D>> planes, const State<D>& state,
                     const coupling::Inbox& inbox, const SeepageRegime& regime) {
  const auto& x = state.particles.position;
  const std::size_t n = x.size();
  // Water about to enter or leave the soil through one of its faces counts as inside. Water that runs down the outside
  // of the soil does not count as inside.
  const ColumnFinder<D> finder(state.columns);
  const auto nearest_column = [&](const Vec<D>& point) -> const FaceColumn<D>* {
    const int i = finder.nearest(point);
    if (i < 0) return nullptr;
    const auto& c = state.columns[static_cast<std::size_t>(i)];
    return c.in_soil && std::abs(c.inside(point)) <= c.spacing ? &c : nullptr;
  };
  if (!setup.coupled) {
    VecArray<D> where = x;
    parallel_for(n, [&](std::size_t a) {
      if (auto& point = where[a]; !is_free(state.particles, a) && !setup.ground.at(point))
        if (const auto* c = nearest_column(point)) point = just_inside<D>(setup.ground, c->foot, c->normal, c->spacing);
    });
    auto view = rigid_soil<D>(setup.ground, where, setup.drag);
    if (setup.smoothed_drag) view.drag_form = setup.smoothed_drag->at(x);
    return view;
  }
  if (inbox.coverage.size() != n)
    throw PeerError(
        fmt::format("the exchange brought values for {} fluid particles, there are {}", inbox.coverage.size(), n));
  ScalarArray asymmetry = inbox.asymmetry;
  if (!state.columns.empty())
    for (std::size_t a = 0; a < n; ++a)
      if (inbox.coverage[a] > 0.0 && !is_free(state.particles, a) && nearest_column(x[a])) asymmetry[a] = 0.0;
  std::vector<char> full(n, 0);  // read in short windows only
  if (!regime.long_window) full = find_full_pores<D>(setup, planes, state.particles, inbox.coverage);
  auto view = mapped_soil<D>(setup, inbox, asymmetry, state.particles.mask, full, regime);
  const auto& received =
      setup.computes_beside ? state.particles.previous_coupling_force : state.particles.coupling_force;
  for (std::size_t a = 0; a < n; ++a)
    if (view.mask[a] > 0.0) view.force.set(a, view.force[a] - received[a]);
  return view;
}

template <int D>
std::vector<char> find_full_pores(const Setup<D>& setup, std::span<const sph::ImagePlane<D>> planes,
                                  const Particles<D>& p, std::span<const double> coverage) {
  const std::size_t n = p.size();
  std::vector<char> full(n, 0);
  std::vector<std::size_t> beside;
  VecArray<D> places;
  for (std::size_t a = 0; a < n; ++a) {
    if (p.mask[a] > 0.0 || !(coverage[a] > 0.0)) continue;
    beside.push_back(a);
    places.push_back(p.position[a]);
  }
  if (!setup.domain.any(!beside.empty())) return full;
  const double length = exchange::soil_smoothing_ratio * setup.soil_spacing, reach = sph::support_radius * length;
  const Domain domain = with_halo<D>(setup, planes, p, reach);
  const WithCopies<Vec<D>> position(domain, p.position);
  const WithCopies<double> mask(domain, p.mask), bulk(domain, p.volume);
  VecArray<D> in_soil;
  ScalarArray volume;
  for (std::size_t a = 0; a < n + domain.copies(); ++a) {
    if (!(mask[a] > 0.0)) continue;
    in_soil.push_back(position[a]);
    volume.push_back(mask[a] * bulk[a]);
  }
  sph::CellGrid<D> grid;
  grid.build(in_soil, reach);
  const auto filled = [&](const Vec<D>& x) {
    double sum = 0.0;
    grid.for_each_within(x, reach,
                         [&](Index b, double r2) { sum += volume[b] * Kernel<D>::value(std::sqrt(r2), length); });
    return sum;
  };
  // The coverage contains the soil's images behind walls. Those of the water are as far from a particle as the water
  // from the particle's own image.
  const auto images = sph::make_images<D>(places, planes, reach);
  ScalarArray room(beside.size());
  parallel_for(beside.size(), [&](std::size_t i) { room[i] = coverage[beside[i]] - filled(places[i]); });
  for (std::size_t j = 0; j < images.size(); ++j) room[images.parent[j]] -= filled(images.position[j]);
  const double own = std::pow(setup.soil_spacing, D) * Kernel<D>::value(0.0, length);
  for (std::size_t i = 0; i < beside.size(); ++i) {
    const std::size_t a = beside[i];
    full[a] = room[i] < exchange::least_room * std::min(own, coverage[a]) ? 1 : 0;
  }
  return full;
}

template <int D>
void fit_pores(const Setup<D>& setup, const SoilView<D>& view, Particles<D>& p) {
  parallel_for(p.size(), [&](std::size_t a) {
    p.void_fraction[a] = 1.0 - view.fraction[a];
    p.volume[a] = p.mass[a] / (p.void_fraction[a] * setup.density);
    p.mask[a] = view.mask[a];
  });
  if (view.number.empty() || setup.one_soil) return;
  p.soil.allocate(p.size());
  for (std::size_t a = 0; a < p.size(); ++a) p.soil.set(a, 1 + view.number[a]);
}

template <int D>
void fill_pores(const Setup<D>& setup, const SoilView<D>& view, Particles<D>& p) {
  for (std::size_t a = 0; a < p.size(); ++a) {
    p.void_fraction[a] = 1.0 - view.fraction[a];
    p.mass[a] = p.void_fraction[a] * setup.density * p.volume[a];
    p.mask[a] = view.mask[a];
  }
}

template <int D>
void fit_columns_to_pores(const Setup<D>& setup, State<D>& state) {
  const auto& p = state.particles;
  for (auto& c : state.columns) {
    if (!c.in_soil) continue;
    double nearest = 4.0 * c.spacing * c.spacing;
    std::vector<std::array<double, 3>> found;  // squared distance, id, porosity
    for (std::size_t a = 0; a < p.size(); ++a)
      if (const double distance = (p.position[a] - c.foot).squaredNorm(); p.mask[a] > 0.5 && distance < nearest) {
        nearest = distance;
        found = {{distance, static_cast<double>(id_of(p, a)), p.void_fraction[a]}};
      }
    found = from_all_ranks(setup, std::move(found));
    if (found.empty()) continue;
    const double n = found.front()[2];
    if (std::abs(n - c.void_fraction) < exchange::same_porosity) continue;
    c.void_fraction = n;
    c.mass = setup.density * n * c.volume;
  }
}

template <int D>
void store_change_of_soil(const OrZero<Vec<D>>& from, Particles<D>& p) {
  p.solid_change.allocate(p.size());
  for (std::size_t a = 0; a < p.size(); ++a) p.solid_change.set(a, p.solid_velocity[a] - from[a]);
}

template <int D>
void apply_returned_impulse(const Stencil<D>& s, const SoilView<D>& view, State<D>& state) {
  auto& p = state.particles;
  VecArray<D> left(p.size());
  ScalarArray counts(p.size());
  for (std::size_t a = 0; a < p.size(); ++a) {
    counts[a] = view.mask[a] * p.volume[a];
    left[a] = -view.returned_impulse[a];
    state.exchanged.received += left[a];
    if (view.mask[a] <= 0.0) continue;
    const Vec<D> along = p.entrained_fraction[a] * (view.velocity[a] - p.solid_velocity[a]);
    p.velocity[a] += along;
    left[a] -= p.mass[a] * along;
  }
  share_out<D>(s, counts, left);
  for (std::size_t a = 0; a < p.size(); ++a) p.velocity[a] += left[a] / p.mass[a];
}

template <int D>
VecArray<D> apply_drag(const Setup<D>& setup, const Particles<D>& p, double interval, SoilView<D>& view,
                       VecArray<D>& velocity) {
  VecArray<D> force(p.size());
  if (velocity.empty()) velocity = p.velocity;
  for (std::size_t a = 0; a < p.size(); ++a) {
    force[a] = view.drag[a] * (velocity[a] - view.velocity[a]) - view.drag_offset[a];
    velocity[a] -= interval / (p.void_fraction[a] * setup.density) * force[a];
  }
  view.resistance.assign(p.size(), {});
  view.linearise(p.velocity, view.velocity);
  return force;
}

template <int D>
void give_drag_impulse(const Setup<D>& setup, const SoilView<D>& view, std::span<const Vec<D>> of_prediction,
                       double interval, State<D>& state) {
  auto& p = state.particles;
  p.drag_impulse.allocate(p.size());
  p.entrained_fraction.allocate(p.size());
  parallel_for(p.size(), [&](std::size_t a) {
    Vec<D> force = view.drag[a] * (p.velocity[a] - p.solid_velocity[a]) - view.drag_offset[a];
    if (!of_prediction.empty()) force += of_prediction[a];
    p.drag_impulse.set(a, p.volume[a] * interval * force);
    p.entrained_fraction.set(a, view.drag[a] / (p.void_fraction[a] * setup.density / interval + view.drag[a]));
  });
  for (std::size_t a = 0; a < p.size(); ++a) {
    state.exchanged.received -= p.drag_impulse[a];
    state.exchanged.drag_work -= p.drag_impulse[a].dot(p.velocity[a] - p.solid_velocity[a]);
  }
}

template <int D>
void add_up_exchanged(const Setup<D>& setup, const Exchanged<D>& before, State<D>& state) {
  if (!setup.tiling) return;
  Exchanged<D>& now = state.exchanged;
  std::array<double, D + 1> own;
  for (std::size_t d = 0; d < D; ++d) own[d] = now.received[static_cast<int>(d)] - before.received[static_cast<int>(d)];
  own[D] = now.drag_work - before.drag_work;
  setup.domain.sum(own);
  now.received = before.received + Eigen::Map<const Vec<D>>(own.data());
  now.drag_work = before.drag_work + own[D];
}

template <int D>
void store_coupling_force(const Setup<D>& setup, const SoilView<D>& view, std::span<const Vec<D>> gradient,
                          double interval, Particles<D>& p) {
  if (setup.computes_beside) p.previous_coupling_force = p.coupling_force;
  p.coupling_force.allocate(p.size());
  parallel_for(p.size(), [&](std::size_t a) {
    Vec<D> force = -view.fraction[a] * (gradient[a] + setup.weight);
    if (interval > 0.0) force += p.drag_impulse[a] / (p.volume[a] * interval);
    p.coupling_force.set(a, force);
  });
  if (setup.computes_beside && !p.previous_coupling_force.is_allocated()) p.previous_coupling_force = p.coupling_force;
}

template <int D>
void store_surface_gradient(const Setup<D>& setup, const Stencil<D>& s, const SoilView<D>& view,
                            std::span<const Vec<D>> gradient, std::span<const char> at_edge, Particles<D>& p) {
  p.surface_share = {};
  p.surface_gradient = {};
  for (std::size_t a = 0; a < p.size(); ++a) {
    const bool surface = p.in_seepage[a] == 0 && s.ghost_distance[a] > 0.0, edge = !at_edge.empty() && at_edge[a] != 0;
    const bool loose = !view.loose.empty() && view.loose[a] != 0 && p.mask[a] > 0.0;
    if (!loose && (p.mask[a] <= 0.5 || !(surface || edge))) continue;
    p.surface_share.set(a, 1.0, p.size());
    p.surface_gradient.set(a, gradient[a] + setup.weight, p.size());
  }
}

template <int D>
void predict_explicitly(const Setup<D>& setup, const SoilView<D>& view, std::span<const Vec<D>> gradient,
                        double interval, Particles<D>& p) {
  for (std::size_t a = 0; a < p.size(); ++a)
    if (view.density[a] > 0.0)
      p.solid_velocity.values()[a] +=
          interval / view.density[a] * (view.force[a] - view.fraction[a] * (setup.weight + gradient[a])) +
          p.drag_impulse[a] / (p.volume[a] * view.density[a]);
}

template <int D>
coupling::Publication publication(const Cloud<D>& cloud, const State<D>& state) {
  coupling::Publication out;
  out.time = state.time;
  out.points.dimension = D;
  out.points.revision = state.revision;
  out.points.n_active = cloud.n_real;
  out.points.volume = cloud.volume;
  out.points.smoothing_length = cloud.length;
  out.points.owner = cloud.owner;
  // The values of the first n points, and zeros for the others.
  const auto flat = [&cloud](const auto& from, std::size_t n) {
    std::vector<double> values(cloud.size() * D, 0.0);
    for (std::size_t a = 0; a < n; ++a)
      for (std::size_t d = 0; d < D; ++d) values[a * D + d] = from[a][static_cast<int>(d)];
    return values;
  };
  out.points.position = flat(cloud.position, cloud.size());
  std::vector<double> share(cloud.size(), 0.0), spreading(cloud.size(), 0.0);
  for (std::size_t a = 0; a < cloud.size(); ++a) {
    share[a] = cloud.surface_share[a];
    spreading[a] = cloud.spreading[a];
  }
  const auto name = [](std::string_view n) { return std::string(n); };
  out.fields = {{name(coupling::field::pore_pressure), 1, cloud.pressure},
                {name(coupling::field::predicted_solid_velocity), D, flat(cloud.solid_velocity, cloud.size())},
                {name(coupling::field::predicted_change), D, flat(cloud.solid_change, cloud.size())},
                {name(coupling::field::drag_impulse), D, flat(state.particles.drag_impulse, cloud.n_real)},
                {name(coupling::field::soil_fraction), 1, cloud.mask},
                {name(coupling::field::surface_gradient), D, flat(cloud.surface_gradient, cloud.size())},
                {name(coupling::field::surface_share), 1, share},
                {name(coupling::field::spreading_rate), 1, spreading}};
  return out;
}

template <int D>
void add_free_water(const Setup<D>& setup, const Cloud<D>& cloud, coupling::Publication& out) {
  coupling::Field velocity{std::string(coupling::field::free_velocity), D, {}};
  coupling::Field share{std::string(coupling::field::free_share), 1, ScalarArray(cloud.size(), 0.0)};
  VecArray<D> free;  // the free particles: positions, velocities
  VecArray<D> moving;
  for (std::size_t a = 0; a < cloud.size(); ++a) {
    if (cloud.owner[a] >= 0.0) share.values[a] = 1.0 - cloud.mask[a];  // buffers may lie behind soil
    if (!(share.values[a] > 0.5)) continue;
    free.push_back(cloud.position[a]);
    moving.push_back(cloud.velocity[a]);
  }
  const double length = erosion::stream_width * points::smoothing_ratio * setup.spacing,
               reach = sph::support_radius * length;
  sph::CellGrid<D> grid;
  grid.build(free, reach);
  velocity.values.resize(cloud.size() * D, 0.0);
  parallel_for(cloud.size(), [&](std::size_t a) {
    if (share.values[a] == 0.0) return;
    Vec<D> sum = Vec<D>::Zero();
    double whole = 0.0;
    grid.for_each_within(cloud.position[a], reach, [&](Index b, double r2) {
      const double weight = Kernel<D>::value(std::sqrt(r2), length) * moving[b].norm();
      sum += weight * moving[b];
      whole += weight;
    });
    if (whole > 0.0) Eigen::Map<Vec<D>>(velocity.values.data() + a * D) = sum / whole;
  });
  out.fields.push_back(std::move(velocity));
  out.fields.push_back(std::move(share));
}

#define PORETWIN_INSTANTIATE(D)                                                                                        \
  template void fit_pores(const Setup<D>&, const SoilView<D>&, Particles<D>&);                                         \
  template void fit_columns_to_pores(const Setup<D>& setup, State<D>& state);                                          \
  template void fill_pores(const Setup<D>&, const SoilView<D>&, Particles<D>&);                                        \
  template void store_change_of_soil(const OrZero<Vec<D>>&, Particles<D>&);                                            \
  template SoilView<D> see_soil(const Setup<D>& setup, std::span<const sph::ImagePlane<D>>, const State<D>& state,     \
                                const coupling::Inbox& inbox, const SeepageRegime& regime);                            \
  template std::vector<char> find_full_pores(const Setup<D>& setup, std::span<const sph::ImagePlane<D>>,               \
                                             const Particles<D>& p, std::span<const double> coverage);                 \
  template void add_up_exchanged(const Setup<D>&, const Exchanged<D>&, State<D>&);                                     \
  template void store_coupling_force(const Setup<D>& setup, const SoilView<D>& view, std::span<const Vec<D>> gradient, \
                                     double interval, Particles<D>& p);                                                \
  template void store_surface_gradient(const Setup<D>& setup, const Stencil<D>& s, const SoilView<D>& view,            \
                                       std::span<const Vec<D>> gradient, std::span<const char>, Particles<D>& p);      \
  template void apply_returned_impulse(const Stencil<D>& s, const SoilView<D>& view, State<D>& state);                 \
  template VecArray<D> apply_drag(const Setup<D>& setup, const Particles<D>& p, double interval, SoilView<D>& view,    \
                                  VecArray<D>& velocity);                                                              \
  template void give_drag_impulse(const Setup<D>& setup, const SoilView<D>& view,                                      \
                                  std::span<const Vec<D>> of_prediction, double interval, State<D>& state);            \
  template void predict_explicitly(const Setup<D>& setup, const SoilView<D>& view, std::span<const Vec<D>> gradient,   \
                                   double interval, Particles<D>& p);                                                  \
  template void add_free_water(const Setup<D>& setup, const Cloud<D>& cloud, coupling::Publication& out);              \
  template coupling::Publication publication(const Cloud<D>& cloud, const State<D>& state);
PORETWIN_INSTANTIATE(2)
PORETWIN_INSTANTIATE(3)
#undef PORETWIN_INSTANTIATE

}  // namespace poretwin::fluid
