// What ld_denoise does: what it keeps of its input, sequences, other renderers' files.
#include <ImfChannelList.h>
#include <ImfFloatAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfStringAttribute.h>
#include <gtest/gtest.h>

#include "frame/exr_reader.h"
#include "frame/frame_file.h"
#include "inference/denoise_job.h"
#include "tests/inference/denoising_test.h"
#include "tests/models/small_network.h"
#include "tests/support/expect_error.h"
#include "tests/support/random_frame.h"
#include "tests/support/run_program.h"
#include "weights/model_file.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth = 21, kHeight = 17;

/// A file as a studio's renderer writes it: windows, attributes, further channels in its first part, a
/// constant picture of 0.5 in two samples whose alpha is 1 and 0.5.
void write_rich_frame(const fs::path& path) {
  const Imath::Box2i data({-3, 5}, {-3 + kWidth - 1, 5 + kHeight - 1}), display({0, 0}, {99, 49});
  struct Part {
    std::string name;
    std::vector<std::string> channels;
  };
  const std::vector<Part> parts = {{"mean", {"R", "G", "B", "A", "crypto00.r"}},
                                   {"s000", {"R", "G", "B", "A", "N.X", "N.Y", "N.Z", "Z"}},
                                   {"s001", {"R", "G", "B", "A", "N.X", "N.Y", "N.Z", "Z"}}};
  std::vector<Imf::Header> headers;
  for (const Part& part : parts) {
    Imf::Header header(display, data, 1.25F);
    header.setName(part.name);
    header.setType(Imf::SCANLINEIMAGE);
    for (const std::string& channel : part.channels)
      header.channels().insert(channel, Imf::Channel(channel == "crypto00.r" ? Imf::FLOAT : Imf::HALF));
    headers.push_back(header);
  }
  headers[0].channels().insert("id", Imf::Channel(Imf::UINT));
  headers[0].insert("owner", Imf::StringAttribute("the studio"));
  headers[0].insert("fovX", Imf::FloatAttribute(0.7F));
  headers[0].insert("ldCamera", Imf::StringAttribute("lens 35 mm"));
  Imf::MultiPartOutputFile file(path.c_str(), headers.data(), int(headers.size()));
  for (size_t i = 0; i < parts.size(); ++i) {
    std::vector<std::vector<float>> planes;
    std::vector<std::vector<half>> halves(parts[i].channels.size());
    std::vector<uint32_t> ids(size_t{kWidth} * kHeight);
    Imf::FrameBuffer buffer;
    planes.reserve(parts[i].channels.size());
    for (size_t c = 0; c < parts[i].channels.size(); ++c) {
      const std::string& name = parts[i].channels[c];
      float value = 0.5F;
      if (name == "A") value = i == 2 ? 0.5F : 1.0F;
      if (name == "N.Z") value = 1;
      if (name == "Z") value = 3;
      if (name == "crypto00.r") {
        planes.emplace_back(ids.size());
        for (size_t p = 0; p < ids.size(); ++p) planes.back()[p] = 1e-30F * float(p);  // beyond half's range
        buffer.insert(name, Imf::Slice::Make(Imf::FLOAT, planes.back().data(), data));
        continue;
      }
      halves[c].assign(ids.size(), half(value));
      buffer.insert(name, Imf::Slice::Make(Imf::HALF, halves[c].data(), data));
    }
    if (i == 0) {
      for (size_t p = 0; p < ids.size(); ++p) ids[p] = 4'000'000'000U + uint32_t(p);
      buffer.insert("id", Imf::Slice::Make(Imf::UINT, ids.data(), data));
    }
    Imf::OutputPart output(file, int(i));
    output.setFrameBuffer(buffer);
    output.writePixels(kHeight);
  }
}

