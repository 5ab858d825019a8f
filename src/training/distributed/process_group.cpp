#include "training/distributed/process_group.h"

#include <gloo/transport/device.h>
#include <torch/version.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <future>
#include <thread>
#include <torch/csrc/distributed/c10d/PrefixStore.hpp>
#include <torch/csrc/distributed/c10d/ProcessGroupGloo.hpp>
#include <torch/csrc/distributed/c10d/TCPStore.hpp>

#include "core/checksum.h"
#include "core/error.h"
#include "core/log.h"
#include "core/signals.h"
#include "training/distributed/heartbeat.h"

namespace ld {
namespace {

using std::chrono::milliseconds;

// Gloo's own limit on one operation. The heartbeat finds lost peers much sooner, and waits for busy ones.
constexpr milliseconds kGlooTimeout = std::chrono::hours(24 * 7);

/// The first line of what LibTorch or Gloo say: they add backtraces.
std::string reason(const std::exception& error) {
  const auto* of_torch = dynamic_cast<const c10::Error*>(&error);
  const std::string text = of_torch != nullptr ? of_torch->what_without_backtrace() : error.what();
  return text.substr(0, text.find('\n'));
}

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

template <class Number>
Number number_in(const char* name, Number low, Number high, const std::string& otherwise) {
  const std::string text = variable(name);
  if (text.empty() && !otherwise.empty())
    fail_usage("the environment variable {} is not set, but WORLD_SIZE={} asks for several processes; {}",
               name, variable("WORLD_SIZE"), otherwise);
  Number value{};
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || stop != text.data() + text.size() || value < low || value > high)
    fail_usage("the environment variable {} is '{}'; expected a number from {} to {}", name, text, low, high);
  return value;
}

milliseconds seconds_in(const char* name, milliseconds otherwise) {
  if (variable(name).empty()) return otherwise;
  return milliseconds(static_cast<int64_t>(1000 * number_in<double>(name, 0.1, 86400, "")));
}

bool is_loopback(const std::string& address) {
  return address == "localhost" || address.rfind("127.", 0) == 0 || address == "::1";
}

/// The network interface through which peers are reached: as in PyTorch, GLOO_SOCKET_IFNAME or that of the
/// host's name. A group on one machine needs no network.
std::shared_ptr<::gloo::transport::Device> make_device(const std::string& address) {
  const std::string interface = variable("GLOO_SOCKET_IFNAME");
  if (!interface.empty()) return c10d::ProcessGroupGloo::createDeviceForInterface(interface);
  if (is_loopback(address)) return c10d::ProcessGroupGloo::createDeviceForHostname("127.0.0.1");
  return c10d::ProcessGroupGloo::createDefaultDevice();
}

struct Meeting {
  c10::intrusive_ptr<c10d::TCPStore> store;
  c10::intrusive_ptr<c10d::ProcessGroupGloo> gloo;
};

/// Returns when all have come and have connected to one another.
Meeting meet(const ProcessGroupOptions& options) {
  c10d::TCPStoreOptions store_options;
  store_options.port = static_cast<uint16_t>(options.port);
  store_options.isServer = options.rank == 0;
  store_options.waitWorkers = false;
#if TORCH_VERSION_MAJOR > 2 || (TORCH_VERSION_MAJOR == 2 && TORCH_VERSION_MINOR >= 1)
  store_options.useLibUV = false;  // not every build of LibTorch has it
#endif
  store_options.timeout = options.start_timeout;
  Meeting meeting;
  meeting.store = c10::make_intrusive<c10d::TCPStore>(options.address, store_options);
  const auto latest = std::chrono::steady_clock::now() + options.start_timeout;
  for (int64_t come = meeting.store->add("come", 1); come < options.size;
       come = meeting.store->add("come", 0)) {
    if (std::chrono::steady_clock::now() > latest) fail("{} of {} processes have come", come, options.size);
    std::this_thread::sleep_for(milliseconds(20));
  }
  const auto gloo_options = c10d::ProcessGroupGloo::Options::create(kGlooTimeout);
  gloo_options->devices.push_back(make_device(options.address));
  gloo_options->threads = 1;  // operations are done one after the other
  meeting.gloo = c10::make_intrusive<c10d::ProcessGroupGloo>(
      c10::make_intrusive<c10d::PrefixStore>("gloo", meeting.store), options.rank, options.size,
      gloo_options);
  return meeting;
}

/// Ctrl-C before anything has begun: there is nothing to save.
class Stopped : public Error {
 public:
  using Error::Error;
  int exit_code() const override { return stop_exit_code(); }
};

/// On a thread of its own, because some of it waits without a limit (for a port behind a firewall, say); such
/// a thread is left behind.
Meeting meet_in_time(const ProcessGroupOptions& options) {
  std::packaged_task<Meeting()> task([options] { return meet(options); });
  std::future<Meeting> meeting = task.get_future();
  std::thread(std::move(task)).detach();
  const auto latest = std::chrono::steady_clock::now() + options.start_timeout + std::chrono::seconds(2);
  while (meeting.wait_for(milliseconds(50)) != std::future_status::ready) {
    if (stop_requested()) throw Stopped("stopped while waiting for the other processes");
    if (std::chrono::steady_clock::now() > latest)
      fail(
          "all have come, but their connections to one another do not come about; set GLOO_SOCKET_IFNAME to "
          "the "
          "network interface that reaches the other machines");
  }
  return meeting.get();
}

uint8_t* bytes_of(const torch::Tensor& tensor) {
  return static_cast<uint8_t*>(tensor.data_ptr());
}

}  // namespace

