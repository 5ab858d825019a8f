#include "training/distributed/heartbeat.h"

#include <fmt/format.h>

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <vector>

namespace ld {

using Clock = std::chrono::steady_clock;

/// Shared with the thread, which may outlive the object when the store does not answer.
struct Heartbeat::State {
  c10::intrusive_ptr<c10d::Store> store;
  int rank = 0, size = 0;
  std::chrono::milliseconds timeout{};

  std::mutex mutex;
  std::condition_variable changed;
  std::vector<Clock::time_point> heard;  // when each rank's count last changed
  Clock::time_point answered;            // when the store, at rank 0, last answered
  bool giving_up = false, told = false;  // this process; and whether the others know
  bool others_gave_up = false;
  bool stop = false, ended = false;

  void beat();
};

/// What the thread does until it is stopped or the store fails.
void Heartbeat::State::beat() {
  std::vector<int64_t> counts(static_cast<size_t>(size), -1);
  std::unique_lock<std::mutex> lock(mutex);
  while (!stop || giving_up != told) {
    const bool tell = giving_up && !told;
    lock.unlock();
    std::vector<int64_t> now;
    int64_t gave_up = 0;
    try {
      gave_up = store->add("gave up", tell ? 1 : 0);
      for (int peer = 0; peer < size; ++peer)
        now.push_back(store->add("alive/" + std::to_string(peer), peer == rank ? 1 : 0));
    } catch (const std::exception&) {
      now.clear();  // rank 0 has ended; whether somebody still waits for it shows in lost()
    }
    lock.lock();
    if (now.empty()) break;
    told = told || tell;
    others_gave_up = gave_up > (told ? 1 : 0);
    answered = Clock::now();
    for (size_t peer = 0; peer < now.size(); ++peer)
      if (now[peer] != counts[peer]) heard[peer] = answered;
    counts = now;
    changed.wait_for(lock, std::min<Clock::duration>(timeout / 8, std::chrono::seconds(2)),
                     [&] { return stop || giving_up != told; });
  }
  ended = true;
  changed.notify_all();
}

Heartbeat::Heartbeat(c10::intrusive_ptr<c10d::Store> store, int rank, int size,
                     std::chrono::milliseconds timeout)
    : state_(std::make_shared<State>()) {
  state_->store = std::move(store);
  state_->rank = rank;
  state_->size = size;
  state_->timeout = timeout;
  state_->answered = Clock::now();
  state_->heard.assign(static_cast<size_t>(size), state_->answered);
  std::thread([state = state_] { state->beat(); }).detach();
}

Heartbeat::~Heartbeat() {
  std::unique_lock<std::mutex> lock(state_->mutex);
  state_->stop = true;
  state_->changed.notify_all();
  state_->changed.wait_for(lock, std::chrono::seconds(1), [&] { return state_->ended; });
}

void Heartbeat::give_up() {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  state_->giving_up = true;
  state_->changed.notify_all();
}

std::string Heartbeat::lost() const {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  if (state_->others_gave_up) return "another rank has lost one";
  const Clock::time_point latest = Clock::now() - state_->timeout;
  const auto silent = [&](size_t peer) {
    return fmt::format("nothing was heard of rank {} for {:g} s", peer,
                       std::chrono::duration<double>(state_->timeout).count());
  };
  if (state_->answered < latest) return silent(0);
  for (size_t peer = 0; peer < state_->heard.size(); ++peer)
    if (static_cast<int>(peer) != state_->rank && state_->heard[peer] < latest) return silent(peer);
  return "";
}

}  // namespace ld
