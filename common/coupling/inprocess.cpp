// The in-process transport: queues protected by one lock.
#include "common/coupling/transport.hpp"

#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>

namespace poretwin::coupling {

struct InProcess::Shared {
  std::mutex mutex;
  std::condition_variable changed;
  std::deque<Hub::Event> to_hub;
  std::map<std::string, std::deque<Frames>> to_line;  ///< queue of every open line
  bool hub_open = true, halted = false;
  int lines = 0;
  std::size_t allowed = unlimited;  ///< number of messages that may still pass
  static constexpr std::size_t unlimited = static_cast<std::size_t>(-1);

  void count_one() {
    if (allowed != unlimited) --allowed;
    changed.notify_all();
  }
};

class InProcess::HubEnd final : public Hub {
 public:
  explicit HubEnd(std::shared_ptr<Shared> shared) : shared_(std::move(shared)) {}
  ~HubEnd() override {
    const std::lock_guard lock(shared_->mutex);
    shared_->hub_open = false;
    shared_->changed.notify_all();
  }
  bool send(const std::string& line, Frames frames) override {
    const std::lock_guard lock(shared_->mutex);
    const auto found = shared_->to_line.find(line);
    if (found == shared_->to_line.end()) return false;
    if (shared_->halted) return true;
    found->second.push_back(std::move(frames));
    shared_->changed.notify_all();
    return true;
  }
  std::optional<Event> receive(Milliseconds timeout) override {
    std::unique_lock lock(shared_->mutex);
    const auto ready = [&] { return !shared_->to_hub.empty() && shared_->allowed > 0; };
    if (!shared_->changed.wait_for(lock, timeout, ready)) return std::nullopt;
    shared_->count_one();
    Event event = std::move(shared_->to_hub.front());
    shared_->to_hub.pop_front();
    return event;
  }
  std::string address() const override { return "in-process"; }

 private:
  std::shared_ptr<Shared> shared_;
};

class InProcess::LineEnd final : public Transport {
 public:
  LineEnd(std::shared_ptr<Shared> shared, std::string name) : shared_(std::move(shared)), name_(std::move(name)) {}
  ~LineEnd() override {
    const std::lock_guard lock(shared_->mutex);
    shared_->to_line.erase(name_);
    shared_->to_hub.push_back({name_, {}});
    shared_->changed.notify_all();
  }
  void send(Frames frames) override {
    const std::lock_guard lock(shared_->mutex);
    if (!shared_->hub_open || shared_->halted) return;
    shared_->to_hub.push_back({name_, std::move(frames)});
    shared_->changed.notify_all();
  }
  std::optional<Frames> receive(Milliseconds timeout) override {
    std::unique_lock lock(shared_->mutex);
    auto& queue = shared_->to_line[name_];
    const auto ready = [&] { return !queue.empty() && shared_->allowed > 0; };
    shared_->changed.wait_for(lock, timeout, [&] { return ready() || !shared_->hub_open; });
    if (!ready()) return std::nullopt;
    shared_->count_one();
    Frames frames = std::move(queue.front());
    queue.pop_front();
    return frames;
  }
  bool lost() const override {
    const std::lock_guard lock(shared_->mutex);
    return !shared_->hub_open;
  }
  std::string address() const override { return "in-process"; }

 private:
  std::shared_ptr<Shared> shared_;
  std::string name_;
};

InProcess::InProcess() : shared_(std::make_shared<Shared>()) {}

void InProcess::pause() {
  const std::lock_guard lock(shared_->mutex);
  shared_->allowed = 0;
}

void InProcess::allow(std::size_t messages) {
  const std::lock_guard lock(shared_->mutex);
  if (shared_->allowed != Shared::unlimited) shared_->allowed += messages;
  shared_->changed.notify_all();
}

void InProcess::resume() {
  const std::lock_guard lock(shared_->mutex);
  shared_->allowed = Shared::unlimited;
  shared_->changed.notify_all();
}

void InProcess::halt() {
  const std::lock_guard lock(shared_->mutex);
  shared_->halted = true;
}

std::unique_ptr<Hub> InProcess::hub() { return std::make_unique<HubEnd>(shared_); }

std::unique_ptr<Transport> InProcess::line() {
  const std::lock_guard lock(shared_->mutex);
  std::string name = "line " + std::to_string(++shared_->lines);
  shared_->to_line[name];
  return std::make_unique<LineEnd>(shared_, std::move(name));
}

}  // namespace poretwin::coupling
