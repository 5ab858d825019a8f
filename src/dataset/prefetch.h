// Numbered items made ahead of their use on background threads. What is made depends on its number alone, so
// the number of threads changes nothing but the time.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "core/threads.h"

namespace ld {

template <class Item>
class Prefetch {
 public:
  /// `make` is called from all workers at a time; with no workers, from get(). At most workers + 1 items wait
  /// or are being made. Throws Error when the system refuses to start one.
  Prefetch(std::function<Item(int64_t)> make, int workers) : make_(std::move(make)), ahead_(workers + 1) {
    threads_ = start_threads(
        workers, [this] { work(); }, [this] { stop(); });
  }

  ~Prefetch() {
    stop();
    for (std::thread& thread : threads_) thread.join();
  }
  Prefetch(const Prefetch&) = delete;
  Prefetch& operator=(const Prefetch&) = delete;

  /// The item of that number; those after it are made from now on. What `make` threw for it is thrown here.
  Item get(int64_t number) {
    if (threads_.empty()) return make_(number);
    std::unique_lock<std::mutex> lock(mutex_);
    if (number != wanted_) {  // the first call, or a jump: what has been made is of no use
      done_.clear();
      wanted_ = next_ = number;
      ++round_;
      changed_.notify_all();
    }
    changed_.wait(lock, [&] { return done_.count(number) > 0; });
    Result result = std::move(done_.at(number));
    done_.erase(number);
    wanted_ = number + 1;
    lock.unlock();
    changed_.notify_all();
    if (result.error) std::rethrow_exception(result.error);
    return std::move(*result.item);
  }

 private:
  struct Result {
    std::optional<Item> item;
    std::exception_ptr error;
  };

  void stop() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      stop_ = true;
    }
    changed_.notify_all();
  }

  void work() {
    std::unique_lock<std::mutex> lock(mutex_);
    for (;;) {
      changed_.wait(lock, [&] { return stop_ || (round_ > 0 && next_ < wanted_ + ahead_); });
      if (stop_) return;
      const int64_t number = next_++, round = round_;
      lock.unlock();
      Result result = make(number);
      lock.lock();
      if (round == round_) done_.emplace(number, std::move(result));
      changed_.notify_all();
    }
  }

  Result make(int64_t number) const {
    Result result;
    try {
      result.item.emplace(make_(number));
    } catch (const std::exception&) {
      result.error = std::current_exception();
    }
    return result;
  }

  const std::function<Item(int64_t)> make_;
  const int64_t ahead_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<int64_t, Result> done_;
  int64_t wanted_ = -1;  // the number that the caller will probably ask for
  int64_t next_ = 0;     // the next one to be made
  int64_t round_ = 0;    // of jumps: results of an earlier one are thrown away
  bool stop_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace ld
