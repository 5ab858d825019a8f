#include "doctor/doctor.h"

#include <algorithm>
#include <mutex>
#include <utility>

#include "core/error.h"
#include "core/progress.h"
#include "core/signals.h"
#include "core/threads.h"
#include "doctor/doctor_check.h"

namespace ld {
namespace fs = std::filesystem;
namespace {

struct NamedCheck {
  const char* name;
  MakeCheck make;
};

/// In the order of the report; a family's findings carry its name.
constexpr NamedCheck kChecks[] = {
    {"values", make_value_check},
    {"fireflies", make_firefly_check},
    {"ranges", make_range_check},
    {"normals", make_normal_check},
    {"depth", make_depth_check},
    {"guides", make_guide_check},
    {"filter guides", make_filter_guide_check},
    {"seeds", make_seed_check},
    {"filter", make_filter_check},
    {"splits", make_split_check},
    {"features", make_variation_check},
};

std::vector<std::unique_ptr<Check>> make_checks(size_t frames) {
  std::vector<std::unique_ptr<Check>> checks;
  for (const NamedCheck& check : kChecks) checks.push_back(check.make(frames));
  return checks;
}

void conclude(const std::vector<std::unique_ptr<Check>>& checks, Diagnosis& diagnosis) {
  for (size_t i = 0; i < checks.size(); ++i) {
    const size_t before = diagnosis.findings.size();
    checks[i]->conclude(diagnosis);
    for (size_t f = before; f < diagnosis.findings.size(); ++f) diagnosis.findings[f].check = kChecks[i].name;
  }
}

struct Choice {
  std::vector<ManifestFrame> examined, passed_over;
};

/// `wanted` of the frames, evenly spread; 0: all.
Choice choose_frames(const Manifest& manifest, int64_t wanted) {
  const auto all = static_cast<int64_t>(manifest.frames.size());
  if (wanted <= 0 || wanted >= all) return {manifest.frames, {}};
  Choice choice;
  for (int64_t i = 0; i < all; ++i) {
    const bool next = i == static_cast<int64_t>(choice.examined.size()) * all / wanted;
    (next ? choice.examined : choice.passed_over).push_back(manifest.frames[static_cast<size_t>(i)]);
  }
  return choice;
}

}  // namespace

Diagnosis examine_dataset(const fs::path& folder, const Manifest& manifest, const DoctorOptions& options) {
  const Choice choice = choose_frames(manifest, options.frames);
  const std::vector<ManifestFrame>& frames = choice.examined;
  const auto checks = make_checks(frames.size());
  std::vector<std::string> complaints(frames.size());
  Progress progress("frames", static_cast<int64_t>(frames.size()));
  parallel_for(static_cast<int64_t>(frames.size()), options.threads, [&](int64_t i) {
    if (stop_requested()) return;
    const auto index = static_cast<size_t>(i);
    try {
      const Evidence evidence = read_evidence(folder, frames[index]);
      for (const auto& check : checks) check->look(index, evidence);
    } catch (const Error& error) {
      complaints[index] = error.what();
    }
    progress.advance();
  });
  for (const ManifestFrame& frame : choice.passed_over) {
    const FrameHeader header = read_frame_header(frame_path(folder, frame.name));
    for (const auto& check : checks) check->pass_over(frame.split, header);
  }
  Diagnosis diagnosis;
  diagnosis.facts["examined_frames"] = frames.size();
  for (size_t i = 0; i < frames.size(); ++i)
    if (!complaints[i].empty())
      diagnosis.add(Severity::problem, complaints[i], {frames[i].name}, nlohmann::ordered_json::object());
  for (Finding& finding : diagnosis.findings) finding.check = "files";
  conclude(checks, diagnosis);
  return diagnosis;
}

Diagnosis examine_frame(const Evidence& evidence) {
  const auto checks = make_checks(1);
  for (const auto& check : checks) check->look(0, evidence);
  Diagnosis diagnosis;
  conclude(checks, diagnosis);
  return diagnosis;
}

std::vector<std::string> check_names() {
  std::vector<std::string> names = {"files"};
  for (const NamedCheck& check : kChecks) names.emplace_back(check.name);
  return names;
}

}  // namespace ld
