// The weights of a loss over clips (losses/clip_loss.h), for those who read a configuration without LibTorch.
#pragma once

#include "core/config_visitor.h"

namespace ld {

/// Chaitanya et al. 2017 have 0.8, 0.1, 0.1 and a rise of 2 frames. The defaults are the mean over all
/// frames.
struct ClipLossConfig {
  double spatial = 1;   // weight of `loss`, of each frame
  double gradient = 0;  // weight of the difference of edges: Laplacians of Gaussians of 15x15 pixels
  double temporal = 0;  // weight of the difference of changes from frame to frame
  double rise = 0;      // frames: the weights of a clip's frames rise to its last as a Gaussian; 0: all alike

  bool is_plain() const { return spatial == 1 && gradient == 0 && temporal == 0 && rise == 0; }

  template <class Visitor>
  void visit(Visitor& v) {
    v.field("spatial", spatial, Range{0, 1000});
    v.field("gradient", gradient, Range{0, 1000});
    v.field("temporal", temporal, Range{0, 1000});
    v.field("rise", rise, Range{0, 1000});
  }
};

}  // namespace ld
