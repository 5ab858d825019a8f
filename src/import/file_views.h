// The views of a stereo or multi-view file, and which channels are whose, as OpenEXR's documentation says
// ("Storing Multi-View Images in OpenEXR Files"): parts with an attribute `view` each, or one part with an
// attribute `multiView` whose channels are called LAYER.VIEW.CHANNEL.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "frame/exr_reader.h"
#include "import/view_camera.h"

namespace ld {

/// A file seen from one of its views. Most files say nothing of views: they have none, and all channels
/// count.
class FileViews {
 public:
  /// The view `wanted`; the hero, which is the first one, where that is empty. Throws UsageError, with the
  /// views that there are, for one that the file does not have; Error for a file of more views than can be.
  FileViews(const ExrReader& exr, const std::string& wanted);

  const std::vector<std::string>& all() const { return all_; }  // the hero first; empty: the file has none
  std::string list() const;                                     // "left, right", for people
  const std::string& chosen() const { return chosen_; }         // empty: the file has none
  bool is_hero() const { return all_.empty() || chosen_ == all_.front(); }

  /// The channel's name without its view; nothing where it belongs to another view. Channels that belong to
  /// no view are the hero's.
  std::optional<std::string> name_of(int part, const std::string& channel) const;

  /// The part's name without its view, by which some writers tell parts apart.
  std::string part_name(int part) const;

  /// What stands before R, G and B of the chosen view where they lie beside other views' in one part.
  std::string prefix() const;

  /// The camera of the attribute worldToCamera, if there is one and it is this view's: one part has one for
  /// its hero.
  std::optional<ViewCamera> camera() const;

 private:
  std::string view_of(int part) const;

  const ExrReader& exr_;
  std::vector<std::string> all_;
  bool in_names_ = false;  // views are told apart by the names of channels
  std::string chosen_;
};

}  // namespace ld
