#include "coupler/mapping.hpp"

#include "common/core/error.hpp"

#include <algorithm>

namespace poretwin::coupling {

const Field& field_named(const std::vector<Field>& fields, const std::string& name) {
  const auto found = std::find_if(fields.begin(), fields.end(), [&](const Field& f) { return f.name == name; });
  if (found == fields.end()) throw PeerError("field '" + name + "' is missing from the publication to be mapped");
  return *found;
}
namespace {

using Size = std::size_t;

template <int D>
class CloudMapping final : public SpatialMapping {
 public:
  Inbox map(Role giver, const PointSet& giver_points, const std::vector<Field>& giver_fields,
            std::span<const FieldSpec> specs, const PointSet& receiver_points) override {
    auto& at_receivers = giver == Role::fluid ? at_solid_ : at_fluid_;
    auto& at_givers = giver == Role::fluid ? at_fluid_ : at_solid_;
    const auto shared_out = [&](const FieldSpec& spec) {
      return spec.mapping == coupling::Mapping::conservative &&
             !(all_zero(field_named(giver_fields, spec.name).values) && all_zero(account_of(giver, spec).undelivered));
    };
    const typename PairBlocks<D>::Update updates[] = {{&at_receivers, receiver_points, giver_points},
                                                      {&at_givers, giver_points, receiver_points}};
    PairBlocks<D>::update(std::span(updates).first(std::any_of(specs.begin(), specs.end(), shared_out) ? 2 : 1));
    Inbox inbox = map_consistent(at_receivers, giver_fields, specs, sharing_.weights_at(at_receivers));
    for (const auto& spec : specs) {
      if (spec.mapping != coupling::Mapping::conservative) continue;
      if (!shared_out(spec)) {
        inbox.fields.push_back(
            {spec.name, spec.components,
             std::vector<double>(receiver_points.n_active * static_cast<Size>(spec.components), 0.0)});
        continue;
      }
      auto& account = account_of(giver, spec);
      auto delivery = sharing_.conservative(at_givers, at_receivers, giver_points, receiver_points,
                                            field_named(giver_fields, spec.name), account.undelivered);
      for (Size c = 0; c < delivery.given.size(); ++c) {
        account.given[c] += delivery.given[c];
        account.delivered[c] += delivery.delivered[c];
      }
      account.undelivered = std::move(delivery.undelivered);
      inbox.fields.push_back({spec.name, spec.components, std::move(delivery.values)});
    }
    return inbox;
  }

  MappingCounts counts() const override {
    return {at_fluid_.rebuilds() + at_solid_.rebuilds(), at_fluid_.reuses() + at_solid_.reuses()};
  }
  const std::vector<Account>& accounts() const override { return accounts_; }
  void set_accounts(std::vector<Account> accounts) override { accounts_ = std::move(accounts); }
  void archive(Archive& archive) override { archive(accounts_); }

 private:
  static bool is_fraction(std::string_view name) {
    return name == field::soil_fraction || name == field::solid_volume_fraction;
  }

  /// Fields are grouped by mask, since fields with the same mask share the kernel moments.
  static Inbox map_consistent(const PairBlocks<D>& pairs, const std::vector<Field>& fields,
                              std::span<const FieldSpec> specs, const PairWeights* weights) {
    std::vector<std::string> masks;
    std::vector<FieldGroup> groups;
    for (const auto& spec : specs) {
      if (spec.mapping == coupling::Mapping::conservative) continue;
      Size g = static_cast<Size>(std::find(masks.begin(), masks.end(), spec.mask) - masks.begin());
      if (g == masks.size()) {
        masks.push_back(spec.mask);
        groups.push_back({{}, spec.mask.empty() ? std::span<const double>() : field_named(fields, spec.mask).values});
      }
      auto& of_kind = spec.mapping == coupling::Mapping::nearest ? groups[g].properties : groups[g].fields;
      of_kind.push_back(&field_named(fields, spec.name));
    }
    auto mapped = consistent(pairs, groups, weights);
    // Rounding may take the mean of fractions out of [0, 1].
    for (auto& field : mapped.fields)
      if (is_fraction(field.name))
        for (auto& value : field.values) value = std::clamp(value, 0.0, 1.0);
    return {std::move(mapped.coverage),
            std::move(mapped.asymmetry),
            std::move(mapped.spread),
            std::move(mapped.fields),
            {},
            {}};
  }

  Account& account_of(Role giver, const FieldSpec& spec) {
    for (auto& account : accounts_)
      if (account.giver == giver && account.field == spec.name) return account;
    const std::vector<double> zero(static_cast<Size>(spec.components), 0.0);
    accounts_.push_back({spec.name, spec.unit, giver, zero, zero, zero});
    return accounts_.back();
  }

  PairBlocks<D> at_fluid_, at_solid_;  ///< pairs around the fluid's points; pairs around the solid's points
  Sharing<D> sharing_;
  std::vector<Account> accounts_;
};

}  // namespace

std::unique_ptr<SpatialMapping> make_mapping(int dimension) {
  if (dimension == 2) return std::make_unique<CloudMapping<2>>();
  if (dimension == 3) return std::make_unique<CloudMapping<3>>();
  throw Error(ExitCode::bad_case, "mapping: expected dimension 2 or 3, got " + std::to_string(dimension));
}

}  // namespace poretwin::coupling
