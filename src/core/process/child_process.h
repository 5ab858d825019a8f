// Work that may end the process, done in a process of its own.
#pragma once

#include <functional>

namespace ld {

/// Runs `work` in a copy of this process and waits for it; false when something ended the copy before `work`
/// returned or threw (exceptions are not passed on). A stop that is asked for meanwhile (core/signals.h)
/// reaches the copy, too. Throws Error when the system starts no process. Not for work that uses threads
/// which run already: a copy has none.
bool survives_in_a_child(const std::function<void()>& work);

}  // namespace ld
