#include "fluid_solver/shared_fluid.hpp"

#include "common/core/error.hpp"
#include "fluid_solver/discretisation/ranks.hpp"
#include "fluid_solver/fluid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace poretwin::fluid {
namespace {

/// Where the particles of this rank stand among those of all ranks, in the order of ids; and the number of the latter.
template <int D>
std::pair<std::vector<std::size_t>, std::size_t> places_in_whole(const Setup<D>& setup, std::span<const GlobalId> ids) {
  std::vector<std::array<double, 1>> own;
  for (const GlobalId id : ids) own.push_back({static_cast<double>(id)});
  const auto all = from_all_ranks<D, 1>(setup, own);
  std::vector<std::size_t> places;
  places.reserve(ids.size());
  for (const auto& id : own)
    places.push_back(static_cast<std::size_t>(std::ranges::lower_bound(all, id) - all.begin()));
  return {std::move(places), all.size()};
}

/// Keeps of an array, with `each` numbers per particle, those of the particles at these places. Arrays that are not
/// sent are empty.
void keep(std::vector<double>& values, std::span<const std::size_t> places, std::size_t each = 1) {
  if (values.empty()) return;
  std::vector<double> own;
  own.reserve(places.size() * each);
  for (const std::size_t place : places)
    for (std::size_t c = 0; c < each; ++c) own.push_back(values[place * each + c]);
  values = std::move(own);
}

}  // namespace

template <int D>
coupling::Inbox SharedFluid<D>::share_of(const coupling::Inbox& inbox) const {
  const Setup<D>& setup = this->own_.setup();
  if (!setup.coupled) return {};
  Archive sent;
  coupling::Inbox own;
  if (setup.tiling->leads()) sent(own = inbox);
  Archive received(setup.tiling->from_leader(sent.bytes()));
  received(own);
  const auto [places, count] = places_in_whole<D>(setup, this->own_.state().particles.share.ids);
  if (own.coverage.size() != count)
    throw PeerError(
        fmt::format("the exchange brought values for {} fluid particles, there are {}", own.coverage.size(), count));
  for (auto* values : {&own.coverage, &own.asymmetry, &own.spread}) keep(*values, places);
  for (auto* fields : {&own.fields, &own.at_start, &own.found})
    for (auto& field : *fields) keep(field.values, places, static_cast<std::size_t>(field.components));
  return own;
}

template class SharedFluid<2>;
template class SharedFluid<3>;

template <int D>
std::unique_ptr<Phase> make_shared_fluid(const Case& scene, std::shared_ptr<Tiling<D>> tiling) {
  return std::make_unique<SharedFluid<D>>(scene, std::move(tiling));
}
template std::unique_ptr<Phase> make_shared_fluid<2>(const Case&, std::shared_ptr<Tiling<2>>);
template std::unique_ptr<Phase> make_shared_fluid<3>(const Case&, std::shared_ptr<Tiling<3>>);

}  // namespace poretwin::fluid
