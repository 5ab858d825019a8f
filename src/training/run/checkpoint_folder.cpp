#include "training/run/checkpoint_folder.h"

#include <algorithm>
#include <system_error>

#include "core/error.h"
#include "core/file_io.h"
#include "core/log.h"
#include "core/unique_name.h"
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

bool ends_with(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

// A checkpoint that is about to be replaced by one of the same step: .step_00000500.replaced
constexpr const char* kReplaced = ".replaced";

fs::path replaced_path(const fs::path& folder, const std::string& name) {
  return folder / ("." + name + kReplaced);
}

/// Names in the folder; none where there is no folder.
std::vector<std::string> entries_of(const fs::path& folder) {
  std::vector<std::string> found;
  if (fs::exists(folder))
    for (const fs::directory_entry& entry : fs::directory_iterator(folder))
      found.push_back(entry.path().filename().string());
  return found;
}

/// Points the link at the checkpoint, in one step: a reader sees the old one or the new one.
void set_link(const fs::path& link, const std::string& target) {
  const fs::path temporary =
      link.parent_path() / fmt::format(".{}.{}.partial", link.filename().string(), unique_name());
  fs::create_symlink(target, temporary);
  fs::rename(temporary, link);
}

std::string link_target(const fs::path& link) {
  std::error_code error;  // no such link: no target
  const fs::path target = fs::read_symlink(link, error);
  return error ? "" : target.string();
}

/// What verify_checkpoint() complains about; empty for a whole checkpoint.
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

CheckpointFolder::CheckpointFolder(const fs::path& run, int64_t keep)
    : folder_(run / "checkpoints"), keep_(keep) {}

std::vector<std::string> CheckpointFolder::names() const {
  std::vector<std::string> found;
  for (const std::string& name : entries_of(folder_))
    if (starts_with(name, "step_")) found.push_back(name);
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
  const fs::path partial = folder_ / fmt::format(".{}.{}.partial", name, unique_name());
  const fs::path replaced = replaced_path(folder_, name);
  try {
    guarded([&] {
      make_folder(partial);
      fill(partial);
      write_checkpoint_checksums(partial);
      flush_to_disk(partial);
      // A run that was stopped while it validated, for example, has a checkpoint of this step already, maybe
      // its only one. It stays until the new one is in place; after a kill bring_back_replaced() finds it.
      if (fs::exists(folder_ / name)) {
        fs::remove_all(replaced);
        fs::rename(folder_ / name, replaced);
      }
      fs::rename(partial, folder_ / name);
      flush_to_disk(folder_);
      set_link(folder_ / "last", name);
      if (best) set_link(folder_ / "best", name);
      flush_to_disk(folder_);
      remove_surplus();
    });
  } catch (const Error&) {
    std::error_code ignored;  // the error that led here matters more than the space
    fs::remove_all(partial, ignored);
    if (!fs::exists(folder_ / name, ignored)) fs::rename(replaced, folder_ / name, ignored);
    throw;
  }
}

void CheckpointFolder::remove_surplus() const {
  const std::string best = link_target(folder_ / "best");
  const std::vector<std::string> all = names();
  for (size_t i = static_cast<size_t>(keep_); i < all.size(); ++i)
    if (all[i] != best) fs::remove_all(folder_ / all[i]);
  for (const std::string& name : entries_of(folder_))  // left by killed processes, or replaced just now
    if (starts_with(name, ".step_") || (starts_with(name, ".") && ends_with(name, ".partial")))
      fs::remove_all(folder_ / name);
}

/// A process that was killed between two renames has left a checkpoint aside and nothing in its place: it is
/// renamed back. A process that was killed later has left one that is replaced: it is removed.
void CheckpointFolder::bring_back_replaced() const {
  for (const std::string& entry : entries_of(folder_)) {
    if (!starts_with(entry, ".step_") || !ends_with(entry, kReplaced)) continue;
    const std::string name = entry.substr(1, entry.size() - 1 - std::string(kReplaced).size());
    if (fs::exists(folder_ / name))
      fs::remove_all(folder_ / entry);
    else
      fs::rename(folder_ / entry, folder_ / name);
  }
}

std::optional<fs::path> CheckpointFolder::newest_whole() {
  guarded([&] { bring_back_replaced(); });
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
    bring_back_replaced();
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
