#include "ops/blas_kernels.h"

#include <dlfcn.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <vector>

#include "core/log.h"

namespace ld {
namespace {

/// The arguments of this process, as the kernel keeps them: each ends with a 0.
std::vector<std::string> arguments() {
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  std::vector<std::string> result;
  for (size_t begin = 0, end = 0; (end = text.find('\0', begin)) != std::string::npos; begin = end + 1)
    result.push_back(text.substr(begin, end - begin));
  return result;
}

}  // namespace

std::string blas_kernels() {
  // OpenBLAS comes with LibTorch, so it is asked for by name rather than linked.
  using CoreName = char* (*)();
  const auto core_name = reinterpret_cast<CoreName>(dlsym(RTLD_DEFAULT, "openblas_get_corename"));
  return core_name == nullptr ? "" : core_name();
}

std::string better_blas_kernels(const std::string& kernels, bool avx2, bool avx512) {
  constexpr std::array<const char*, 11> without_avx2 = {
      "Prescott", "Core2",   "Penryn",    "Dunnington",  "Atom",        "Nehalem",
      "Nano",     "Opteron", "Barcelona", "Sandybridge", "Opteron_SSE3"};
  if (!avx2) return "";
  for (const char* old : without_avx2)
    if (kernels == old) return avx512 ? "SkylakeX" : "Haswell";
  return "";
}

std::string better_blas_kernels() {
#if defined(__x86_64__)
  if (std::getenv("OPENBLAS_CORETYPE") != nullptr) return "";
  const bool avx2 = __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0;
  const bool avx512 = __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512cd") != 0 &&
                      __builtin_cpu_supports("avx512bw") != 0 && __builtin_cpu_supports("avx512dq") != 0 &&
                      __builtin_cpu_supports("avx512vl") != 0;
  return better_blas_kernels(blas_kernels(), avx2, avx512);
#else
  return "";
#endif
}

void choose_blas_kernels() {
  const std::string better = better_blas_kernels();
  std::vector<std::string> args = arguments();
  if (better.empty() || args.empty()) return;
  const std::string kernels = blas_kernels();
  spdlog::debug("OpenBLAS chose its {} kernels; starting again with {}", kernels, better);
  setenv("OPENBLAS_CORETYPE", better.c_str(), 1);
  std::vector<char*> argv;
  for (std::string& arg : args) argv.push_back(arg.data());
  argv.push_back(nullptr);
  execv("/proc/self/exe", argv.data());
  // Only a failure returns: go on with the slow kernels.
  spdlog::warn("OpenBLAS runs its slow {} kernels on this processor; set OPENBLAS_CORETYPE={}", kernels,
               better);
}

}  // namespace ld
