#include "common/coupling/border.hpp"

#include "common/coupling/standard_contract.hpp"

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
    const auto* const field = standard_field(name);
    const Bounds bounds = field && !field->of_volume ? field->bounds : bounds_of(name);
    const std::string_view unit = field ? field->unit : name == position_array ? "m" : "1";
    const std::size_t k = first_outside(values, bounds.low, bounds.high);
    if (k != values.size())
      refuse_value(name, components, k, values[k], std::isfinite(values[k]) ? bounds.text(unit) : "a finite number",
                   points);
    if (points && field && field->of_volume) amounts(*field, components, values, *points);
  }

  /// Checks that sums over neighbours are possible: no point may reach all others or only itself, and points must not
  /// coincide.
  void points(const PointSet& points) const {
    const auto d = static_cast<std::size_t>(points.dimension);
    const auto power = [d](double x) { return d == 2 ? x * x : x * x * x; };
    const double most = power(most_in_reach);
    double volume = 0.0, largest = 0.0, longest = 0.0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double v = points.volume[i], reach = power(points.smoothing_length[i]);
      if (!(most * reach >= v && reach <= most * v))
        refuse(fmt::format(
            "field '{}', point {}{}: expected {} times the size of its volume of {} m^{} at most, and a {}th of it at "
            "least, got {} m",
            smoothing_length_array, i, position(points, i), most_in_reach, v, d, most_in_reach,
            points.smoothing_length[i]));
      volume += v;
      largest = std::max(largest, v);
      longest = std::max(longest, points.smoothing_length[i]);
    }
    if (points.size() < 2) return;
    const double margin = 2.0 * longest + std::pow(largest, 1.0 / points.dimension);
    double room = 1.0, widest = 0.0;
    for (std::size_t c = 0; c < d; ++c) {
      double low = points.position[c], high = low;
      for (std::size_t k = c; k < points.position.size(); k += d) {
        low = std::min(low, points.position[k]);
        high = std::max(high, points.position[k]);
      }
      room *= high - low + margin;
      widest = std::max(widest, high - low);
    }
    if (widest <= 1e-9 * longest || volume > most_overlap * room)
      refuse(fmt::format(
          "field '{}', point 0{}: expected {} points of {:g} m^{} together to lie side by side, got all of them within "
          "{:g} m",
          position_array, position(points, 0), points.size(), volume, d, widest));
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
  static constexpr double farthest = 1e9;         // m
  static constexpr double most_in_reach = 100.0;  // largest ratio of the smoothing length to the size of a point
  static constexpr double most_overlap = 20.0;    // largest ratio of the sum of all volumes to the space of the points

  /// Bounds of an array that describes points, and of a field outside the standard contract.
  static Bounds bounds_of(std::string_view name) {
    constexpr double largest = std::numeric_limits<double>::max(), least = std::numeric_limits<double>::min();
    if (name == position_array) return {-farthest, farthest};
    if (name == volume_array || name == smoothing_length_array) return {least, largest};
    return {-largest, largest};
  }

  [[noreturn]] void refuse_value(const std::string& name, int components, std::size_t k, double value,
                                 std::string_view expected, const PointSet* points) const {
    const auto c = static_cast<std::size_t>(components);
    refuse(fmt::format("field '{}', point {}{}, component {}: expected {}, got {}", name, k / c,
                       points ? position(*points, k / c) : "", k % c, expected, value));
  }

  void amounts(const StandardField& field, int components, const std::vector<double>& values,
               const PointSet& points) const {
    const auto c = static_cast<std::size_t>(components);
    for (std::size_t k = 0; k < values.size(); ++k) {
      const double most = field.bounds.high * points.volume[k / c];
      if (!(std::abs(values[k]) <= most))
        refuse_value(
            std::string(field.name), components, k, values[k],
            fmt::format("at most {:g} {}, {:g} of each m^{}", most, field.unit, field.bounds.high, points.dimension),
            &points);
    }
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
  border.points(*points);
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
  constexpr std::size_t at_once = 64;  // number of values that are compared together, without branches
  const auto within = [&](std::size_t k) {
    return (static_cast<int>(values[k] >= low) & static_cast<int>(values[k] <= high)) != 0;
  };
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
  constexpr std::size_t few_words = 200;  // longest text kept [characters]; each text has a count of its own
  out.limited_by = body->limited_by.substr(0, few_words);
  if (!(out.proposed_interval > 0.0))
    border.refuse(fmt::format("proposed_interval: expected a positive number, got {} (limited by {})",
                              out.proposed_interval, out.limited_by));
  out.unsettled = body->unsettled;
  if (!(out.unsettled >= 0.0) || !std::isfinite(out.unsettled))
    border.refuse(fmt::format("unsettled: expected a number that is not negative, got {}", out.unsettled));
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
