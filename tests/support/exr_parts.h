// EXR files as other programs write them: parts with windows of their own, channels of any name and type.
#pragma once

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfStandardAttributes.h>

#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace ld {

/// Other programs' files, in the repository.
inline const std::filesystem::path kImportFixtures =
    std::filesystem::path(LD_SOURCE_DIR) / "tests/fixtures/import";

/// A name, and the value of the pixel (x, y) of the display window.
using TestChannels = std::vector<std::pair<std::string, std::function<float(int, int)>>>;

struct TestPart {
  std::string name;
  Imath::Box2i window;
  TestChannels channels;
  std::string view = {};  // the attribute of that name
};

inline std::function<float(int, int)> everywhere(float value) {
  return [value](int, int) { return value; };
}

/// Channels PREFIX.R, G and B of one value; the prefix ends with its dot.
inline TestChannels colour(const std::string& prefix, float value) {
  TestChannels channels;
  for (const char* name : {"R", "G", "B"}) channels.emplace_back(prefix + name, everywhere(value));
  return channels;
}

/// Full floats. `views`: the attribute multiView.
inline void write_exr_parts(const std::filesystem::path& path, const Imath::Box2i& display,
                            const std::vector<TestPart>& parts, const std::vector<std::string>& views = {}) {
  std::vector<Imf::Header> headers;
  for (const TestPart& part : parts) {
    Imf::Header header(display, part.window);
    header.setName(part.name);
    header.setType(Imf::SCANLINEIMAGE);
    if (!part.view.empty()) header.setView(part.view);
    if (!views.empty()) Imf::addMultiView(header, views);
    for (const auto& channel : part.channels)
      header.channels().insert(channel.first, Imf::Channel(Imf::FLOAT));
    headers.push_back(header);
  }
  Imf::MultiPartOutputFile file(path.c_str(), headers.data(), static_cast<int>(headers.size()));
  for (size_t i = 0; i < parts.size(); ++i) {
    const Imath::Box2i& window = parts[i].window;
    std::vector<std::vector<float>> planes(parts[i].channels.size());
    Imf::FrameBuffer buffer;
    for (size_t c = 0; c < planes.size(); ++c) {
      for (int y = window.min.y; y <= window.max.y; ++y)
        for (int x = window.min.x; x <= window.max.x; ++x)
          planes[c].push_back(parts[i].channels[c].second(x, y));
      buffer.insert(parts[i].channels[c].first, Imf::Slice::Make(Imf::FLOAT, planes[c].data(), window));
    }
    Imf::OutputPart output(file, static_cast<int>(i));
    output.setFrameBuffer(buffer);
    output.writePixels(window.max.y - window.min.y + 1);
  }
}

}  // namespace ld
