// A rigid skeleton in the place of the solid, for poretwin's own fluid: a solver outside poretwin's source tree.
//
//   poretwin run clients/python/examples/seepage.toml --solid build/rigid-solid
//
// Its density makes the skeleton rigid: from it the fluid predicts how far the skeleton moves within a window, and with
// 1e12 kg/m3 it does not move.
#include <poretwin/coupling/phase_main.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

using namespace poretwin;
using namespace poretwin::coupling;

namespace {

constexpr double unmovable = 1e12;  // kg/m3, grain density with which the skeleton does not move

/// The points of a square lattice in the boxes of soil. Behind a side of a box that lies on a wall the lattice
/// continues by four spacings, as ghosts: without them the wall would look like the soil's surface.
class Bed {
 public:
  explicit Bed(const Case& scene) {
    const auto dimension = static_cast<std::size_t>(scene.general.dimension);
    const double spacing = scene.solid.particle_spacing;
    for (const bool ghosts : {false, true}) {
      for (const auto& soil : scene.soils) {
        if (soil.shape.kind != Shape::Kind::box)
          throw CaseError(scene.path.string() + ": soil '" + soil.name + "': expected shape = \"box\"");
        add(scene, soil, spacing, ghosts);
      }
      if (!ghosts) points_.n_active = soil_.size();
    }
    const std::size_t n = soil_.size();
    points_.dimension = scene.general.dimension;
    points_.volume.assign(n, std::pow(spacing, dimension));
    points_.smoothing_length.assign(n, 1.3 * spacing);
    for (std::size_t i = 0; i < n; ++i) points_.owner.push_back(i < points_.n_active ? static_cast<double>(i) : -1.0);
  }
  [[nodiscard]] const PointSet& points() const { return points_; }
  [[nodiscard]] const std::vector<const Soil*>& soil() const { return soil_; }

 private:
  static bool on_wall(const Case& scene, int axis, double coordinate) {
    return std::any_of(scene.walls.begin(), scene.walls.end(), [&](const Wall& wall) {
      const auto& corners = wall.face.points;
      return !corners.empty() && std::all_of(corners.begin(), corners.end(),
                                             [&](const Point3& x) { return std::abs(x[axis] - coordinate) < 1e-9; });
    });
  }

  void add(const Case& scene, const Soil& soil, double spacing, bool ghosts) {
    const int dimension = scene.general.dimension;
    std::array<long, 3> first{}, beyond{}, inside{}, at{};
    for (int d = 0; d < dimension; ++d) {
      inside[d] = std::lround((soil.shape.max[d] - soil.shape.min[d]) / spacing);
      first[d] = on_wall(scene, d, soil.shape.min[d]) ? -4 : 0;
      beyond[d] = inside[d] + (on_wall(scene, d, soil.shape.max[d]) ? 4 : 0);
    }
    for (at = first;;) {
      bool ghost = false;
      for (int d = 0; d < dimension; ++d) ghost = ghost || at[d] < 0 || at[d] >= inside[d];
      if (ghost == ghosts) {
        for (int d = 0; d < dimension; ++d)
          points_.position.push_back(soil.shape.min[d] + (static_cast<double>(at[d]) + 0.5) * spacing);
        soil_.push_back(&soil);
      }
      int d = 0;
      while (d < dimension && ++at[d] == beyond[d]) {
        at[d] = first[d];
        ++d;
      }
      if (d == dimension) return;
    }
  }

  PointSet points_;
  std::vector<const Soil*> soil_;  ///< soil of each point
};

class RigidSolid final : public Phase {
 public:
  explicit RigidSolid(const Case& scene) : scene_(scene), bed_(scene_) {}

  [[nodiscard]] Contract contract() const override {
    const int dimension = scene_.general.dimension;
    return {dimension, scene_.digest(), standard_fields(Role::solid, dimension),
            standard_fields(Role::fluid, dimension, scene_.is_field() ? WaterAs::field : WaterAs::particles)};
  }

  [[nodiscard]] Publication publish() const override {
    Publication out;
    out.time = state_.time;
    out.points = bed_.points();
    for (const auto& spec : standard_fields(Role::solid, scene_.general.dimension)) {
      Field field{spec.name, spec.components, {}};
      for (const Soil* soil : bed_.soil())
        field.values.insert(field.values.end(), static_cast<std::size_t>(spec.components), value(*soil, spec.name));
      out.fields.push_back(std::move(field));
    }
    return out;
  }

  void initialise(const Inbox&) override {}

  Outcome advance(const Window& window, const Inbox& inbox) override {
    const auto& impulse = inbox.at(field::drag_impulse);
    for (std::size_t k = 0; k < impulse.values.size(); ++k)
      state_.taken[k % static_cast<std::size_t>(impulse.components)] += impulse.values[k];
    state_.time = window.time + window.interval;
    return Outcome::accept();
  }

  void save() override { saved_ = state_; }
  void restore() override { state_ = saved_; }
  void archive(Archive& archive) override { archive(state_); }

  [[nodiscard]] OutputFrame frame() const override {
    OutputFrame out;
    out.time = state_.time;
    out.count = bed_.points().n_active;
    out.position = [this](std::size_t i, double* x) {
      const auto dimension = static_cast<std::size_t>(scene_.general.dimension);
      for (std::size_t d = 0; d < 3; ++d) x[d] = d < dimension ? bed_.points().position[i * dimension + d] : 0.0;
    };
    return out;
  }
  [[nodiscard]] std::vector<GaugeReading> gauges() const override {
    return {{"impulse_taken_x", state_.taken[0], "N s"}, {"impulse_taken_y", state_.taken[1], "N s"}};
  }
  [[nodiscard]] std::map<std::string, double> counters() const override {
    return {{"particles", static_cast<double>(bed_.points().n_active)}};
  }

 private:
  static double value(const Soil& soil, std::string_view name) {
    if (name == field::solid_volume_fraction) return 1.0 - soil.porosity;
    if (name == field::grain_density) return unmovable;
    if (name == field::hydraulic_conductivity) return soil.hydraulic_conductivity;
    return 0.0;
  }

  struct State {
    double time = 0.0;              // s
    std::array<double, 3> taken{};  // N s, sum of all drag received
  };
  const Case scene_;
  const Bed bed_;
  State state_, saved_;
};

}  // namespace

int main(int argc, char** argv) {
  return phase_main(argc, argv, Role::solid, [](const Case& scene) { return std::make_unique<RigidSolid>(scene); });
}
