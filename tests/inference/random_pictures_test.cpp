// Three hundred pictures of any layout through import, denoising and evaluation.
#include <gtest/gtest.h>

#include "core/file_io.h"
#include "frame/frame_file.h"
#include "frame/picture_place.h"
#include "import/frame_import.h"
#include "inference/denoise_job.h"
#include "tests/models/small_network.h"
#include "tests/support/random_picture.h"
#include "tests/support/temporary_folder.h"
#include "weights/model_file.h"

namespace ld {
namespace {

/// One picture of samples: how it lies in files, and what must come out of it.
struct Case {
  std::vector<std::filesystem::path> files;
  ImportMapping mapping;
  Imath::Box2i display, window;   // of the samples
  std::vector<RandomPart> parts;  // of the first file, in its order
  int spp = 0;
  bool alpha = false, per_part = false;
};

const char* const kColours[] = {"R", "G", "B"};

void add_sample(RandomPart& part, const std::string& prefix, int sample, Imf::PixelType type) {
  for (int c = 0; c < 3; ++c) part.channels[prefix + kColours[c]] = {type, c, sample};
}

ImportMapping mapping_from(const std::filesystem::path& path, const std::string& yaml) {
  write_file_atomically(path, yaml);
  return read_mapping("", path, {});
}

/// Samples as parts of one file, as prefixes of channels in one part, or as files.
Case make_case(RandomPictures& random, const std::filesystem::path& folder) {
  Case made;
  made.display = random.window();
  made.window = random.window();
  made.spp = random.draw(2, 4);
  made.alpha = random.draw(0, 1);
  const int layout = random.draw(0, 2);
  made.per_part = layout == 0;
  const Imf::PixelType type = random.type(false);
  const std::string alpha =
      made.alpha ? "alpha:\n  channels: [A]\n" + std::string(layout == 1 ? "  per_sample: false\n" : "") : "";
  std::vector<RandomPart> strangers;
  for (int i = random.draw(0, 2); i > 0; --i) {
    RandomPart part{"other" + std::to_string(i), random.window(), {}};
    random.add_strangers(part, 3);
    if (!part.channels.empty()) strangers.push_back(part);
  }
  std::vector<RandomPart> parts = strangers;
  const auto file_of = [&](const std::string& name) { return folder / (name + ".exr"); };
  if (made.per_part) {
    made.mapping = mapping_from(folder / "mapping.yaml",
                                "part: \"s{sample}\"\nradiance:\n  channels: [R, G, B]\n" + alpha);
    for (int s = 0; s < made.spp; ++s) {
      RandomPart part{"s" + std::to_string(s), made.window, {}};
      add_sample(part, "", s, type);
      if (made.alpha) part.channels["A"] = {random.type(false), 3, s};
      parts.push_back(part);
    }
  } else if (layout == 1) {
    made.mapping =
        mapping_from(folder / "mapping.yaml",
                     "radiance:\n  channels: [\"s{sample}.R\", \"s{sample}.G\", \"s{sample}.B\"]\n" + alpha);
    RandomPart part{"all", made.window, {}};
    for (int s = 0; s < made.spp; ++s) add_sample(part, "s" + std::to_string(s) + ".", s, type);
    if (made.alpha) part.channels["A"] = {random.type(false), 3, 0};
    random.add_strangers(part, 3);
    parts.push_back(part);
  } else {
    made.mapping = mapping_from(folder / "mapping.yaml", "radiance:\n  channels: [R, G, B]\n" + alpha);
    for (int s = 0; s < made.spp; ++s) {
      RandomPart part{"beauty", made.window, {}};
      add_sample(part, "", s, type);
      if (made.alpha) part.channels["A"] = {random.type(false), 3, s};
      random.add_strangers(part, 3);
      std::vector<RandomPart> file = strangers;
      file.push_back(part);
      random.shuffle(file);
      if (s == 0) made.parts = file;
      made.files.push_back(file_of("sample" + std::to_string(s)));
      random.write(made.files.back(), made.display, file);
    }
    return made;
  }
  random.shuffle(parts);
  made.parts = parts;
  made.files = {file_of("samples")};
  random.write(made.files[0], made.display, parts);
  return made;
}

void expect_imported(const Case& made, const std::filesystem::path& ours) {
  const ImportedFrame imported = import_frame(made.files, made.mapping, std::nullopt, false);
  const Frame& frame = imported.frame;
  ASSERT_EQ(frame.spp, made.spp);
  ASSERT_EQ(frame.width, made.window.size().x + 1);
  ASSERT_EQ(frame.height, made.window.size().y + 1);
  EXPECT_EQ(frame.info.windows.x, made.window.min.x);
  EXPECT_EQ(frame.info.windows.y, made.window.min.y);
  EXPECT_EQ(frame.info.windows.display_right, made.display.max.x);
  EXPECT_EQ(frame.alpha.empty(), !made.alpha);
  write_frame(ours, frame);
  Faults faults;
  const Frame again = read_frame(ours, frame.features, faults);
  EXPECT_FALSE(faults.any());
  EXPECT_EQ(again.samples, frame.samples);
  EXPECT_EQ(again.alpha, frame.alpha);
  EXPECT_EQ(again.info.windows, frame.info.windows);
  size_t pixel = 0;
  for (int y = made.window.min.y; y <= made.window.max.y; ++y)
    for (int x = made.window.min.x; x <= made.window.max.x; ++x, ++pixel)
      for (int s = 0; s < made.spp; ++s) {
        for (int c = 0; c < 3; ++c) ASSERT_EQ(frame.plane(s, c)[pixel], radiance_at(x, y, s, c));
        if (made.alpha) {
          ASSERT_EQ(frame.alpha[size_t(s) * frame.plane_size() + pixel], alpha_at(x, y));
        }
      }
}

/// Of the picture, where the samples lie: the mean of them that was written on the way, and alpha.
void expect_placed(const Case& made, const std::filesystem::path& noisy) {
  Imf::MultiPartInputFile file(noisy.c_str());
  EXPECT_EQ(file.header(0).dataWindow(), made.window);
  EXPECT_EQ(file.header(0).displayWindow(), made.display);
  for (int c = 0; c < (made.alpha ? 4 : 3); ++c) {
    const std::vector<uint32_t> bits = channel_bits(noisy, 0, c == 3 ? "A" : kColours[c], Imf::HALF);
    ASSERT_FALSE(bits.empty());
    size_t pixel = 0;
    for (int y = made.window.min.y; y <= made.window.max.y; ++y)
      for (int x = made.window.min.x; x <= made.window.max.x; ++x, ++pixel) {
        float mean = c == 3 ? alpha_at(x, y) : 0;
        for (int s = 0; s < made.spp && c < 3; ++s)
          mean += radiance_at(x, y, s, c) / static_cast<float>(made.spp);
        half found;
        found.setBits(static_cast<uint16_t>(bits[pixel]));
        ASSERT_NEAR(found, mean, 0.008) << x << " " << y;  // half a step of half floats below 16
      }
  }
}

/// All that is no sample stands in the picture's file, bit for bit and where it was.
void expect_kept(const Case& made, const std::filesystem::path& picture, int* channels) {
  Imf::MultiPartInputFile file(picture.c_str());
  for (const RandomPart& part : made.parts) {
    std::map<std::string, RandomChannel> rest;
    for (const auto& [name, channel] : part.channels)
      if (channel.kind > 3) rest[name] = channel;
    if (rest.empty()) continue;
    int found = -1;
    for (int p = 0; p < file.parts() && found < 0; ++p)
      if (file.header(p).channels().findChannel(rest.begin()->first) != nullptr &&
          (file.parts() == 1 || file.header(p).name() == part.name || rest.size() < part.channels.size()))
        found = p;
    ASSERT_GE(found, 0) << part.name << " is lost";
    ASSERT_EQ(file.header(found).dataWindow(), part.window);
    for (const auto& [name, channel] : rest) {
      const std::vector<uint32_t> bits = channel_bits(picture, found, name, channel.type);
      ASSERT_FALSE(bits.empty()) << part.name << " " << name;
      ++*channels;
      size_t pixel = 0;
      for (int y = part.window.min.y; y <= part.window.max.y; ++y)
        for (int x = part.window.min.x; x <= part.window.max.x; ++x)
          ASSERT_EQ(bits[pixel++], pixel_bits(channel, x, y)) << part.name << " " << name;
    }
  }
}

/// The picture is scored against one of a larger window where both show the same place.
void expect_scored(const Case& made, RandomPictures& random, const std::filesystem::path& picture,
                   const std::filesystem::path& reference) {
  RandomPart larger{"reference", made.window, {}};
  larger.window.min -= Imath::V2i(random.draw(0, 5), random.draw(0, 5));
  larger.window.max += Imath::V2i(random.draw(0, 5), random.draw(0, 5));
  add_sample(larger, "", 0, Imf::FLOAT);
  random.write(reference, made.display, {larger});
  const Reference read = read_reference(reference, read_place(picture), picture.string());
  size_t pixel = 0;
  for (int y = made.window.min.y; y <= made.window.max.y; ++y)
    for (int x = made.window.min.x; x <= made.window.max.x; ++x, ++pixel)
      for (int c = 0; c < 3; ++c) ASSERT_EQ(read.image.plane(c)[pixel], radiance_at(x, y, 0, c));
}

TEST(RandomPictures, AreReadKeptAndPlacedWhateverTheirLayout) {
  const TemporaryFolder folder;
  NetworkConfig config = small_config();
  config.features = {"radiance"};
  save_network(folder / "model.safetensors", *small_network(config, torch::kFloat32), "{}", DType::f32);
  int kept = 0;
  for (uint32_t seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE(seed);
    const std::filesystem::path place = folder / std::to_string(seed);
    std::filesystem::create_directory(place);
    RandomPictures random(seed);
    const Case made = make_case(random, place);
    expect_imported(made, place / "frame.exr");
    DenoiseJob job;
    job.model = folder / "model.safetensors";
    job.render.mapping = made.mapping;
    job.tasks = {{made.files, place / "denoised.exr"}};
    job.noisy = place / "noisy.exr";
    job.full_float = true;
    run_denoise_job(job);
    expect_placed(made, place / "noisy.exr");
    expect_kept(made, place / "denoised.exr", &kept);
    expect_scored(made, random, place / "denoised.exr", place / "reference.exr");
    if (::testing::Test::HasFailure()) break;
    std::filesystem::remove_all(place);
  }
  EXPECT_GT(kept, 500);
}

}  // namespace
}  // namespace ld
