// Processes, on one machine or several, that train one network together: collective operations through
// LibTorch's own c10d with Gloo, found by the environment variables that PyTorch users know (torchrun sets
// them; docs/distributed.md has Slurm and mpirun).
//
// Every process must make the same calls in the same order. What differs between versions of LibTorch ends
// here.
#pragma once

#include <torch/torch.h>

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "core/error.h"

namespace ld {

/// A peer has ended or cannot be heard any more.
class LostPeer : public Error {
 public:
  using Error::Error;
};

struct ProcessGroupOptions {
  int rank = 0, size = 1;
  std::string address;                               // of rank 0
  int port = 0;                                      // that rank 0 listens on
  std::chrono::milliseconds peer_timeout{30'000};    // a peer silent for so long is lost
  std::chrono::milliseconds start_timeout{300'000};  // to wait for all to start
};

/// RANK, WORLD_SIZE, MASTER_ADDR and MASTER_PORT, and the timeouts in seconds LD_PEER_TIMEOUT and
/// LD_START_TIMEOUT. Without WORLD_SIZE, or where it is 1, a group of one. Throws UsageError naming the
/// variable that is missing or wrong.
ProcessGroupOptions process_group_options_from_environment();

/// A group of one does nothing and costs nothing, so callers need not ask.
///
/// All operations throw LostPeer when a peer is lost: its process has ended, or nothing was heard of it for
/// peer_timeout. A peer that is merely busy (validating, writing a checkpoint) is waited for as long as it
/// takes: a thread of each process says every moment that the process lives. After such an error the group is
/// of no more use; destroying it does not wait for anybody.
class ProcessGroup {
 public:
  /// Waits until all have started. Throws UsageError for options that cannot be, Error when rank 0 cannot be
  /// reached or somebody is missing after start_timeout.
  explicit ProcessGroup(const ProcessGroupOptions& options);
  ~ProcessGroup();
  ProcessGroup(const ProcessGroup&) = delete;
  ProcessGroup& operator=(const ProcessGroup&) = delete;

  static std::unique_ptr<ProcessGroup> from_environment();

  int rank() const { return options_.rank; }
  int size() const { return options_.size; }
  /// The one that writes files and talks: rank 0.
  bool is_root() const { return options_.rank == 0; }

  /// Replaces the tensors, all of one floating-point type or int64 and on one device, by their sums over all
  /// processes: one message for all of them, the same bits on every rank and whenever it is done again with
  /// as many processes. A NaN on one rank is a NaN on all; so whoever looks for one after the sum decides as
  /// everybody does. Gloo sends from the CPU: tensors on another device are copied there and back, here and
  /// in broadcast(). `what` stands in the text of errors.
  void sum(const std::vector<torch::Tensor>& tensors, const std::string& what);
  double sum(double value, const std::string& what);

  /// Whether it is true on any rank.
  bool any(bool value, const std::string& what);

  /// Replaces contiguous tensors of any type, the same shapes everywhere, by those of rank 0.
  void broadcast(const std::vector<torch::Tensor>& tensors, const std::string& what);
  std::string broadcast(const std::string& text, const std::string& what);

  /// UsageError on every rank, naming those that differ from rank 0, unless all gave the same text.
  void require_equal(const std::string& text, const std::string& what);

  /// Returns when all have arrived.
  void barrier(const std::string& what);

 private:
  struct Connection;
  void reduce(torch::Tensor& flat, const std::string& what);

  ProcessGroupOptions options_;
  std::unique_ptr<Connection> connection_;  // none in a group of one
};

}  // namespace ld
