#include "doctor/doctor.h"

#include <algorithm>
#include <mutex>
#include <utility>

#include "core/error.h"
#include "core/threads.h"
#include "doctor/check.h"

namespace ld {
namespace fs = std::filesystem;
namespace {

struct NamedCheck {
  const char* name;
  MakeCheck make;
};

/// In the order of the report; a family's findings carry its name.
constexpr NamedCheck kChecks[] = {
    {"values", make_value_check},       {"fireflies", make_firefly_check}, {"ranges", make_range_check},
    {"normals", make_normal_check},     {"depth", make_depth_check},       {"guides", make_guide_check},
    {"seeds", make_seed_check},         {"filter", make_filter_check},     {"splits", make_split_check},
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

/// `wanted` of the frames, evenly spread.
std::vector<ManifestFrame> chosen_frames(const Manifest& manifest, int64_t wanted) {
  const auto all = static_cast<int64_t>(manifest.frames.size());
  if (wanted <= 0 || wanted >= all) return manifest.frames;
  std::vector<ManifestFrame> chosen;
  for (int64_t i = 0; i < wanted; ++i)
    chosen.push_back(manifest.frames[static_cast<size_t>(i * all / wanted)]);
  return chosen;
}

}  // namespace

Diagnosis examine_dataset(const fs::path& folder, const Manifest& manifest, const DoctorOptions& options) {
  const std::vector<ManifestFrame> frames = chosen_frames(manifest, options.frames);
  const auto checks = make_checks(frames.size());
  std::vector<std::string> complaints(frames.size());
  parallel_for(static_cast<int64_t>(frames.size()), options.threads, [&](int64_t i) {
    const auto index = static_cast<size_t>(i);
    try {
      const Evidence evidence = read_evidence(folder, frames[index]);
      for (const auto& check : checks) check->look(index, evidence);
    } catch (const Error& error) {
      complaints[index] = error.what();
    }
  });
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
