// The water in the pores as a field, behind the Phase interface. It takes the role of the fluid, either alone in rigid
// soil or together with a solver of soil that moves.
#pragma once

#include "common/case/case.hpp"
#include "common/coupling/interrupt.hpp"
#include "common/coupling/phase.hpp"
#include "pore_solver/network.hpp"
#include "pore_solver/output/gauges.hpp"
#include "pore_solver/step.hpp"

#include <memory>
#include <span>

namespace poretwin::pore {

class PoreWater final : public Phase {
 public:
  /// give_up: asked between iterations; where it says yes, the window is rejected. A signal to stop need not wait for
  /// the end of a window, which in a large field takes minutes.
  explicit PoreWater(const Case& scene, bool (*give_up)() = coupling::interrupted);

  [[nodiscard]] coupling::Contract contract() const override;
  [[nodiscard]] coupling::Publication publish() const override;
  [[nodiscard]] std::pair<double, std::string> proposal() const override;
  void initialise(const coupling::Inbox& inbox) override;
  coupling::Outcome advance(const coupling::Window& window, const coupling::Inbox& inbox) override;
  void save() override { saved_ = state_; }
  void restore() override {
    state_ = saved_;
    link();
  }
  void archive(Archive& archive) override {
    archive(state_);
    link();
  }
  [[nodiscard]] OutputFrame frame() const override;
  [[nodiscard]] std::vector<GaugeReading> gauges() const override;
  [[nodiscard]] std::map<std::string, double> counters() const override;

  /// A part of the soil's surface that is open to free water (WaterFace::free_water).
  struct Opening {
    Point3 centre = Point3::Zero(), outwards = Point3::Zero();  ///< m; unit
    double area = 0.0;                                          ///< m2 (2D: m)
  };
  [[nodiscard]] std::vector<Opening> openings() const;
  /// Free water on an opening.
  struct Standing {
    double head = 0.0;    ///< m, pressure head at its centre; zero or below: it is dry
    double volume = 0.0;  ///< m3 (2D: m2), that the soil may take
  };
  /// Sets the free water on each opening for the steps that follow.
  void set_standing(std::span<const Standing> standing);
  /// The volume of each opening's free water that these steps have left; more than was there where water came out
  /// [m3, 2D: m2].
  [[nodiscard]] ScalarArray left_standing() const;
  /// Sum over all boundaries but the openings.
  [[nodiscard]] Account through_faces() const;
  /// Volume that has passed through the openings into the soil since the start [m3, 2D: m2].
  [[nodiscard]] double through_openings() const;
  /// Volume of water in the soil [m3, 2D: m2].
  [[nodiscard]] double stored() const;

  [[nodiscard]] const Network& network() const { return network_; }
  [[nodiscard]] const State& state() const { return state_; }
  /// The flow model at the present state.
  [[nodiscard]] const FlowModel& flow() const { return stepper_->flow(state_); }

 private:
  /// Takes over the soil's fields for a pass through a window: pores, conductivity and stiffness.
  void see_soil(const coupling::Inbox& inbox, unsigned pass);
  /// Moves the points with the soil. Links the points anew once one of them has moved far.
  void follow_soil(const coupling::Inbox& inbox);
  /// Makes the network of the state's points, unless it exists.
  void link();
  /// Degree of saturation of a point, over all of its pores: includes the initial residual water of its soil.
  [[nodiscard]] double degree_of_saturation(std::size_t a) const;
  [[nodiscard]] bool is_open(const Segment& segment) const {
    return segment.face != Segment::none && scene_.water_faces[segment.face].free_water;
  }
  /// Computes the discharge per area at each point [m/s] from the flows through the sides of its cell.
  void compute_flux() const;

  Case scene_;
  bool (*give_up_)();
  Network drawn_network_, network_;
  std::vector<Point3> linked_;                ///< m, State::linked for which the network was made
  mutable std::unique_ptr<Stepper> stepper_;  ///< not const: it contains work space, which is not part of the state
  std::unique_ptr<Gauges> gauges_;
  State state_, saved_;
  Pores drawn_;                             ///< pores of the soil as the case draws it
  std::vector<std::size_t> nearest_basin_;  ///< of each point of moving soil: the face with a basin that is nearest
  ScalarArray passed_head_;  ///< m, head that the skeleton bore at the end of the last pass through the window
  Skeleton skeleton_;
  mutable std::vector<Point3> flux_;  ///< of the last frame
  mutable ScalarArray head_;
};

std::unique_ptr<Phase> make_pore_water(const Case& scene);

}  // namespace poretwin::pore