struct ProcessGroup::Connection {
  c10::intrusive_ptr<c10d::ProcessGroupGloo> gloo;
  std::unique_ptr<Heartbeat> heartbeat;
  bool broken = false;

  /// Waits for the operation, unless a peer is lost.
  void wait(const c10::intrusive_ptr<c10d::Work>& work, const ProcessGroupOptions& options,
            const std::string& what) {
    for (bool completed = false; true;) {
      try {
        work->wait(milliseconds(completed ? 0 : 200));  // 0: no limit, as nothing is left to wait for
        return;
      } catch (const std::exception& error) {
        // Either the operation failed or these milliseconds have passed, maybe both: ask once more.
        if (!completed && work->isCompleted()) {
          completed = true;
          continue;
        }
        const std::string lost = completed ? reason(error) : heartbeat->lost();
        if (lost.empty()) continue;
        broken = true;
        heartbeat->give_up();
        throw LostPeer(fmt::format(
            "rank {} of {}: lost a peer at '{}': {}; see the output of the other ranks, then start all of "
            "them again to continue from the last checkpoint",
            options.rank, options.size, what, lost));
      }
    }
  }
};

ProcessGroupOptions process_group_options_from_environment() {
  ProcessGroupOptions options;
  if (variable("WORLD_SIZE").empty()) return options;
  options.size = number_in<int>("WORLD_SIZE", 1, 65536, "");
  if (options.size == 1) return options;
  options.rank = number_in<int>("RANK", 0, options.size - 1, "give each process its number from 0");
  options.address = variable("MASTER_ADDR");
  if (options.address.empty())
    fail_usage(
        "the environment variable MASTER_ADDR is not set, but WORLD_SIZE={} asks for several processes; "
        "set it to the host of rank 0",
        options.size);
  options.port = number_in<int>("MASTER_PORT", 1, 65535, "set it to a free port on the host of rank 0");
  if (variable("TORCHELASTIC_USE_AGENT_STORE") == "True")
    fail_usage(
        "torchrun keeps MASTER_PORT={} for itself (TORCHELASTIC_USE_AGENT_STORE=True); start it with "
        "--standalone, or with --rdzv-backend c10d and --rdzv-endpoint on several machines, and with the "
        "environment variable TORCH_DISABLE_SHARE_RDZV_TCP_STORE=1",
        options.port);
  options.peer_timeout = seconds_in("LD_PEER_TIMEOUT", options.peer_timeout);
  options.start_timeout = seconds_in("LD_START_TIMEOUT", options.start_timeout);
  return options;
}

std::unique_ptr<ProcessGroup> ProcessGroup::from_environment() {
  return std::make_unique<ProcessGroup>(process_group_options_from_environment());
}

ProcessGroup::ProcessGroup(const ProcessGroupOptions& options) : options_(options) {
  if (options.size < 1 || options.rank < 0 || options.rank >= options.size)
    fail_usage("rank {} of {} processes; expected a rank from 0 to {}", options.rank, options.size,
               options.size - 1);
  if (options.size == 1) return;
  spdlog::info("rank {} of {}: waiting for the others at {}:{}", options.rank, options.size, options.address,
               options.port);
  try {
    const Meeting meeting = meet_in_time(options);
    connection_ = std::make_unique<Connection>();
    connection_->gloo = meeting.gloo;
    connection_->heartbeat =
        std::make_unique<Heartbeat>(meeting.store, options.rank, options.size, options.peer_timeout);
  } catch (const Stopped&) {
    throw;
  } catch (const std::exception& error) {
    fail(
        "rank {} of {}: cannot meet the other processes at {}:{} within {:g} s (MASTER_ADDR, MASTER_PORT): "
        "{}; "
        "are all ranks running, is the port free and reachable?",
        options.rank, options.size, options.address, options.port,
        std::chrono::duration<double>(options.start_timeout).count(), reason(error));
  }
}

