// Ranks as threads of one process, for tests of what a solver forms over all ranks.
#pragma once

#include "common/particles/domain.hpp"

#include <chrono>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace poretwin::test {

/// A particle that some rank owns.
struct Owned {
  std::size_t rank, index;
};

/// A number of ranks that meet at every call. A rank that calls anything else than the others, or does not come within
/// some seconds, ends the run of all with an exception: it decided something by itself.
class ThreadRanks {
 public:
  /// halos: of each rank, the owned particles of which its halo has copies, in order.
  explicit ThreadRanks(std::size_t n, std::vector<std::vector<Owned>> halos = {})
      : halos_(std::move(halos)), calls_(n), values_(n) {
    halos_.resize(n);
    for (std::size_t r = 0; r < n; ++r) ranks_.push_back(std::make_unique<One>(*this, r));
  }

  /// Calls work(rank, ranks) on every rank at once. Rethrows the first exception of the lowest rank that threw one of
  /// its own.
  template <class Work>
  void run(const Work& work) {
    std::vector<std::exception_ptr> failed(ranks_.size());
    std::vector<std::thread> threads;
    for (std::size_t r = 0; r < ranks_.size(); ++r)
      threads.emplace_back([&, r] {
        try {
          work(r, static_cast<const Ranks&>(*ranks_[r]));
          meet(r, "the end");
        } catch (...) {
          failed[r] = std::current_exception();
          give_up();
        }
      });
    for (auto& thread : threads) thread.join();
    for (const auto& failure : failed)
      if (failure) std::rethrow_exception(failure);
  }
  /// Number of calls of each rank in which all had to meet.
  [[nodiscard]] std::size_t meetings() const { return meetings_; }

 private:
  class One final : public Ranks {
   public:
    One(ThreadRanks& all, std::size_t rank) : all_(all), rank_(rank) {}
    void sum(std::span<double> values) const override {
      all_.combine(rank_, "sum", values, [](double a, double b) { return a + b; });
    }
    void max(std::span<double> values) const override {
      all_.combine(rank_, "max", values, [](double a, double b) { return std::max(a, b); });
    }
    void exchange(std::span<double> values, std::size_t each) const override { all_.exchange(rank_, values, each); }

   private:
    ThreadRanks& all_;
    std::size_t rank_;
  };

  /// Waits until all ranks have come here.
  void meet(std::size_t rank, const std::string& call) {
    std::unique_lock lock(mutex_);
    calls_[rank] = call;
    const std::size_t turn = turn_;
    if (++waiting_ == calls_.size()) {
      for (const auto& other : calls_)
        if (other != calls_[0]) broken_ = "ranks ask for different things: " + calls_[0] + ", " + other;
      waiting_ = 0;
      ++turn_;
      ++meetings_;
      met_.notify_all();
    } else if (!met_.wait_for(lock, std::chrono::seconds(60), [&] { return turn_ != turn || !broken_.empty(); })) {
      broken_ = "a rank waits in vain for the others: " + call;
      met_.notify_all();
    }
    if (!broken_.empty()) throw std::runtime_error(broken_);
  }
  void give_up() {
    const std::lock_guard lock(mutex_);
    if (broken_.empty()) broken_ = "another rank failed";
    met_.notify_all();
  }

  template <class Operation>
  void combine(std::size_t rank, const std::string& name, std::span<double> values, const Operation& operation) {
    const std::string call = name + " of " + std::to_string(values.size());
    values_[rank] = values;
    meet(rank, call);
    std::vector<double> whole(values_[0].begin(), values_[0].end());
    for (std::size_t r = 1; r < values_.size(); ++r)
      for (std::size_t i = 0; i < whole.size(); ++i) whole[i] = operation(whole[i], values_[r][i]);
    meet(rank, call);
    std::copy(whole.begin(), whole.end(), values.begin());
    meet(rank, call);
  }
  void exchange(std::size_t rank, std::span<double> values, std::size_t each) {
    const std::string call = "exchange of " + std::to_string(each) + " each";
    values_[rank] = values;
    meet(rank, call);
    const auto& halo = halos_[rank];
    const std::size_t owned = values.size() / each - halo.size();
    for (std::size_t i = 0; i < halo.size(); ++i)
      for (std::size_t k = 0; k < each; ++k)
        values[(owned + i) * each + k] = values_[halo[i].rank][halo[i].index * each + k];
    meet(rank, call);
  }

  std::vector<std::vector<Owned>> halos_;
  std::vector<std::unique_ptr<One>> ranks_;
  std::mutex mutex_;
  std::condition_variable met_;
  std::vector<std::string> calls_;
  std::vector<std::span<double>> values_;
  std::string broken_;
  std::size_t waiting_ = 0, turn_ = 0, meetings_ = 0;
};

}  // namespace poretwin::test
