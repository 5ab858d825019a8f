#include "frame/picture_formats.h"

#include "core/module.h"

namespace ld {

const PictureFormats& picture_formats() {
  static const auto* const formats = static_cast<const PictureFormats*>(
      load_module("ld_picture_formats", "reads textures and draws text",
                  "install the program again, or build all of it (cmake --build --preset release)"));
  return *formats;
}

}  // namespace ld
