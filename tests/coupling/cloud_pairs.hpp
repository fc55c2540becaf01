// Two clouds and the mapping between them, for tests: consistent from source to target, conservative back.
#pragma once

#include "coupler/mapping.hpp"

namespace poretwin::coupling {

template <int D>
class CloudPairs {
 public:
  void update(const PointSet& source, const PointSet& target) {
    source_ = source;
    target_ = target;
    at_target_.update(target, source);
    at_source_.update(source, target);
    coverage_ = interpolate({}, {}).coverage;
  }
  const std::vector<double>& coverage() const { return coverage_; }
  std::vector<Field> consistent(const std::vector<const Field*>& fields, std::span<const double> mask) const {
    return interpolate(fields, mask).fields;
  }
  Delivery conservative(const Field& amounts, std::span<const double> carried) {
    return sharing_.conservative(at_target_, at_source_, target_, source_, amounts, carried);
  }
  Interpolation interpolate(const std::vector<const Field*>& fields, std::span<const double> mask) const {
    const FieldGroup groups[] = {{fields, mask}};
    return coupling::consistent(at_target_, groups, sharing_.weights_at(at_target_));
  }
  std::vector<Field> nearest(const std::vector<const Field*>& fields) const {
    const FieldGroup groups[] = {{{}, {}, fields}};
    return coupling::consistent(at_target_, groups, sharing_.weights_at(at_target_)).fields;
  }
  std::uint64_t rebuilds() const { return at_target_.rebuilds(); }
  std::uint64_t reuses() const { return at_target_.reuses(); }

 private:
  PointSet source_, target_;
  PairBlocks<D> at_target_, at_source_;
  Sharing<D> sharing_;
  std::vector<double> coverage_;
};

}  // namespace poretwin::coupling
