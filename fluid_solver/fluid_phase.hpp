// The fluid phase behind the Phase interface: it computes one window at a time, with water as particles.
#pragma once

#include "common/coupling/phase.hpp"
#include "fluid_solver/boundary/bed.hpp"
#include "fluid_solver/boundary/columns.hpp"
#include "fluid_solver/boundary/walls.hpp"
#include "fluid_solver/exchange/passes.hpp"
#include "fluid_solver/setup.hpp"
#include "fluid_solver/state.hpp"

#include <memory>

namespace poretwin::fluid {

template <int D>
class Fluid final : public Phase {
 public:
  /// domain: the part of the water that this process computes; the case contains only this part's regions of water.
  explicit Fluid(const Case& scene, const Domain& domain = {}) : Fluid(scene, make_water_boundaries(scene), domain) {}
  /// boundaries: those of the case's water faces, in their order. They replace the ones that the faces' keys describe.
  Fluid(const Case& scene, WaterBoundaries boundaries, const Domain& domain = {})
      : Fluid(scene, std::move(boundaries), water_lattices<D>(scene), domain) {}

  /// One of several ranks that share the water of the whole case.
  Fluid(const Case& scene, std::shared_ptr<Tiling<D>> tiling);

  [[nodiscard]] coupling::Contract contract() const override;
  [[nodiscard]] coupling::Publication publish() const override;
  [[nodiscard]] std::pair<double, std::string> proposal() const override;
  [[nodiscard]] bool may_reject() const override { return false; }
  void initialise(const coupling::Inbox& inbox) override;
  coupling::Outcome advance(const coupling::Window& window, const coupling::Inbox& inbox) override;
  void save() override { saved_ = state_; }
  void restore() override {
    state_ = saved_;
    walls_.place(state_.inlets);
  }
  void archive(Archive& archive) override;
  [[nodiscard]] OutputFrame frame() const override;
  [[nodiscard]] std::vector<GaugeReading> gauges() const override;
  [[nodiscard]] std::map<std::string, double> counters() const override;
  [[nodiscard]] std::vector<Warning> warnings() const override;

  /// Lets water through the bed, whose parts lie on walls.
  void lay_bed(std::vector<BedPart<D>> bed) { state_.bed = std::move(bed); }
  /// The free water before each part of the bed now.
  [[nodiscard]] std::vector<BedWater> water_before_bed() const { return fluid::water_before_bed(setup_, state_); }
  /// Sets the films on the bed [m^D], which turn into particles over the next `within` [s].
  void turn_over(std::span<const double> film, double within) { fluid::turn_over(film, within, state_); }
  /// Volume of all particles [m^D].
  [[nodiscard]] double volume() const;

  [[nodiscard]] const State<D>& state() const { return state_; }
  [[nodiscard]] const Setup<D>& setup() const { return setup_; }
  /// Takes the whole water's state in place of its own; of several ranks, each keeps its share.
  void take_over(State<D> state);

 private:
  Fluid(const Case& scene, WaterBoundaries boundaries, const std::vector<Lattice<D>>& lattices, const Domain& domain)
      : Fluid(scene, std::move(boundaries), lattices, Setup<D>(scene, lattices, domain)) {}
  Fluid(const Case& scene, WaterBoundaries boundaries, const std::vector<Lattice<D>>& lattices,
        std::shared_ptr<Tiling<D>> tiling);
  Fluid(const Case& scene, WaterBoundaries boundaries, const std::vector<Lattice<D>>& lattices, Setup<D> setup);
  /// Moves the pistons by their speed over an interval [s], and the walls together with them.
  void push_pistons(double interval);
  /// Derives limits of the next window from this one. pressure_before, velocity_before: values at this window's start.
  void limit_next_window(const SoilView<D>& view, const coupling::Window& window, const ScalarArray& pressure_before,
                         const VecArray<D>& velocity_before);

  Setup<D> setup_;
  State<D> state_, saved_;
  Faces<D> faces_;
  Walls<D> walls_;
  Passes<D> passes_;  ///< of the present window
};

}  // namespace poretwin::fluid
