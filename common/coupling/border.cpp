#include "common/coupling/border.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

namespace poretwin::coupling {
namespace {

class Border {
 public:
  explicit Border(const Message& message) : sender_(message.sender), step_(message.step), time_(message.time) {}

  [[noreturn]] void refuse(const std::string& what) const {
    throw PeerError(fmt::format("publication of '{}' at step {} (t = {:g} s): {}", sender_, step_, time_, what));
  }

  void values(const std::string& name, int components, const std::vector<double>& values,
              const PointSet* points) const {
    const Bounds bounds = bounds_of(name);
    const std::size_t k = first_outside(values, bounds.low, bounds.high);
    if (k == values.size()) return;
    const std::size_t i = k / static_cast<std::size_t>(components);
    refuse(fmt::format("field '{}', point {}{}, component {}: expected {}, got {}", name, i,
                       points ? position(*points, i) : "", k % static_cast<std::size_t>(components), bounds.expected,
                       values[k]));
  }

  void size(const std::string& name, std::size_t got, std::size_t want) const {
    if (got != want) refuse(fmt::format("field '{}': expected {} values, got {}", name, want, got));
  }

  void unit(const Array& array, const FieldSpec& spec) const {
    if (array.unit != spec.unit || array.components != spec.components)
      refuse(fmt::format("field '{}': expected {} components in '{}', got {} in '{}'", spec.name, spec.components,
                         spec.unit, array.components, array.unit));
  }

 private:
  struct Bounds {
    double low, high;
    std::string_view expected;
  };
  static Bounds bounds_of(std::string_view name) {
    constexpr double largest = std::numeric_limits<double>::max();
    if (name == field::soil_fraction || name == field::solid_volume_fraction) return {0.0, 1.0, "a number in [0, 1]"};
    if (name == volume_array || name == smoothing_length_array)
      return {std::numeric_limits<double>::min(), largest, "a positive number"};
    return {-largest, largest, "a finite number"};
  }
  static std::string position(const PointSet& points, std::size_t i) {
    const auto d = static_cast<std::size_t>(points.dimension);
    std::string text = " at (";
    for (std::size_t c = 0; c < d; ++c) text += fmt::format("{}{:g}", c ? ", " : "", points.position[i * d + c]);
    return text + ")";
  }

  std::string sender_;
  std::uint64_t step_;
  double time_;
};

std::shared_ptr<const PointSet> points_of(Message& message, const Contract& contract,
                                          const std::shared_ptr<const PointSet>& previous, const Border& border) {
  const auto& info = message.points;
  if (info.dimension != contract.dimension)
    border.refuse(fmt::format("expected dimension {}, got {}", contract.dimension, info.dimension));
  if (info.n_active > info.n) border.refuse(fmt::format("{} active points of {}", info.n_active, info.n));
  if (!info.sent) {
    if (!previous || previous->revision != info.revision || previous->size() != info.n ||
        previous->n_active != info.n_active)
      border.refuse(fmt::format("its points (revision {}, {} points) were not sent and are not those known",
                                info.revision, info.n));
    return previous;
  }
  auto points = std::make_shared<PointSet>();
  points->dimension = info.dimension;
  points->revision = info.revision;
  points->n_active = info.n_active;
  auto take = [&](std::string_view name, int components) {
    const auto found =
        std::find_if(message.arrays.begin(), message.arrays.end(), [&](const Array& a) { return a.name == name; });
    if (found == message.arrays.end()) border.refuse(fmt::format("array '{}' is missing", name));
    border.size(found->name, found->size(), info.n * static_cast<std::size_t>(components));
    auto values = found->take();
    border.values(found->name, components, values, nullptr);
    return values;
  };
  points->position = take(position_array, info.dimension);
  points->volume = take(volume_array, 1);
  points->smoothing_length = take(smoothing_length_array, 1);
  points->owner = take(owner_array, 1);
  for (std::size_t i = 0; i < points->owner.size(); ++i) {
    const double owner = points->owner[i];
    const bool fits = i < info.n_active
                          ? owner == static_cast<double>(i)
                          : owner == -1.0 || (owner >= 0.0 && owner < static_cast<double>(info.n_active) &&
                                              owner == std::floor(owner));
    if (!fits)
      border.refuse(fmt::format("'{}' of point {}: expected {}, got {}", owner_array, i,
                                i < info.n_active ? "the point itself" : "an active point or -1", owner));
  }
  return points;
}

}  // namespace

std::size_t first_outside(std::span<const double> values, double low, double high) {
  constexpr std::size_t at_once = 64;  // looked at side by side
  const auto within = [&](std::size_t k) { return (values[k] >= low) & (values[k] <= high); };
  for (std::size_t first = 0; first < values.size(); first += at_once) {
    const std::size_t last = std::min(first + at_once, values.size());
    bool all = true;
    for (std::size_t k = first; k < last; ++k) all &= within(k);
    if (all) continue;
    for (std::size_t k = first; k < last; ++k)
      if (!within(k)) return k;
  }
  return values.size();
}

Snapshot admit(Message message, const Contract& contract, const std::shared_ptr<const PointSet>& previous) {
  const Border border(message);
  Snapshot out;
  const auto* body = std::get_if<PublicationBody>(&message.body);
  if (!body) border.refuse("expected a PUBLICATION, got " + describe(message));
  out.time = message.time;
  if (!std::isfinite(message.time)) border.refuse(fmt::format("time: expected a finite number, got {}", message.time));
  out.proposed_interval = body->proposed_interval;
  out.limited_by = body->limited_by;
  if (!(out.proposed_interval > 0.0))
    border.refuse(fmt::format("proposed_interval: expected a positive number, got {} (limited by {})",
                              out.proposed_interval, out.limited_by));
  out.points = points_of(message, contract, previous, border);
  for (const auto& spec : contract.gives) {
    const auto found =
        std::find_if(message.arrays.begin(), message.arrays.end(), [&](const Array& a) { return a.name == spec.name; });
    if (found == message.arrays.end()) border.refuse("field '" + spec.name + "' is missing");
    border.unit(*found, spec);
    border.size(spec.name, found->size(), out.points->size() * static_cast<std::size_t>(spec.components));
    auto values = found->take();
    border.values(spec.name, spec.components, values, out.points.get());
    out.fields.push_back({spec.name, spec.components, std::move(values)});
  }
  return out;
}

}  // namespace poretwin::coupling
