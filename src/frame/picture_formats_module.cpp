#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>

#include "core/error.h"
#include "core/module.h"
#include "core/shown_text.h"
#include "frame/picture_formats.h"

namespace ld {
namespace {

DecodedPicture read_open(OIIO::ImageInput& input, const std::string& name, int most) {
  const OIIO::ImageSpec spec = input.spec();
  if (spec.width < 1 || spec.height < 1 || spec.width > most || spec.height > most || spec.nchannels < 1)
    fail("{}: {} x {} pixels with {} channels; expected 1 to {} a side: make it smaller", name, spec.width,
         spec.height, spec.nchannels, most);
  DecodedPicture picture{spec.width,
                         spec.height,
                         spec.nchannels,
                         spec.alpha_channel,
                         spec.format.size() <= 2 && !spec.format.is_floating_point(),
                         {}};
  picture.pixels.resize(static_cast<size_t>(spec.width) * static_cast<size_t>(spec.height) *
                        static_cast<size_t>(spec.nchannels));
  if (!input.read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, picture.pixels.data()))
    fail("{}: cannot read its pixels: {}", name, one_line(input.geterror()));
  return picture;
}

class OiioFormats : public PictureFormats {
 public:
  DecodedPicture read(const std::filesystem::path& path, int most) const override {
    const auto input = OIIO::ImageInput::open(path.string());
    if (!input) fail("{}: cannot read it as a picture: {}", path.string(), one_line(OIIO::geterror()));
    return read_open(*input, path.string(), most);
  }

  DecodedPicture decode(const std::vector<uint8_t>& bytes, const std::string& name, int most) const override {
    OIIO::Filesystem::IOMemReader memory(const_cast<uint8_t*>(bytes.data()), bytes.size());
    // OpenImageIO recognises formats by extension first; PNG and JPEG are what glTF allows.
    const bool png = bytes.size() > 1 && bytes[0] == 0x89 && bytes[1] == 'P';
    const auto input = OIIO::ImageInput::open(png ? "memory.png" : "memory.jpg", nullptr, &memory);
    if (!input) fail("{}: cannot read it as a PNG or JPEG picture: {}", name, one_line(OIIO::geterror()));
    return read_open(*input, name, most);
  }

  std::vector<float> draw_text(const std::string& text, int width, int height, int size, int left,
                               int baseline) const override {
    OIIO::ImageBuf canvas(OIIO::ImageSpec(width, height, 1, OIIO::TypeDesc::FLOAT));
    OIIO::ImageBufAlgo::zero(canvas);
    // OpenImageIO looks these up in the system's font folders; the first is Debian's fonts-dejavu-core.
    const std::vector<std::string> fonts = {"DejaVuSans", "LiberationSans-Regular", "DroidSans", "FreeSans"};
    const bool done = std::any_of(fonts.begin(), fonts.end(), [&](const std::string& font) {
      const bool found = OIIO::ImageBufAlgo::render_text(canvas, left, baseline, text, size, font, {1.0F});
      if (!found) canvas.geterror();  // taken, or OpenImageIO prints it when the canvas dies
      return found;
    });
    if (!done) return {};
    std::vector<float> pixels(static_cast<size_t>(width) * static_cast<size_t>(height));
    canvas.get_pixels(canvas.roi(), OIIO::TypeDesc::FLOAT, pixels.data());
    return pixels;
  }
};

}  // namespace
}  // namespace ld

LD_MODULE(ld::PictureFormats, ld::OiioFormats)
