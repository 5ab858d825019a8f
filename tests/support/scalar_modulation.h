// Demodulation (models/demodulation.h) as plain loops in double: what every network has around its filter.
#pragma once

#include "tests/support/scalar_networks.h"

namespace ld::reference {

/// a_s: albedo + specular in [0.02, 64], 1 where all channels are at most 1e-4.
Grid demodulator(const Grid& features, const NetworkLayout& layout);

/// L / a, L.
Grid both_forms(const Grid& radiance, const Grid& a);

/// exp(-12 v), v the mean of the relative variances in the 3x3 pixels that there are.
Grid steadiness(const Grid& statistics);

/// The picture of both forms as filtered, the statistics of a and the logits of beta.
Grid modulated(const Grid& both, const Grid& statistics, const Grid& beta_logits);

}  // namespace ld::reference
