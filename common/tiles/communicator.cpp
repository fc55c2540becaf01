#include "common/tiles/communicator.hpp"

#include "common/core/error.hpp"
#include "common/tiles/heartbeat.hpp"
#include "common/tiles/mpi.hpp"

#include <fmt/format.h>

#include <array>
#include <cstdio>
#include <cstring>
#include <limits>
#include <string>
#include <utility>

namespace poretwin::tiles {
namespace {

/// Tags are the numbers of calls, modulo the number of tags that every MPI has.
constexpr std::uint64_t n_tags = 32768;

std::string who(const Communicator::Mpi& mpi) { return fmt::format("rank {} of {}", mpi.rank, mpi.size); }

std::string meaning(int code) {
  std::array<char, MPI_MAX_ERROR_STRING> text{};
  int length = 0;
  MPI_Error_string(code, text.data(), &length);
  return {text.data(), static_cast<std::size_t>(length)};
}

/// Throws where a call of MPI failed.
void expect_success(const Communicator::Mpi& mpi, int code, const char* call) {
  if (code != MPI_SUCCESS) throw PeerError(fmt::format("{}: {} failed: {}", who(mpi), call, meaning(code)));
}

/// The length of a message, as MPI takes it.
int length(const Communicator::Mpi& mpi, std::size_t bytes) {
  if (bytes > static_cast<std::size_t>(std::numeric_limits<int>::max()))
    throw PeerError(fmt::format("{}: a message of {} bytes, but MPI sends 2 GiB at most at a time: use more ranks",
                                who(mpi), bytes));
  return static_cast<int>(bytes);
}

}  // namespace

struct Transfer::State {
  const Communicator::Mpi* mpi;
  std::uint64_t call;
  std::vector<Incoming> in;
  std::vector<MPI_Request> requests;  ///< those of `in` come first
};

Transfer::Transfer(std::unique_ptr<State> state) : state_(std::move(state)) {}
Transfer::Transfer(Transfer&&) noexcept = default;
Transfer& Transfer::operator=(Transfer&&) noexcept = default;

Transfer::~Transfer() {
  if (!state_) return;
  for (std::size_t i = 0; i < state_->requests.size(); ++i) {
    auto& request = state_->requests[i];
    if (request == MPI_REQUEST_NULL) continue;
    if (i < state_->in.size()) MPI_Cancel(&request);
    MPI_Request_free(&request);
  }
}

void Transfer::finish() {
  State& state = *state_;
  const Communicator::Mpi& mpi = *state.mpi;
  // One by one: OpenMPI 4.1 does not always return from MPI_Waitall where a message is too long.
  for (std::size_t i = 0; i < state.requests.size(); ++i) {
    MPI_Status status;
    const int code = MPI_Wait(&state.requests[i], &status);
    if (i >= state.in.size()) {
      expect_success(mpi, code, "MPI_Wait of a message sent");
      continue;
    }
    const auto& message = state.in[i];
    if (code != MPI_SUCCESS)
      throw PeerError(fmt::format("{}: call {}: a message of {} bytes from rank {} failed: {}", who(mpi), state.call,
                                  message.bytes.size(), message.rank, meaning(code)));
    if (status.MPI_TAG != static_cast<int>(state.call % n_tags))
      throw PeerError(
          fmt::format("{} is at call {}, rank {} at call {}: one of them took another way through the program",
                      who(mpi), state.call % n_tags, message.rank, status.MPI_TAG));
    int came = 0;
    MPI_Get_count(&status, MPI_BYTE, &came);
    if (static_cast<std::size_t>(came) != message.bytes.size())
      throw PeerError(fmt::format("{}: call {}: expected {} bytes from rank {}, got {}", who(mpi), state.call,
                                  message.bytes.size(), message.rank, came));
  }
  state_.reset();
}

Communicator::Communicator(std::unique_ptr<Mpi> mpi) : mpi_(std::move(mpi)) {}
Communicator::~Communicator() = default;
int Communicator::rank() const { return mpi_->rank; }
int Communicator::size() const { return mpi_->size; }
const Traffic& Communicator::traffic() const { return mpi_->traffic; }
void Communicator::at_step(std::uint64_t step) const { mpi_->step = step; }
std::uint64_t Communicator::step() const { return mpi_->step; }

void Communicator::gather_bytes(std::span<const std::byte> own, std::span<std::byte> all, char purpose) const {
  // Each part is preceded by the number and the purpose of the call, so that ranks that are at different calls are
  // found out before anyone uses what the others meant for something else.
  const std::uint64_t head = ++mpi_->calls << 8U | static_cast<unsigned char>(purpose);
  const std::size_t n = own.size() + sizeof head;
  Bytes part(n), parts(n * static_cast<std::size_t>(mpi_->size));
  std::memcpy(part.data(), &head, sizeof head);
  if (!own.empty()) std::memcpy(part.data() + sizeof head, own.data(), own.size());
  expect_success(
      *mpi_,
      MPI_Allgather(part.data(), length(*mpi_, n), MPI_BYTE, parts.data(), length(*mpi_, n), MPI_BYTE, mpi_->handle),
      "MPI_Allgather");
  for (int r = 0; r < mpi_->size; ++r) {
    const std::byte* const at = parts.data() + static_cast<std::size_t>(r) * n;
    std::uint64_t other = 0;
    std::memcpy(&other, at, sizeof other);
    if (other != head)
      throw PeerError(
          fmt::format("{} is at call {} ('{}', {} bytes), rank {} at another: one of them took another way "
                      "through the program",
                      who(*mpi_), mpi_->calls, purpose, own.size(), r));
    if (!own.empty()) std::memcpy(all.data() + static_cast<std::size_t>(r) * own.size(), at + sizeof head, own.size());
  }
  ++mpi_->traffic.messages;
  mpi_->traffic.bytes += n;
}

Transfer Communicator::begin(std::span<const Outgoing> out, std::span<const Incoming> in) const {
  auto state = std::make_unique<Transfer::State>();
  state->mpi = mpi_.get();
  state->call = ++mpi_->calls;
  state->in.assign(in.begin(), in.end());
  state->requests.reserve(in.size() + out.size());
  const int tag = static_cast<int>(state->call % n_tags);
  // Messages from one rank arrive in the order in which it sent them: whatever comes next must be of this call.
  for (const auto& message : in) {
    MPI_Request request = MPI_REQUEST_NULL;
    expect_success(*mpi_,
                   MPI_Irecv(message.bytes.data(), length(*mpi_, message.bytes.size()), MPI_BYTE, message.rank,
                             MPI_ANY_TAG, mpi_->handle, &request),
                   "MPI_Irecv");
    state->requests.push_back(request);
  }
  for (const auto& message : out) {
    MPI_Request request = MPI_REQUEST_NULL;
    expect_success(*mpi_,
                   MPI_Isend(message.bytes.data(), length(*mpi_, message.bytes.size()), MPI_BYTE, message.rank, tag,
                             mpi_->handle, &request),
                   "MPI_Isend");
    state->requests.push_back(request);
    ++mpi_->traffic.messages;
    mpi_->traffic.bytes += message.bytes.size();
  }
  return Transfer(std::move(state));
}

std::vector<Bytes> Communicator::trade(std::span<const Bytes> to) const {
  const auto n = static_cast<std::size_t>(mpi_->size);
  struct Announced {
    std::uint64_t call, bytes;
  };
  std::vector<Announced> sent(n), coming(n);
  const std::uint64_t call = ++mpi_->calls;
  for (std::size_t r = 0; r < n; ++r) sent[r] = {call, to[r].size()};
  expect_success(
      *mpi_,
      MPI_Alltoall(sent.data(), sizeof(Announced), MPI_BYTE, coming.data(), sizeof(Announced), MPI_BYTE, mpi_->handle),
      "MPI_Alltoall");
  mpi_->traffic.messages += n - 1;
  mpi_->traffic.bytes += (n - 1) * sizeof(Announced);
  std::vector<Bytes> from(n);
  std::vector<Outgoing> out;
  std::vector<Incoming> in;
  for (int r = 0; r < mpi_->size; ++r) {
    const auto k = static_cast<std::size_t>(r);
    if (coming[k].call != call)
      throw PeerError(
          fmt::format("{} is at call {}, rank {} at call {}: one of them took another way through the program",
                      who(*mpi_), call, r, coming[k].call));
    if (r == mpi_->rank) {
      from[k] = to[k];
      continue;
    }
    from[k].resize(coming[k].bytes);
    if (!from[k].empty()) in.push_back({r, from[k]});
    if (!to[k].empty()) out.push_back({r, to[k]});
  }
  begin(out, in).finish();
  return from;
}

std::string Communicator::from_first(const std::string& own) const {
  const std::vector<Bytes> to(static_cast<std::size_t>(size()), rank() == 0 ? bytes_of(own) : Bytes{});
  const auto text = values_of<char>(trade(to).front());
  return {text.begin(), text.end()};
}

int run_as_rank(int argc, char** argv, const std::function<int(const Communicator&)>& work) {
  // Only the thread that began MPI calls it; a solver's other threads compute.
  int provided = 0;
  if (MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided) != MPI_SUCCESS || provided < MPI_THREAD_FUNNELED) {
    std::fputs("MPI cannot be used by a process with several threads, or does not start\n", stderr);
    return static_cast<int>(ExitCode::failure);
  }
  auto mpi = std::make_unique<Communicator::Mpi>();
  MPI_Comm_dup(MPI_COMM_WORLD, &mpi->handle);
  MPI_Comm_rank(mpi->handle, &mpi->rank);
  MPI_Comm_size(mpi->handle, &mpi->size);
  MPI_Comm_set_errhandler(mpi->handle, MPI_ERRORS_RETURN);
  MPI_Comm handle = mpi->handle;
  const std::string me = who(*mpi);
  const auto end_all = [&](const char* reason, ExitCode code) {
    std::fputs(fmt::format("{}: error: {}\n", me, reason).c_str(), stderr);
    std::fflush(stderr);
    MPI_Abort(MPI_COMM_WORLD, static_cast<int>(code));
    return static_cast<int>(code);
  };
  try {
    const int code = [&] {
      const Communicator all(std::move(mpi));
      const Heartbeat heartbeat(all);
      return work(all);
    }();
    MPI_Comm_free(&handle);
    MPI_Finalize();
    return code;
  } catch (const Error& error) {
    return end_all(error.what(), error.code());
  } catch (const std::exception& error) {
    return end_all(error.what(), ExitCode::failure);
  }
}

}  // namespace poretwin::tiles
