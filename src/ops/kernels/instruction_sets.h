// Which of the instruction sets that the kernels were compiled for they run on: the best that the processor
// has, unless a test asks for another.
#pragma once

#include <string>
#include <vector>

namespace ld {

/// Names of those that this processor has ("AVX3", "AVX2", "SSE4", "SCALAR", ...), the best first.
std::vector<std::string> instruction_sets();

/// Runs the kernels of this process on one of instruction_sets(), the best for an empty name. Throws Error
/// for another name. Not while kernels run.
void use_instruction_set(const std::string& name);

}  // namespace ld
