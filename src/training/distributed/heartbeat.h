// Tells a peer that is busy from one that is gone: a thread of each process counts up its own number in the
// store that all share and watches those of the others.
#pragma once

#include <torch/csrc/distributed/c10d/Store.hpp>

#include <chrono>
#include <memory>
#include <string>

namespace ld {

class Heartbeat {
 public:
  Heartbeat(c10::intrusive_ptr<c10d::Store> store, int rank, int size, std::chrono::milliseconds timeout);
  /// Stops the thread; leaves it behind if the store does not answer.
  ~Heartbeat();
  Heartbeat(const Heartbeat&) = delete;
  Heartbeat& operator=(const Heartbeat&) = delete;

  /// Tells the others that this process cannot go on, so that they need not find out for themselves.
  void give_up();

  /// Which peer is lost, for messages; "" while all live.
  std::string lost() const;

 private:
  struct State;
  std::shared_ptr<State> state_;
};

}  // namespace ld
