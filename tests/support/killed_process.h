// Processes that are killed at a moment of the test's choice.
#pragma once

#include <signal.h>
#include <sys/ptrace.h>
#include <sys/wait.h>
#include <unistd.h>

#include <functional>

namespace ld {

enum class Ended { killed, finished, untraceable };

/// Does the work in a child process that is killed when it is about to make its system call number `call`,
/// from 1. All that a process leaves behind it does by system calls; so these are all moments there are.
inline Ended run_until_call(int call, const std::function<void()>& work) {
  constexpr int kUntraceable = 99;
  const pid_t child = fork();
  if (child == 0) {
    if (ptrace(PTRACE_TRACEME, 0, nullptr, nullptr) != 0) _exit(kUntraceable);
    raise(SIGSTOP);
    work();
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  for (int stops = 0; WIFSTOPPED(status) && stops < 2 * call - 1;) {  // a call stops it before and after
    ptrace(PTRACE_SETOPTIONS, child, nullptr, PTRACE_O_TRACESYSGOOD);
    ptrace(PTRACE_SYSCALL, child, nullptr, nullptr);
    waitpid(child, &status, 0);
    if (WIFSTOPPED(status) && WSTOPSIG(status) == (SIGTRAP | 0x80)) ++stops;
  }
  if (WIFSTOPPED(status)) {
    kill(child, SIGKILL);
    waitpid(child, &status, 0);
    return Ended::killed;
  }
  return WIFEXITED(status) && WEXITSTATUS(status) == 0 ? Ended::finished : Ended::untraceable;
}

}  // namespace ld
