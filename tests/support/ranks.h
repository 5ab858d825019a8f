// A group of processes as threads of one, each with a connection of its own.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <thread>
#include <vector>

#include "core/error.h"
#include "tests/support/free_port.h"
#include "training/distributed/process_group.h"

namespace ld {

/// Runs `work` as every rank of a group on this machine; an Error that it throws is a failure of the test.
inline void run_ranks(int size, const std::function<void(std::unique_ptr<ProcessGroup>)>& work,
                      std::chrono::milliseconds peer_timeout = std::chrono::milliseconds(20'000)) {
  ProcessGroupOptions options;
  options.size = size;
  options.address = "127.0.0.1";
  options.port = free_port();
  options.peer_timeout = peer_timeout;
  options.start_timeout = std::chrono::milliseconds(20'000);
  std::vector<std::thread> ranks;
  for (options.rank = 0; options.rank < size; ++options.rank)
    ranks.emplace_back([options, &work] {
      try {
        work(std::make_unique<ProcessGroup>(options));
      } catch (const Error& error) {
        ADD_FAILURE() << "rank " << options.rank << ": " << error.what();
      }
    });
  for (std::thread& rank : ranks) rank.join();
}

}  // namespace ld
