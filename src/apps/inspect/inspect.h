// What a path is and what is wrong with it: the library behind ld_inspect.
#pragma once

#include <cstdint>
#include <filesystem>

#include "apps/inspect/inspect_report.h"

namespace ld {

struct InspectOptions {
  bool verify = false;  // compare all checksums of a data set, which reads every byte of it
  int64_t frames = 0;   // of a data set to read, spread over it; 0: all. Headers are read of all frames
  int threads = 1;
};

/// Recognises the path and inspects it. Throws Error only when there is no such path; all else is in the
/// report.
Report inspect(const std::filesystem::path& path, const InspectOptions& options);

// What inspect() hands on to, by kind. Each fills kind, facts, warnings and problems of a report with a path.
void inspect_exr(Report& report);
void inspect_dataset(Report& report, const InspectOptions& options);
void inspect_config(Report& report);
void inspect_onnx(Report& report);
void inspect_tensors(Report& report);  // a .safetensors file: weights or other tensors
void inspect_checkpoint(Report& report);
void inspect_run(Report& report);

}  // namespace ld
