// What an import says of the files that it read.
#pragma once

#include <string>
#include <vector>

#include "frame/exr_reader.h"
#include "import/file_views.h"
#include "import/light_parts.h"
#include "import/source_plan.h"

namespace ld {

/// Names of the features that a sample holds, in their order.
std::vector<std::string> feature_list(const SourceSample& sample);
std::vector<std::string> names_of(const std::vector<SourcePart>& parts);

/// Channels of the view that was read which nothing was made of, with their part where there are several.
std::vector<std::string> unused_channels(const ExrReader& exr, const FileViews& views,
                                         const std::vector<SourceSample>& samples,
                                         const std::vector<SourcePart>& parts);

/// "normal: N.X, N.Y, N.Z (world space)"
std::string taken_text(const SourceFeature& source);
/// "diffuse: DiffDir * DiffCol + DiffInd * DiffCol"
std::string taken_text(const SourcePart& part);

/// The program that wrote the file, as far as it says; else what the mapping is about.
std::string generator_of(const ExrReader& exr, const ImportMapping& mapping);

std::string describe(const ViewCamera& camera);

}  // namespace ld
