#include "import/file_views.h"

#include <ImfMultiView.h>
#include <ImfStandardAttributes.h>

#include <algorithm>

#include "core/error.h"
#include "core/shown_text.h"

namespace ld {
namespace {

constexpr size_t kMostViews = 256;  // each channel is compared with all of them

}  // namespace

FileViews::FileViews(const ExrReader& exr, const std::string& wanted) : exr_(exr) {
  bool in_parts = false;
  for (int part = 0; part < exr.parts(); ++part) in_parts = in_parts || !view_of(part).empty();
  // A single part with one view may carry both attributes.
  const Imf::Header& first = exr.header(0);
  in_names_ =
      Imf::hasMultiView(first) && (!in_parts || (exr.parts() == 1 && Imf::multiView(first).size() > 1));
  if (in_names_)
    all_ = Imf::multiView(first);
  else if (in_parts)
    for (int part = 0; part < exr.parts(); ++part)
      // Parts of no view are the hero's; where the first is one of them the hero has no name.
      if ((part == 0 || !view_of(part).empty()) && std::count(all_.begin(), all_.end(), view_of(part)) == 0)
        all_.push_back(view_of(part));
  if (all_.size() > kMostViews)
    fail("{}: {} views; expected at most {}", exr.path(), all_.size(), kMostViews);
  if (!all_.empty()) chosen_ = all_.front();
  if (wanted.empty()) return;
  if (all_.empty())
    fail_usage("{}: no view '{}': the file says nothing of views; leave --view out", exr.path(),
               shown(wanted));
  if (std::count(all_.begin(), all_.end(), wanted) == 0)
    fail_usage("{}: no view '{}'; the file has {}", exr.path(), shown(wanted), list());
  chosen_ = wanted;
}

std::string FileViews::list() const {
  std::string text;
  for (const std::string& view : all_)
    text += (text.empty() ? "" : ", ") + (view.empty() ? std::string("one without a name") : view);
  return shown(text, 400);
}

std::string FileViews::view_of(int part) const {
  return exr_.header(part).hasView() ? exr_.header(part).view() : "";
}

std::optional<std::string> FileViews::name_of(int part, const std::string& channel) const {
  if (all_.empty()) return channel;
  const std::string view = in_names_ ? Imf::viewFromChannelName(channel, all_) : view_of(part);
  if (view != chosen_ && !(view.empty() && is_hero())) return std::nullopt;
  return in_names_ ? Imf::removeViewName(channel, chosen_) : channel;
}

std::string FileViews::part_name(int part) const {
  std::string name = exr_.part_name(part);
  if (chosen_.empty() || name.size() < chosen_.size() + 2) return name;
  const size_t rest = name.size() - chosen_.size() - 1;
  const auto separates = [&](size_t at) { return name[at] == '.' || name[at] == '-' || name[at] == '_'; };
  if (name.compare(rest + 1, chosen_.size(), chosen_) == 0 && separates(rest)) return name.substr(0, rest);
  if (name.compare(0, chosen_.size(), chosen_) == 0 && separates(chosen_.size()))
    return name.substr(chosen_.size() + 1);
  return name;
}

std::string FileViews::prefix() const {
  return in_names_ && !is_hero() ? chosen_ + "." : "";
}

std::optional<ViewCamera> FileViews::camera() const {
  if (in_names_ && !is_hero()) return std::nullopt;
  for (int part = 0; part < exr_.parts(); ++part) {
    if (!name_of(part, "")) continue;
    if (std::optional<ViewCamera> camera = camera_of(exr_.header(part), exr_.path())) return camera;
  }
  return std::nullopt;
}

}  // namespace ld