class DenoiseProgram : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared_ = new TemporaryFolder;
    NetworkConfig config = small_config();
    save(config, "layer.safetensors");
    config.name = "pixel_gather";
    save(config, "pixel.safetensors");
    config = small_config();
    config.features = {"radiance", "normal", "albedo"};
    save(config, "cycles.safetensors");
    write_rich_frame(path("rich.exr"));
    for (const int frame : {1, 2, 4})
      write_frame(path(fmt::format("in.{:04}.exr", frame)), random_frame(12, 9, 2, uint32_t(frame)));
  }
  static void TearDownTestSuite() { delete shared_; }
  static void save(const NetworkConfig& config, const std::string& name) {
    save_network(path(name), *small_network(config, torch::kFloat32), "{}", DType::f32);
  }
  static std::string path(const std::string& name) { return (*shared_ / name).string(); }
  static DenoiseJob job(const std::string& input, const std::string& output,
                        const std::string& model = "layer", std::optional<FrameRange> range = {}) {
    DenoiseJob job;
    job.model = path(model + ".safetensors");
    job.tasks = plan_tasks({path(input)}, path(output), range, false);
    return job;
  }

  static TemporaryFolder* shared_;
};
TemporaryFolder* DenoiseProgram::shared_ = nullptr;

TEST_F(DenoiseProgram, KeepsAlphaChannelsWindowsAndAttributes) {
  for (const bool full : {false, true}) {
    DenoiseJob one = job("rich.exr", "kept.exr");
    one.full_float = full;
    const DenoiseReport report = run_denoise_job(one);
    EXPECT_EQ(report.frames.size(), 1u);
    EXPECT_EQ(report.frames[0]["width"], kWidth);
    const ExrReader exr(path("kept.exr"));
    EXPECT_EQ(exr.parts(), 1);
    EXPECT_EQ(exr.channel_list(0), "A, B, G, R, crypto00.r, id");
    const Imf::Header& header = exr.header(0);
    EXPECT_EQ(header.channels()["R"].type, full ? Imf::FLOAT : Imf::HALF);
    EXPECT_EQ(header.dataWindow(), Imath::Box2i({-3, 5}, {-3 + kWidth - 1, 5 + kHeight - 1}));
    EXPECT_EQ(header.displayWindow(), Imath::Box2i({0, 0}, {99, 49}));
    EXPECT_EQ(header.pixelAspectRatio(), 1.25F);
    EXPECT_EQ(header.typedAttribute<Imf::StringAttribute>("owner").value(), "the studio");
    EXPECT_EQ(header.typedAttribute<Imf::FloatAttribute>("fovX").value(), 0.7F);
    EXPECT_EQ(header.typedAttribute<Imf::StringAttribute>("ldCamera").value(), "lens 35 mm");
    EXPECT_EQ(header.typedAttribute<Imf::StringAttribute>("ldDenoisedBy").value().rfind("ld_denoise ", 0),
              0u);
    EXPECT_EQ(header.find("ldSpp"), header.end());
    for (const char* colour : {"R", "G", "B"})
      for (const float value : channel_of(exr, 0, colour)) ASSERT_NEAR(value, 0.5, full ? 1e-6 : 3e-4);
    for (const float value : channel_of(exr, 0, "A")) ASSERT_EQ(value, 0.75F) << "the mean of 1 and 0.5";
    const std::vector<float> crypto = channel_of(exr, 0, "crypto00.r");
    for (size_t p = 0; p < crypto.size(); ++p) ASSERT_EQ(crypto[p], 1e-30F * float(p)) << "not through half";
    std::vector<uint32_t> ids(crypto.size());
    exr.read_typed(0, {{"id", Imf::UINT, reinterpret_cast<char*>(ids.data()), ids.size()}});
    for (size_t p = 0; p < ids.size(); ++p) ASSERT_EQ(ids[p], 4'000'000'000U + p);
    EXPECT_EQ(read_image(path("kept.exr")).width, kWidth);
  }
}

TEST_F(DenoiseProgram, ReadsTheFirstSamplesOnRequest) {
  Frame frame = random_frame(12, 9, 4);
  write_frame(path("four.exr"), frame);
  keep_first_samples(frame, 1, "four");
  write_frame(path("one.exr"), frame);
  DenoiseJob of_four = job("four.exr", "first.exr");
  of_four.samples = 1;
  EXPECT_TRUE(run_denoise_job(of_four).failed.empty());
  EXPECT_TRUE(run_denoise_job(job("one.exr", "only.exr")).failed.empty());
  EXPECT_TRUE(run_denoise_job(job("four.exr", "all.exr")).failed.empty());
  const Image first = read_image(path("first.exr")), only = read_image(path("only.exr"));
  EXPECT_EQ(first.pixels, only.pixels);
  EXPECT_NE(first.pixels, read_image(path("all.exr")).pixels);
  of_four.samples = 5;
  EXPECT_ERROR(run_denoise_job(of_four), "four.exr: 4 samples a pixel, but 5 are asked for");
}

TEST_F(DenoiseProgram, WritesLayersAndKernelsAsParts) {
  DenoiseJob looking = job("rich.exr", "parts.exr");
  looking.full_float = looking.layers = looking.contributions = looking.unfiltered = true;
  looking.kernels_at = {{20, 0}};
  run_denoise_job(looking);
  const ExrReader exr(path("parts.exr"));
  std::vector<std::string> names;
  for (int part = 0; part < exr.parts(); ++part) names.push_back(exr.part_name(part));
  EXPECT_EQ(names, (std::vector<std::string>{"denoised", "layer0", "layer0.contribution", "layer0.unfiltered",
                                             "layer1", "layer1.contribution", "layer1.unfiltered",
                                             "kernel.20.0.layer0", "kernel.20.0.layer1"}));
  EXPECT_EQ(exr.channel_list(1), "A, B, G, R");
  EXPECT_EQ(exr.channel_list(2), "B, G, R, weight");
  EXPECT_EQ(exr.channel_list(3), "B, G, R");
  const std::vector<float> picture = channel_of(exr, 0, "G"), front = channel_of(exr, 2, "G"),
                           back = channel_of(exr, 5, "G");
  for (size_t p = 0; p < picture.size(); ++p) ASSERT_NEAR(front[p] + back[p], picture[p], 1e-5);
  // A kernel lies where it acts: around pixel (20, 0) of the data window.
  EXPECT_EQ(exr.header(7).dataWindow(), Imath::Box2i({16, 4}, {18, 6}));
  EXPECT_EQ(exr.channel_list(7), "Y");

  DenoiseJob wrong = job("rich.exr", "x.exr", "pixel");
  wrong.layers = true;
  EXPECT_ERROR(run_denoise_job(wrong), "'pixel_gather', which has no layers");
  wrong = job("rich.exr", "x.png");
  wrong.layers = true;
  EXPECT_ERROR(run_denoise_job(wrong), "the extension .exr");
  wrong = job("rich.exr", "x.exr");
  wrong.kernels_at = {{21, 0}};
  EXPECT_ERROR(run_denoise_job(wrong), "no pixel (21, 0)");
  EXPECT_FALSE(fs::exists(path("x.exr")));
}

TEST_F(DenoiseProgram, DoesTheOthersOfASequenceWhenAFrameIsMissing) {
  DenoiseJob sequence = job("in.####.exr", "out.####.exr", "layer", FrameRange{1, 5});
  const DenoiseReport first = run_denoise_job(sequence);
  EXPECT_EQ(first.failed, (std::vector<std::string>{path("in.0003.exr")}));
  EXPECT_EQ(first.frames.size(), 4u);
  EXPECT_NE(first.frames[2]["error"].get<std::string>().find("in.0003.exr"), std::string::npos);
  for (const int frame : {1, 2, 4})
    EXPECT_TRUE(fs::exists(path(fmt::format("out.{:04}.exr", frame)))) << frame;
  EXPECT_FALSE(fs::exists(path("out.0003.exr")));

  // What is there stays as it is; the frame that came later is done.
  write_file_atomically(path("out.0001.exr"), "touched");
  write_frame(path("in.0003.exr"), random_frame(12, 9, 2, 3));
  sequence.skip_existing = true;
  const DenoiseReport again = run_denoise_job(sequence);
  EXPECT_TRUE(again.failed.empty());
  EXPECT_EQ(again.skipped, 3);
  EXPECT_EQ(read_file(path("out.0001.exr")), "touched");
  EXPECT_EQ(read_image(path("out.0003.exr")).width, 12);
  fs::remove(path("in.0003.exr"));
}

// Frames of a sequence are told how many come right before them, and give the pictures that they give alone.
TEST_F(DenoiseProgram, WalksASequenceAndRestartsAtHoles) {
  for (const int frame : {1, 2, 3, 5, 6, 7, 8})
    write_frame(path(fmt::format("walk.{}.exr", frame)),
                random_frame(frame == 8 ? 9 : 12, 9, 2, uint32_t(frame)));
  write_file_atomically(path("walk.6.exr"), "no frame");
  const auto histories = [](const DenoiseReport& report) {
    std::string text;
    for (const auto& frame : report.frames)
      text += (frame.contains("error") ? "failed" : frame["history"].dump()) + " ";
    return text;
  };
  DenoiseJob walk = job("walk.#.exr", "walked.#.exr");
  EXPECT_EQ(histories(run_denoise_job(walk)), "0 1 2 0 failed 0 0 ") << "4 is missing, 6 broken, 8 smaller";
  for (const int frame : {1, 2, 3, 5, 7, 8}) {
    const std::string alone = path(fmt::format("alone.{}.exr", frame));
    const DenoiseReport still =
        run_denoise_job(job(fmt::format("walk.{}.exr", frame), fmt::format("alone.{}.exr", frame)));
    EXPECT_EQ(still.frames[0]["history"], 0);
    EXPECT_EQ(read_file(path(fmt::format("walked.{}.exr", frame))), read_file(alone)) << frame;
  }
  fs::remove(path("walked.2.exr"));
  fs::remove(path("walked.3.exr"));
  walk.skip_existing = true;
  EXPECT_EQ(histories(run_denoise_job(walk)), "0 1 failed ") << "1 was left alone";
  walk = job("walk.#.exr", "walked.#.exr", "layer", FrameRange{2, 5});
  EXPECT_EQ(histories(run_denoise_job(walk)), "0 1 failed ") << "1 is outside of the range";
  fs::remove(path("walk.6.exr"));
}

TEST_F(DenoiseProgram, TakesRendersThroughAPreset) {
  const fs::path fixtures = fs::path(LD_SOURCE_DIR) / "tests/fixtures/import/cycles";
  DenoiseJob renders;
  renders.model = path("cycles.safetensors");
  renders.render.mapping = read_mapping("cycles", "", {});
  renders.render.camera = read_camera(fixtures / "camera.yaml");
  std::vector<std::string> samples;
  for (int i = 0; i < 4; ++i) samples.push_back((fixtures / fmt::format("sample_{:02}.exr", i)).string());
  renders.tasks = plan_tasks(samples, path("cycles.exr"), {}, true);
  const DenoiseReport report = run_denoise_job(renders);
  EXPECT_EQ(report.frames[0]["spp"], 4);
  renders.samples = 3;
  EXPECT_EQ(run_denoise_job(renders).frames[0]["spp"], 3);
  renders.samples = 5;
  EXPECT_ERROR(run_denoise_job(renders), "4 samples a pixel, but 5 are asked for");
  renders.samples = 0;
  run_denoise_job(renders);
  const ExrReader exr(path("cycles.exr")), sample(fixtures / "sample_00.exr");
  EXPECT_EQ(exr.header(0).dataWindow(), sample.header(0).dataWindow());
  EXPECT_TRUE(exr.has_channel(0, "R"));
  EXPECT_TRUE(exr.has_channel(0, "A"));
  const std::string channels = exr.channel_list(0);
  EXPECT_EQ(channels.find("Combined"), std::string::npos) << channels;
  EXPECT_NE(channels.find("Normal.X"), std::string::npos) << channels;

  renders.model = path("layer.safetensors");
  renders.render.mapping = read_mapping("cycles", "", {"normal.channels=[]", "normal_2.channels=[]"});
  EXPECT_ERROR(run_denoise_job(renders), "not the feature 'normal'");
  renders.tasks[0].inputs[3] = path("rich.exr");
  EXPECT_ERROR(run_denoise_job(renders), "rich.exr");
}

TEST_F(DenoiseProgram, WrongCommandLinesAreOneLine) {
  const auto denoise = [](std::vector<std::string> arguments) {
    arguments.insert(arguments.end(),
                     {"--model", path("layer.safetensors"), path("rich.exr"), "--output", path("x.exr")});
    return run_program("ld_denoise", arguments);
  };
  expect_failure(denoise({"--max-memory", "1"}), 2, {"budget of 1 MB", "the smallest is"});
  expect_failure(denoise({"--kernel-at", "1;2"}), 2, {"X,Y"});
  expect_failure(denoise({"--camera", "c.yaml"}), 2, {"is a frame"});
  EXPECT_FALSE(fs::exists(path("x.exr")));
}

}  // namespace
}  // namespace ld
