#include <algorithm>

#include "core/checksum.h"
#include "core/error.h"
#include "frame/frame_file.h"
#include "frame/manifest.h"
#include "import/frame_import.h"

namespace ld {
namespace fs = std::filesystem;
namespace {

/// A reference that is one of the samples teaches a network to leave the noise alone.
void check_other_noise(const DataSetPlace& place, const Frame& frame, const Image& reference) {
  const auto size = static_cast<std::ptrdiff_t>(3 * frame.plane_size());
  for (int s = 0; s < frame.spp; ++s)
    if (std::equal(reference.plane(0), reference.plane(0) + size, frame.plane(s, kRadianceOffset)))
      fail("{}: sample {} is the reference itself; render a converged picture with another seed", place.name,
           s);
}

}  // namespace

void check_place(const DataSetPlace& place) {
  ManifestFrame entry;
  entry.name = place.name;
  entry.split = place.split;
  check_entry(entry, place.folder.string());
  if (fs::path(place.name).extension() == ".reference")
    fail_usage("'{}' would be the reference of a frame '{}'; choose another --name", place.name,
               fs::path(place.name).stem().string());
  if (!fs::exists(place.folder / "manifest.json")) return;
  const Manifest manifest = read_manifest(place.folder);
  if (!manifest.recipe.empty() || manifest.seed != 0)
    fail("{}: holds frames that ld_render made from a recipe; choose another folder for imported ones",
         place.folder.string());
  if (!place.sequence || !place.position) return;
  for (const ManifestFrame& frame : manifest.frames)
    if (frame.sequence == place.sequence && frame.position == place.position && frame.name != place.name)
      fail_usage(
          "{}: the frame '{}' is at position {} of sequence {} already, so '{}' cannot be; choose another "
          "--position or --sequence, or the name '{}' to replace it",
          place.folder.string(), frame.name, *place.position, *place.sequence, place.name, frame.name);
}

void add_to_data_set(const DataSetPlace& place, const Frame& frame, const ImportedPicture& reference) {
  if (frame.width != reference.image.width || frame.height != reference.image.height ||
      !(frame.info.windows == reference.windows))
    fail(
        "{}: the samples have {} x {} pixels and the reference {} x {}, or their data and display windows "
        "differ; "
        "render the two at one size",
        place.name, frame.width, frame.height, reference.image.width, reference.image.height);
  check_other_noise(place, frame, reference.image);
  check_place(place);  // others may have added frames since
  ManifestFrame entry;
  entry.name = place.name;
  entry.split = place.split;
  entry.sequence = place.sequence;
  entry.position = place.position;
  write_image(reference_path(place.folder, place.name), reference.image, reference.windows);
  write_frame(frame_path(place.folder, place.name), frame);
  entry.checksum = file_checksum(frame_path(place.folder, place.name));
  entry.reference_checksum = file_checksum(reference_path(place.folder, place.name));
  Manifest addition;
  addition.frames.push_back(std::move(entry));
  add_to_manifest(place.folder, addition);
}

}  // namespace ld
