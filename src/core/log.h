// Messages for people, on standard error; standard output carries results only.
#pragma once

#include <spdlog/spdlog.h>

#include <filesystem>
#include <string>

namespace ld {

/// Sends spdlog's default logger to standard error with "[ld_train] message" lines; call once at start.
void init_log(const std::string& program);

/// Also appends every later line to a file (with the time of day). Throws Error when it cannot be opened.
void add_log_file(const std::filesystem::path& path);

}  // namespace ld
