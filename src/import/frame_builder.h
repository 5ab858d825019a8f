// Fills a frame from the files of other renderers, sample by sample.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "import/frame_import.h"
#include "import/import_texts.h"
#include "import/sample_window.h"

namespace ld {

/// All files are surveyed, in their order, then read in the same order. Throws Error for a file that differs
/// from the first in what it holds, that changes meanwhile, or that repeats a sample.
class FrameBuilder {
 public:
  FrameBuilder(ImportMapping mapping, std::optional<ViewCamera> camera, bool allow_identical,
               std::vector<std::string> also);

  /// Looks at a file's header only.
  void survey(const std::filesystem::path& path);
  void read(const std::filesystem::path& path);
  ImportedFrame finish();

 private:
  using Planes = std::vector<std::vector<float>>;

  /// Features that one plane serves for all samples are looked for in the first file only.
  std::vector<SourceSample> plan_for(const ExrReader& exr) const;
  /// Those of a file's first sample that are asked for.
  std::vector<SourcePart> chosen_parts(const ExrReader& exr) const;
  /// Those of a file's first sample that make features; both or none.
  std::vector<SourcePart> split_parts(const ExrReader& exr) const;
  /// [R, G, B]
  Planes read_part(const ExrReader& exr, const SourcePart& part);
  /// Direct and emitted light of the sample that was read last, and as its indirect light what is left.
  void split_light(const ExrReader& exr, const std::vector<SourcePart>& parts);
  void read_parts(const ExrReader& exr, const std::vector<SourcePart>& parts);
  void start(const ExrReader& exr, const SourceSample& sample);
  /// When all files have been surveyed, with the first of them.
  void allocate(const ExrReader& exr, const SourceSample& sample);
  void read_sample(const ExrReader& exr, const SourceSample& sample, const std::string& where);
  void leave_out(const std::string& name);
  /// A pass that was never written says that all rays escaped; normals say that they did not.
  void drop_useless_depth();
  /// Objects that nobody numbered are all the same.
  void drop_useless_id();

  ImportMapping mapping_;
  std::optional<ViewCamera> camera_;
  bool allow_identical_;
  std::vector<std::string> also_, parts_;  // patterns, and the names of the light parts that they fit
  std::string first_file_;
  FrameWindow window_;
  Extent extent_;  // when it is known
  std::vector<std::string> features_;
  std::vector<const FeatureMapping*> first_mapping_;
  std::vector<Planes> shared_;               // converted, of the features that all samples share; else empty
  bool has_alpha_ = false, splits_ = false;  // direct, indirect and emitted light apart
  int spp_ = 0, next_ = 0;
  std::optional<Converter> converter_;
  std::map<uint64_t, std::string> seen_;
  ImportedFrame result_;
};

}  // namespace ld
