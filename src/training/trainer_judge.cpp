// How a Trainer judges what its network learns from samples as targets.
#include "core/error.h"
#include "core/log.h"
#include "training/held_out.h"
#include "training/trainer.h"

namespace ld {
namespace {

/// Why held-out frames cannot judge; "": they can.
std::string refusal(const ValidationResult& result) {
  if (static_cast<int>(result.block_errors.size()) < kFewestBlocks)
    return fmt::format(
        "{} blocks of {}x{} pixels are held out, and fewer than {} say nothing: give more or larger frames",
        result.block_errors.size(), kBlockSide, kBlockSide, kFewestBlocks);
  if (result.correlation > kLargestCorrelation)
    return fmt::format(
        "the samples of a pixel share noise (correlation {:.2f}, {:g} is the most): samples to compare with "
        "must be independent of those that are denoised; render them with seeds of their own, without a "
        "denoiser",
        result.correlation, kLargestCorrelation);
  return "";
}

}  // namespace

/// Collective: the score of the network as it is, which rank 0 finds. Of the beginning it is 0.
double Trainer::judge(const ValidationResult& result) {
  const std::string why = state().step == 0 ? refusal(result) : "";
  if (!why.empty()) {
    verdict_ = "refused, the weights of the beginning stay the best: " + why;
    if (group_.is_root()) spdlog::warn("{}", verdict_);
    course_.stop();
  }
  double score = 0;
  if (state().step == 0) {
    if (group_.is_root()) write_beginning(run_, result.block_errors);
  } else if (group_.is_root()) {
    const HeldOutComparison comparison = compare_blocks(read_beginning(run_), result.block_errors);
    score = comparison.score();
    const double change = comparison.now - comparison.beginning;
    const std::string figures = fmt::format(
        "squared error on {} held-out blocks {:.4g}, at the beginning {:.4g}: {:+.4g} (95 % interval {:.4g} "
        "to {:.4g})",
        result.block_errors.size(), comparison.now, comparison.beginning, change, comparison.difference.low,
        comparison.difference.high);
    spdlog::info("step {}: {}", state().step, figures);
    if (score < state().best_score)
      verdict_ = fmt::format("the best weights are those of step {}: {}", state().step, figures);
    else if (state().best_step == 0)
      verdict_ = "not better for sure, so the weights of the beginning stay the best: " + figures;
  }
  return group_.sum(group_.is_root() ? score : 0, "judging");
}

}  // namespace ld
