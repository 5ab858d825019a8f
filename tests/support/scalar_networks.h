// The networks of [MH20] from end to end as plain loops in double, built from the parts of
// scalar_reference.h.
#pragma once

#include "tests/support/scalar_reference.h"

namespace ld::reference {

struct NetworkLayout {
  UNetLayout unet;
  bool weighted = false;  // compositing by eq. 6 instead of eq. 5
  int64_t levels = 3;     // of networks with several
  int64_t kernel_size = 0;
  double logit_bound = 0;              // c of c x / (c + |x|); 0: none
  int64_t albedo = -1, specular = -1;  // first channels, for demodulation; -1: not there
  bool demodulates = false, rejects = false;
  int64_t radiance = -1;                         // first channel; of super-resolution, whose light it is
  int64_t convolutions = 0;                      // hidden ones of the super-resolution
  bool tanh = true;                              // behind them, or ReLU
  bool reads_light = true, reads_guides = true;  // what it reads
};

struct Samples {
  Grid features, radiance, valid;  // [B, S, ., H, W]
};

/// Mean and population variance over the valid samples, [B, 1, 2C, H, W], means first.
Grid statistics(const Grid& values, const Grid& valid);

/// Each network by its name in the registry; result [B, 1, 3, H, W].
Grid network(const std::string& name, const Samples& samples, const Parameters& parameters,
             const NetworkLayout& layout);

}  // namespace ld::reference
