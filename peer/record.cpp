// Records a solver's messages: its command connects to this process, which connects to the coupler and passes them on.
#include "common/coupling/interrupt.hpp"
#include "common/coupling/summary.hpp"
#include "common/coupling/transport.hpp"
#include "peer/child.hpp"
#include "peer/peer.hpp"
#include "peer/wire_log.hpp"

#include <csignal>

namespace poretwin::peer {
namespace {

using namespace coupling;

/// Removes an option and its value from the words; returns the value, or an empty text where the option is missing.
std::string take_option(std::vector<std::string>& words, const std::string& name) {
  for (std::size_t k = 0; k + 1 < words.size(); ++k) {
    if (words[k] != name) continue;
    std::string value = words[k + 1];
    words.erase(words.begin() + static_cast<std::ptrdiff_t>(k), words.begin() + static_cast<std::ptrdiff_t>(k) + 2);
    return value;
  }
  return {};
}

/// Passes messages on in both directions until one end has gone.
void pass_on(Hub& solver, Transport& coupler, WireLogWriter& log, Child& child) {
  std::string line;
  bool forwarded = false;
  for (;;) {
    if (auto event = solver.receive(Milliseconds(1))) {
      if (event->frames.empty()) return;
      line = event->line;
      log.write(Direction::to_coupler, event->frames);
      coupler.send(std::move(event->frames));
    }
    while (auto frames = line.empty() ? std::nullopt : coupler.receive(Milliseconds(0))) {
      log.write(Direction::from_coupler, *frames);
      solver.send(line, std::move(*frames));
    }
    if (coupler.lost() || child.ended()) return;
    if (interrupted() && !forwarded) {
      child.signal(SIGINT);
      forwarded = true;
    }
  }
}

}  // namespace

int record(const std::filesystem::path& log_file, const std::vector<std::string>& given) {
  std::vector<std::string> command = given;
  const std::string address = take_option(command, "--connect");
  const std::string key_file = take_option(command, "--keys");
  if (command.empty() || address.empty())
    throw CaseError("peer record: expected LOG, then the command of a solver with its --connect ADDRESS");
  std::optional<CurveKeys> keys;
  if (!key_file.empty()) keys = read_curve_keys(key_file, KeyHolder::participant);
  WireLogWriter log(log_file);
  const PrivateFolder folder;
  const std::string ours = "ipc://" + (folder.path() / "socket").string();
  command.insert(command.end(), {"--connect", ours});
  const InterruptGuard guard;
  Child child(command);
  {
    const auto solver = bind_socket(ours);
    const auto coupler = connect_socket(address, keys);
    pass_on(*solver, *coupler, log, child);
  }  // closes both lines: each end sees that the other has gone
  const auto code = child.wait(std::chrono::seconds(60));
  if (!code) throw PeerError("peer record: the line is closed, but the solver did not end within 60 s");
  return *code;
}

}  // namespace poretwin::peer