ProcessGroup::~ProcessGroup() {
  // An operation that waits for a lost peer would keep Gloo's destructor waiting, too.
  if (connection_ != nullptr && connection_->broken) (void)connection_->gloo.release();
}

void ProcessGroup::reduce(torch::Tensor& flat, const std::string& what) {
  std::vector<torch::Tensor> tensors = {flat};
  connection_->wait(connection_->gloo->allreduce(tensors), options_, what);
}

void ProcessGroup::sum(const std::vector<torch::Tensor>& tensors, const std::string& what) {
  if (size() == 1 || tensors.empty()) return;
  const torch::NoGradGuard no_grad;
  std::vector<torch::Tensor> parts;
  for (const torch::Tensor& tensor : tensors) {
    if (tensor.scalar_type() != tensors[0].scalar_type())
      fail("'{}': tensors of types {} and {} cannot be summed in one message", what,
           c10::toString(tensors[0].scalar_type()), c10::toString(tensor.scalar_type()));
    parts.push_back(tensor.detach().reshape({-1}));
  }
  torch::Tensor flat = torch::cat(parts).cpu();
  reduce(flat, what);
  int64_t at = 0;
  for (const torch::Tensor& tensor : tensors) {
    tensor.detach().copy_(flat.narrow(0, at, tensor.numel()).view(tensor.sizes()));
    at += tensor.numel();
  }
}

double ProcessGroup::sum(double value, const std::string& what) {
  const torch::Tensor tensor = torch::full({1}, value, torch::kFloat64);
  sum(std::vector<torch::Tensor>{tensor}, what);
  return tensor.item<double>();
}

bool ProcessGroup::any(bool value, const std::string& what) {
  return sum(value ? 1.0 : 0.0, what) > 0;
}

void ProcessGroup::broadcast(const std::vector<torch::Tensor>& tensors, const std::string& what) {
  if (size() == 1) return;
  size_t bytes = 0;
  std::vector<torch::Tensor> here;  // the tensors, or copies of those on another device
  for (const torch::Tensor& tensor : tensors) {
    if (!tensor.is_contiguous()) fail("'{}': a tensor to be sent is not contiguous", what);
    here.push_back(tensor.detach().cpu());
    bytes += tensor.nbytes();
  }
  std::vector<torch::Tensor> flat = {torch::empty({static_cast<int64_t>(bytes)}, torch::kUInt8)};
  const auto for_each = [&](const auto& copy) {
    auto* at = flat[0].data_ptr<uint8_t>();
    for (const torch::Tensor& tensor : here) {
      copy(at, tensor);
      at += tensor.nbytes();
    }
  };
  if (is_root())
    for_each([](uint8_t* at, const torch::Tensor& t) { std::copy_n(bytes_of(t), t.nbytes(), at); });
  connection_->wait(connection_->gloo->broadcast(flat), options_, what);
  if (is_root()) return;
  for_each([](const uint8_t* at, const torch::Tensor& t) { std::copy_n(at, t.nbytes(), bytes_of(t)); });
  for (size_t i = 0; i < tensors.size(); ++i)
    if (!tensors[i].is_cpu()) tensors[i].detach().copy_(here[i]);
}

std::string ProcessGroup::broadcast(const std::string& text, const std::string& what) {
  const torch::Tensor length = torch::full({1}, static_cast<int64_t>(text.size()), torch::kInt64);
  broadcast(std::vector<torch::Tensor>{length}, what);
  std::string received = text;
  received.resize(static_cast<size_t>(length.item<int64_t>()));
  const auto count = static_cast<int64_t>(received.size());
  broadcast(std::vector<torch::Tensor>{torch::from_blob(received.data(), {count}, torch::kUInt8)}, what);
  return received;
}

void ProcessGroup::require_equal(const std::string& text, const std::string& what) {
  const torch::Tensor sums = torch::zeros({size()}, torch::kInt64);
  sums[rank()] = static_cast<int64_t>(checksum(text.data(), text.size()));
  sum({sums}, what);
  std::string others;
  for (int rank = 1; rank < size(); ++rank)
    if (!sums[rank].equal(sums[0])) others += fmt::format("{}{}", others.empty() ? "" : ", ", rank);
  if (!others.empty())
    fail_usage(
        "rank {}: another {} than rank 0 has; start all processes with the same command line and files",
        others, what);
}

void ProcessGroup::barrier(const std::string& what) {
  sum(0.0, what);
}

}  // namespace ld
