#include "solid_solver/shared_solid.hpp"

#include "solid_solver/discretisation/ranks.hpp"
#include "solid_solver/output/report.hpp"
#include "solid_solver/solid.hpp"
#include "solid_solver/statics/initial_state.hpp"

#include <utility>

namespace poretwin::solid {

template <int D>
SharedSolid<D>::SharedSolid(const Case& scene, std::shared_ptr<Tiling<D>> tiling) : own_(scene, tiling) {
  if (tiling->leads()) whole_.emplace(scene);
}

template <int D>
void SharedSolid<D>::initialise(const coupling::Inbox& inbox) {
  if (whole_) whole_->initialise(inbox);
  share();
}

template <int D>
void SharedSolid<D>::share() {
  Archive sent;
  if (whole_) {
    State<D> whole = whole_->state();
    sent(whole);
  }
  Archive received(own_.setup().tiling->from_leader(sent.bytes()));
  State<D> state;
  received(state);
  complete(own_.setup(), state);
  own_.take_over(std::move(state));
  collected_ = true;
}

template <int D>
void SharedSolid<D>::collect() const {
  if (std::exchange(collected_, true)) return;
  State<D> whole = collected(own_.setup(), own_.state());
  if (!whole_) return;
  complete(whole_->setup(), whole);
  whole.rebuilds = own_.state().rebuilds;
  whole_->take_over(std::move(whole));
}

template <int D>
void SharedSolid<D>::archive(Archive& archive) {
  if (!archive.loading()) collect();
  if (whole_) whole_->archive(archive);
  if (archive.loading()) share();
}

template <int D>
OutputFrame SharedSolid<D>::frame() const {
  collect();
  return whole_ ? whole_->frame() : OutputFrame{};
}

template <int D>
std::vector<GaugeReading> SharedSolid<D>::gauges() const {
  if (own_.setup().gauges.empty()) return {};
  collect();
  return whole_ ? whole_->gauges() : std::vector<GaugeReading>{};
}

template <int D>
std::map<std::string, double> SharedSolid<D>::counters() const {
  collect();
  return whole_ ? whole_->counters() : std::map<std::string, double>{};
}

template <int D>
std::vector<Warning> SharedSolid<D>::warnings() const {
  return warnings_of(own_.setup(), own_.state(), whole_ ? whole_->rest() : RestReport{});
}

template class SharedSolid<2>;
template class SharedSolid<3>;

template <int D>
std::unique_ptr<Phase> make_shared_solid(const Case& scene, std::shared_ptr<Tiling<D>> tiling) {
  return std::make_unique<SharedSolid<D>>(scene, std::move(tiling));
}
template std::unique_ptr<Phase> make_shared_solid<2>(const Case&, std::shared_ptr<Tiling<2>>);
template std::unique_ptr<Phase> make_shared_solid<3>(const Case&, std::shared_ptr<Tiling<3>>);

}  // namespace poretwin::solid
