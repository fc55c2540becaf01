#include "fluid_solver/shared_fluid.hpp"

#include "common/core/error.hpp"
#include "fluid_solver/discretisation/ranks.hpp"
#include "fluid_solver/fluid.hpp"

#include <utility>

namespace poretwin::fluid {

template <int D>
SharedFluid<D>::SharedFluid(const Case& scene, std::shared_ptr<Tiling<D>> tiling) : own_(scene, tiling) {
  if (tiling->leads()) whole_.emplace(scene);
}

template <int D>
coupling::Publication SharedFluid<D>::publish() const {
  throw Error(ExitCode::failure, "several ranks cannot take part in a coupled run yet");
}

template <int D>
void SharedFluid<D>::share() {
  Archive sent;
  if (whole_) {
    State<D> whole = whole_->state();
    sent(whole);
  }
  Archive received(own_.setup().tiling->from_leader(sent.bytes()));
  State<D> state;
  received(state);
  own_.take_over(std::move(state));
  collected_ = true;
}

template <int D>
void SharedFluid<D>::collect() const {
  if (std::exchange(collected_, true)) return;
  State<D> whole = collected(own_.setup(), own_.state());
  if (whole_) whole_->take_over(std::move(whole));
}

template <int D>
void SharedFluid<D>::archive(Archive& archive) {
  if (!archive.loading()) collect();
  if (whole_) whole_->archive(archive);
  if (archive.loading()) share();
}

template <int D>
OutputFrame SharedFluid<D>::frame() const {
  collect();
  return whole_ ? whole_->frame() : OutputFrame{};
}

template <int D>
std::vector<GaugeReading> SharedFluid<D>::gauges() const {
  if (own_.setup().gauges.empty()) return {};
  collect();
  return whole_ ? whole_->gauges() : std::vector<GaugeReading>{};
}

template <int D>
std::map<std::string, double> SharedFluid<D>::counters() const {
  collect();
  return whole_ ? whole_->counters() : std::map<std::string, double>{};
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
