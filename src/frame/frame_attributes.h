// FrameInfo as attributes of an EXR header (docs/data_format.md lists them).
#pragma once

#include <ImfHeader.h>

#include <optional>
#include <string>

#include "frame/frame.h"

namespace ld {

/// OpenEXR's standard attributes, frame/camera_matrices.h.
constexpr const char *kWorldToCamera = "worldToCamera", *kWorldToNdc = "worldToNDC";
/// None where it is not there, of another type or not finite: renderers write it for people, too.
std::optional<Matrix4> read_matrix(const Imf::Header& header, const char* name);

/// Adds the schema version, the number of samples and `info` to a header.
void write_attributes(Imf::Header& header, const FrameInfo& info, int spp);

/// Reads what a header has; the rest stays empty or 0. `spp` becomes -1 when the header does not say. Throws
/// Error for a newer schema version and for values of a wrong type; `path` names the file in complaints.
FrameInfo read_attributes(const Imf::Header& header, const std::string& path, int& spp);

/// A reference's floor as one attribute "ldFloor.NAME" for each metric. Reading takes doubles and floats;
/// throws Error for another type and for NaN.
void write_floor(Imf::Header& header, const ReferenceFloor& floor);
ReferenceFloor read_floor(const Imf::Header& header, const std::string& path);

/// A header without channels for a picture of this size, with its data and display window.
Imf::Header header_with(int width, int height, const Windows& windows);
Windows windows_of(const Imf::Header& header);

}  // namespace ld
