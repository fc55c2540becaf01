#include "solid_solver/exchange/water_answer.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace poretwin::solid {
namespace {

constexpr double pores = 0.4, water = 1000.0, grains = 2600.0, weight = 9810.0;  // 1, kg/m3, N/m3
constexpr double spacing = 0.02, height = 0.4, modulus = 4e6, shear = 1.15e6;    // m, Pa

/// Soil of one conductivity in one window, and the fraction of an error of a single wave that remains after a pass.
struct Window {
  double conductivity, interval;
  [[nodiscard]] double drag() const { return weight * pores * pores / conductivity; }
  [[nodiscard]] double inertia() const { return pores * water / interval; }
  [[nodiscard]] double along() const { return drag() * inertia() / (inertia() + drag()); }
  [[nodiscard]] double of_soil() const { return (1.0 - pores) * grains / interval; }
  [[nodiscard]] WaterAnswer answer() const {
    return answer_of({drag(), inertia(), pores, interval}, modulus, spacing, height);
  }
  /// How far the shortest waves drain in the window.
  [[nodiscard]] double drains() const {
    const double shortest = 0.5 * M_PI / spacing;
    return interval * modulus * shortest * shortest * pores * pores / drag();
  }
  /// stiffness: true over predicted one.
  [[nodiscard]] double left(double wave, double elastic, double stiffness, double of_water, double put) const {
    const double A = of_soil() + interval * elastic * wave * wave;
    const double T = of_soil() + stiffness * interval * elastic * wave * wave;
    return std::abs((A - T) * (put - of_water) / ((A + of_water) * (T + put)));
  }
  [[nodiscard]] double left_of_dilation(double wave, double stiffness, const WaterAnswer& answer) const {
    return left(wave, modulus, stiffness, drag() / (pores * pores),
                answer.translation + answer.dilation * interval * wave * wave);
  }
  [[nodiscard]] double left_of_shear(double wave, double put) const { return left(wave, shear, 0.0, along(), put); }
};

template <class Look>
void for_each_window_and_wave(Look&& look) {
  for (const double k : {1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7})
    for (const double interval : {1e-3, 1e-2, 0.1, 1.0, 10.0})
      for (double wave = 0.5 * M_PI / height; wave < 0.51 * M_PI / spacing; wave *= 1.5)
        look(Window{k, interval}, wave);
}

TEST(WaterAnswer, DilationConvergesDownToAQuarterOfTheStiffnessPredicted) {
  for_each_window_and_wave([](const Window& window, double wave) {
    for (const double stiffness : {1.0, 0.7, 0.5, 0.3, 0.25})
      EXPECT_LT(window.left_of_dilation(wave, stiffness, window.answer()), 1.0)
          << "k " << window.conductivity << ", " << window.interval << " s, wave " << wave << ", " << stiffness;
  });
}

TEST(WaterAnswer, WithoutAModulusDilationOfLongWavesDiverges) {
  const Window window{1e-5, 1.0};
  WaterAnswer answer = window.answer();
  answer.dilation = 0.0;
  EXPECT_GT(window.left_of_dilation(0.5 * M_PI / height, 0.3, answer), 1.5);
}

TEST(WaterAnswer, ShearThatNothingHoldsGoesOnWhereTheShortestWavesDrain) {
  int looked_at = 0;
  for_each_window_and_wave([&](const Window& window, double wave) {
    if (window.drains() < 20.0) return;
    ++looked_at;
    EXPECT_LT(window.left_of_shear(wave, window.answer().translation), 0.5);
  });
  EXPECT_GT(looked_at, 50);
  const Window creeping{1e-4, 1.0};
  EXPECT_GT(creeping.left_of_shear(20.0, creeping.drag()), 0.9);  // restrained by the drag, it hardly moves
}

TEST(WaterAnswer, WhereNothingDrainsItIsTheDrag) {
  const Window window{1e-7, 1e-3};
  EXPECT_NEAR(window.answer().translation, window.drag(), 1e-3 * window.drag());
  EXPECT_LT(window.answer().dilation, 1e-3 * modulus);
}

TEST(WaterAnswer, WithoutDragThereIsNone) {
  EXPECT_EQ(answer_of({0.0, 1.0, pores, 1.0}, modulus, spacing, height).translation, 0.0);
}

}  // namespace
}  // namespace poretwin::solid
