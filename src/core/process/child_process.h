// Work that may end the process, and other programs, in processes of their own.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace ld {

/// Runs `work` in a copy of this process and waits for it; false when something ended the copy before `work`
/// returned or threw (exceptions are not passed on). A stop that is asked for meanwhile (core/signals.h)
/// reaches the copy, too. Throws Error when the system starts no process. Not for work that uses threads
/// which run already: a copy has none.
bool survives_in_a_child(const std::function<void()>& work);

/// Runs another program, arguments[0] its path, and waits for it; what it prints is added to the file `log`.
/// Its exit code, or 128 + N when signal N ended it. It has a process group of its own, so that an interrupt
/// from the keyboard is ours to handle: a stop that is asked for meanwhile is passed on, once. It does not
/// outlive this process. Throws Error where it cannot be started or the log cannot be written.
int run_child(const std::vector<std::string>& arguments, const std::filesystem::path& log);

}  // namespace ld
