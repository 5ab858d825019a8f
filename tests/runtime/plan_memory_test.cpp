// What a plan says that it takes, against what the process takes when it runs.
#include <gtest/gtest.h>
#include <malloc.h>

#include "core/process/process_memory.h"
#include "graph/extent.h"
#include "models/check_network.h"
#include "models/graphs/network_graph.h"
#include "runtime/executor.h"
#include "tests/support/random_frame.h"
#include "tests/support/sanitized.h"

namespace ld {
namespace {

NamedWeights small_weights(const graph::Graph& graph) {
  NamedWeights weights;
  for (const graph::Parameter& parameter : graph::parameters(graph))
    weights.add(parameter.name,
                {parameter.shape, std::vector<float>(size_t(graph::count_of(parameter)), 0.01F)});
  return weights;
}

/// The planned bytes, and those by which the process grew at its largest while it planned and ran.
struct Memory {
  int64_t planned, taken;
};
Memory memory_of(const NetworkConfig& config, const Frame& frame, const ExecutionOptions& options) {
  const graph::Graph graph = network_graph(config);
  const NamedWeights weights = small_weights(graph);
  malloc_trim(0);
  reset_peak_resident();
  const int64_t before = resident_bytes();
  Execution execution(graph, weights, {frame.spp, frame.height, frame.width}, options);
  execution.run(frame, {}, [](int64_t, int64_t) {});
  return {execution.memory_bytes(), peak_resident_bytes() - before};
}

constexpr int64_t kBeside = int64_t(8) << 20;  // what is as small as a stretch of a row, for each thread

void expect_within_plan(const NetworkConfig& config, const Frame& frame) {
  for (const ExecutionOptions& options : {ExecutionOptions{2, 0}, ExecutionOptions{1, 1}}) {
    const Memory memory = memory_of(config, frame, options);
    EXPECT_LE(memory.taken, memory.planned + kBeside)
        << config.name << ", " << options.block_rows << " rows, " << options.threads << " threads";
    EXPECT_GE(memory.taken, memory.planned / 2) << config.name << " plans for twice what it takes";
  }
}

class PlanMemory : public testing::Test {
 protected:
  void SetUp() override {
    if (kAddressSanitizer) GTEST_SKIP() << "the sanitizer keeps what is freed";
  }
};

// Rows outweigh weights.
TEST_F(PlanMemory, OfWideFramesIsNotExceeded) {
  const Frame frame = random_frame(1920, 70, 2);
  for (const std::string& name : network_names()) {
    NetworkConfig config;
    config.name = name;
    if (network_traits(name).filter != Filter::none) config.demodulation = "albedo";
    config.kernel_size = 5;
    config.unet.encoder = {{16}, {16}, {16}};
    config.unet.bottleneck = {16};
    config.unet.decoder = {{16}, {16}, {16}};
    config.sample_partitioner = {16};
    config.kernel_generator = {16};
    expect_within_plan(config, frame);
  }
}

// Weights outweigh rows.
TEST_F(PlanMemory, OfPublishedWidthsIsNotExceeded) {
  const Frame frame = random_frame(200, 33, 1);
  for (const std::string& name : network_names()) {
    NetworkConfig config;
    config.name = name;
    expect_within_plan(config, frame);
  }
}

}  // namespace
}  // namespace ld
