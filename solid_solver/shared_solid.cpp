#include "solid_solver/shared_solid.hpp"

#include "solid_solver/output/report.hpp"
#include "solid_solver/solid.hpp"
#include "solid_solver/statics/initial_state.hpp"

namespace poretwin::solid {

template <int D>
void SharedSolid<D>::initialise(const coupling::Inbox& inbox) {
  if (this->whole_) this->whole_->initialise(inbox);
  this->share();
}

template <int D>
void SharedSolid<D>::complete_share(State<D>& share) const {
  complete(this->own_.setup(), share);
}

template <int D>
void SharedSolid<D>::complete_whole(State<D>& whole) const {
  complete(this->whole_->setup(), whole);
  whole.rebuilds = this->own_.state().rebuilds;
}

template <int D>
std::vector<Warning> SharedSolid<D>::warnings() const {
  return warnings_of(this->own_.setup(), this->own_.state(), this->whole_ ? this->whole_->rest() : RestReport{});
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
