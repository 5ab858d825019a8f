#include "training/checkpoint_folder.h"

#include <unistd.h>

#include <algorithm>
#include <system_error>

#include "core/error.h"
#include "core/file_io.h"
#include "core/log.h"
#include "weights/checkpoint_files.h"

namespace ld {
namespace fs = std::filesystem;
namespace {

std::string name_of(int64_t step) {
  return fmt::format("step_{:08}", step);
}

/// A number of steps may outgrow its eight digits.
bool is_newer(const std::string& name, const std::string& other) {
  return name.size() != other.size() ? name.size() > other.size() : name > other;
}

bool starts_with(const std::string& text, const std::string& start) {
  return text.rfind(start, 0) == 0;
}

/// Points the link at the checkpoint, in one step: a reader sees the old one or the new one.
void set_link(const fs::path& link, const std::string& target) {
  const fs::path temporary = fmt::format("{}.{}.partial", link.string(), getpid());
  fs::remove(temporary);
  fs::create_symlink(target, temporary);
  fs::rename(temporary, link);
}

std::string link_target(const fs::path& link) {
  std::error_code error;  // no such link: no target
  const fs::path target = fs::read_symlink(link, error);
  return error ? "" : target.string();
}

/// What verify_checkpoint() says; empty for a whole one.
std::string fault_of(const fs::path& checkpoint) {
  try {
    verify_checkpoint(checkpoint);
    return "";
  } catch (const Error& error) {
    return error.what();
  }
}

/// Does the work; what the file system refuses becomes an Error.
template <class Work>
void guarded(const Work& work) {
  try {
    work();
  } catch (const fs::filesystem_error& error) {
    fail("{}", error.what());
  }
}

}  // namespace

void verify_checkpoint(const fs::path& checkpoint) {
  for (const char* name : kCheckpointFiles) verify_checkpoint_file(checkpoint, name);
}

CheckpointFolder::CheckpointFolder(fs::path run, int64_t keep)
    : folder_(std::move(run) / "checkpoints"), keep_(keep) {}

std::vector<std::string> CheckpointFolder::names() const {
  std::vector<std::string> found;
  if (fs::exists(folder_))
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_))
      if (starts_with(entry.path().filename().string(), "step_"))
        found.push_back(entry.path().filename().string());
  std::sort(found.begin(), found.end(), is_newer);
  return found;
}

bool CheckpointFolder::holds(int64_t step) const {
  return fs::exists(folder_ / name_of(step));
}

bool CheckpointFolder::begun() const {
  return !names().empty() || !link_target(folder_ / "last").empty();
}

void CheckpointFolder::write(int64_t step, const std::function<void(const fs::path&)>& fill, bool best) {
  const std::string name = name_of(step);
  const fs::path partial = folder_ / fmt::format(".{}.{}.partial", name, getpid());
  try {
    guarded([&] {
      make_folder(folder_);
      fs::remove_all(partial);
      make_folder(partial);
      fill(partial);
      write_checkpoint_checksums(partial);
      flush_to_disk(partial);
      fs::remove_all(folder_ / name);  // of a run that went back behind this step
      fs::rename(partial, folder_ / name);
      flush_to_disk(folder_);
      set_link(folder_ / "last", name);
      if (best) set_link(folder_ / "best", name);
      flush_to_disk(folder_);
      remove_surplus();
    });
  } catch (const Error&) {
    std::error_code ignored;  // the space matters, but the error that led here matters more
    fs::remove_all(partial, ignored);
    throw;
  }
}

void CheckpointFolder::remove_surplus() const {
  const std::string best = link_target(folder_ / "best");
  const std::vector<std::string> all = names();
  for (size_t i = static_cast<size_t>(keep_); i < all.size(); ++i)
    if (all[i] != best) fs::remove_all(folder_ / all[i]);
  std::vector<fs::path> unfinished;  // of processes that were killed
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_))
    if (starts_with(entry.path().filename().string(), ".step_")) unfinished.push_back(entry.path());
  for (const fs::path& path : unfinished) fs::remove_all(path);
}

std::optional<fs::path> CheckpointFolder::newest_whole() {
  const std::vector<std::string> all = names();
  const std::string last = link_target(folder_ / "last");
  if (all.empty()) {
    if (last.empty()) return std::nullopt;
    fail("{} names {}, which is not there; bring it back, or begin a new run with another --out",
         (folder_ / "last").string(), last);
  }
  std::vector<std::string> faults;
  for (const std::string& name : all) {
    const std::string fault = fault_of(folder_ / name);
    if (!fault.empty()) {
      faults.push_back(fault);
      continue;
    }
    guarded([&] {
      for (size_t i = 0; i < faults.size(); ++i) {
        const fs::path aside = folder_ / ("damaged_" + all[i]);
        spdlog::warn("checkpoint {} is damaged ({}); set aside as {}", all[i], faults[i], aside.string());
        fs::remove_all(aside);
        fs::rename(folder_ / all[i], aside);
      }
      if (!faults.empty()) spdlog::warn("falling back to checkpoint {}", name);
      if (last == name) return;
      if (faults.empty())
        spdlog::warn("{} {}; the newest whole checkpoint is {}", (folder_ / "last").string(),
                     last.empty() ? "is missing" : "names " + last, name);
      set_link(folder_ / "last", name);
    });
    return folder_ / name;
  }
  std::string list;
  for (size_t i = 0; i < all.size(); ++i) list += fmt::format("; {}: {}", all[i], faults[i]);
  fail("{}: no checkpoint is whole; begin a new run with another --out{}", folder_.string(), list);
}

std::optional<fs::path> CheckpointFolder::newest_whole_until(int64_t step) const {
  for (const std::string& name : names())
    if (!is_newer(name, name_of(step)) && fault_of(folder_ / name).empty()) return folder_ / name;
  return std::nullopt;
}

void CheckpointFolder::go_back_to(int64_t step) {
  const std::string name = name_of(step);
  guarded([&] {
    // The links first: they never name what is not there.
    for (const char* link : {"last", "best"}) {
      if (!is_newer(link_target(folder_ / link), name)) continue;
      if (step > 0)
        set_link(folder_ / link, name);
      else
        fs::remove(folder_ / link);
    }
    for (const std::string& newer : names()) {
      if (!is_newer(newer, name)) continue;
      const fs::path removed = folder_ / ("." + newer + ".removed");  // remove_surplus() finds it, too
      fs::remove_all(removed);
      fs::rename(folder_ / newer, removed);
      fs::remove_all(removed);
    }
    if (fs::exists(folder_)) flush_to_disk(folder_);
  });
}

bool CheckpointFolder::restore_best(int64_t step) {
  const fs::path link = folder_ / "best";
  const std::string target = link_target(link), name = name_of(step);
  const std::string fault = fault_of(folder_ / name);
  if (!fault.empty()) {
    spdlog::warn("the best checkpoint, {}, is not whole ({})", name, fault);
    return false;
  }
  if (target == name) return true;
  spdlog::warn("{} {}; the best checkpoint is {}", link.string(),
               target.empty() ? "is missing" : "names " + target, name);
  guarded([&] { set_link(link, name); });
  return true;
}

}  // namespace ld
