#include "coupler/iteration.hpp"

#include <algorithm>

namespace poretwin::coupling {
namespace {

const Field& find(const Snapshot& snapshot, const std::string& name) {
  const auto found = std::find_if(snapshot.fields.begin(), snapshot.fields.end(),
                                  [&](const Field& field) { return field.name == name; });
  if (found == snapshot.fields.end()) throw PeerError("field '" + name + "' is missing from the solid's publication");
  return *found;
}

Eigen::Map<const Eigen::VectorXd> values(const Field& field) {
  return {field.values.data(), static_cast<Eigen::Index>(field.values.size())};
}

}  // namespace

WindowIteration::WindowIteration(const IterationSettings& settings, const Contract& solid)
    : settings_(settings), acceleration_(make_acceleration(settings.acceleration)) {
  // Vector fields with consistent mapping (velocities, forces) are iterated. Scalar fields are not: they are properties
  // of the skeleton that follow from its motion, and extrapolation could take them out of their bounds. Nor are
  // conservative amounts, which are delivered once, in the next window.
  for (const auto& spec : solid.gives)
    if (spec.mapping == Mapping::consistent && spec.components == solid.dimension) fields_.push_back(spec.name);
}

std::optional<Snapshot> WindowIteration::next(const Snapshot& given, const Snapshot& found) {
  for (const auto& name : fields_)
    if (find(given, name).values.size() != find(found, name).values.size()) {
      // Points have been added or removed, so that the iteration starts again.
      acceleration_ = make_acceleration(settings_.acceleration);
      scale_.clear();
      return found;
    }
  if (converged(given, found)) return std::nullopt;
  if (scale_.empty())
    for (const auto& name : fields_) {
      const double norm = std::max(values(find(found, name)).norm(), values(find(given, name)).norm());
      scale_.push_back(norm > 0.0 ? norm : 1.0);
    }
  const Eigen::VectorXd x = acceleration_->next(packed(given), packed(found));
  Snapshot out = found;
  Eigen::Index from = 0;
  for (std::size_t k = 0; k < fields_.size(); ++k)
    for (auto& field : out.fields)
      if (field.name == fields_[k])
        for (auto& value : field.values) value = scale_[k] * x[from++];
  return out;
}

Eigen::VectorXd WindowIteration::packed(const Snapshot& snapshot) const {
  Eigen::Index size = 0;
  for (const auto& name : fields_) size += values(find(snapshot, name)).size();
  Eigen::VectorXd out(size);
  size = 0;
  for (std::size_t k = 0; k < fields_.size(); ++k) {
    const auto part = values(find(snapshot, fields_[k]));
    out.segment(size, part.size()) = part / scale_[k];
    size += part.size();
  }
  return out;
}

bool WindowIteration::converged(const Snapshot& given, const Snapshot& found) const {
  return std::all_of(fields_.begin(), fields_.end(), [&](const std::string& name) {
    const auto x = values(find(given, name)), result = values(find(found, name));
    return (result - x).norm() <= settings_.tolerance * result.norm();
  });
}

}  // namespace poretwin::coupling
