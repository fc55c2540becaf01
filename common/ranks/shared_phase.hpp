// A phase that several ranks share. Each rank computes its share; the one that leads collects the whole where it is
// read as a whole: for the other phase, frames, gauges and checkpoints.
#pragma once

#include "common/case/case.hpp"
#include "common/coupling/phase.hpp"
#include "common/particles/tiling.hpp"

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace poretwin::ranks {

/// All ranks call the same functions in the same order, except contract(), save(), restore(), may_reject() and
/// warnings(), which concern one rank. Publications, frames, gauges, counters and checkpoints of the rank that leads
/// are those of the whole, in the order of ids; the others have empty ones. A checkpoint is the one that a single rank
/// would write, so that any number of ranks can go on from it.
///
/// Part: the phase in D dimensions on one rank, with setup(), state(), take_over(State) and a constructor from a case
/// and a tiling. Its namespace has collected(setup, state): the whole on the rank that leads, without particles on the
/// others.
template <class Part, int D>
class SharedPhase : public Phase {
 public:
  using State = std::remove_cvref_t<decltype(std::declval<const Part&>().state())>;

  SharedPhase(const Case& scene, std::shared_ptr<Tiling<D>> tiling) : own_(scene, tiling) {
    if (tiling->leads()) whole_.emplace(scene);
  }
  [[nodiscard]] coupling::Contract contract() const override { return own_.contract(); }
  [[nodiscard]] coupling::Publication publish() const override {
    collect();
    return whole_ ? whole_->publish() : coupling::Publication{};
  }
  [[nodiscard]] std::pair<double, std::string> proposal() const override { return own_.proposal(); }
  [[nodiscard]] bool may_reject() const override { return own_.may_reject(); }
  coupling::Outcome advance(const coupling::Window& window, const coupling::Inbox& inbox) override {
    collected_ = false;
    return own_.advance(window, inbox);
  }
  void save() override { own_.save(); }
  void restore() override {
    collected_ = false;
    own_.restore();
  }
  void archive(Archive& archive) override {
    if (!archive.loading()) collect();
    if (whole_) whole_->archive(archive);
    if (archive.loading()) share();
  }
  [[nodiscard]] OutputFrame frame() const override {
    collect();
    return whole_ ? whole_->frame() : OutputFrame{};
  }
  [[nodiscard]] std::vector<GaugeReading> gauges() const override {
    if (own_.setup().gauges.empty()) return {};
    collect();
    return whole_ ? whole_->gauges() : std::vector<GaugeReading>{};
  }
  [[nodiscard]] std::map<std::string, double> counters() const override {
    collect();
    return whole_ ? whole_->counters() : std::map<std::string, double>{};
  }

 protected:
  /// Derives what is not sent from what is: in a rank's share, and in the whole.
  virtual void complete_share(State&) const {}
  virtual void complete_whole(State&) const {}

  /// Gives each rank its share of the whole.
  void share() {
    Archive sent;
    if (whole_) {
      State whole = whole_->state();
      sent(whole);
    }
    Archive received(own_.setup().tiling->from_leader(sent.bytes()));
    State state;
    received(state);
    complete_share(state);
    own_.take_over(std::move(state));
    collected_ = true;
  }

  Part own_;
  mutable std::optional<Part> whole_;  ///< on the rank that leads: all particles, as one rank has them
  mutable bool collected_ = false;     ///< whether `whole_` is up to date; the same on every rank

 private:
  /// Brings `whole_` up to date.
  void collect() const {
    if (std::exchange(collected_, true)) return;
    State whole = collected(own_.setup(), own_.state());
    if (!whole_) return;
    complete_whole(whole);
    whole_->take_over(std::move(whole));
  }
};

}  // namespace poretwin::ranks
