// The layered denoiser of [MH20] as plain loops in double, written from its equations and appendix A (with k
// >= l in eq. 2, layers 0 to N-1 in eq. 5 and the embeddings divided by the number of samples): independent
// of src/ops and models, without their stable formulation, for logits of moderate size.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "tests/support/grid.h"

namespace ld::reference {

struct Parameter {
  std::vector<int64_t> shape;
  std::vector<double> values;
};
using Parameters = std::map<std::string, Parameter>;  // by the names of the network's parameters

/// Layers PREFIX0.weight, PREFIX0.bias, PREFIX1.weight, ... on [x, shared]; shared (S = 1) may be empty.
Grid fully_connected(const Grid& x, const Grid& shared, const Parameters& parameters,
                     const std::string& prefix, bool activate_last);

Grid masked_mean(const Grid& values, const Grid& valid);

/// eq. 1 and 2: S is the layer.
struct Layers {
  Grid weight, occupancy, radiance, embedding;
};
Layers partition(const Grid& logits, const Grid& valid, const Grid& radiance, const Grid& embedding);

/// Appendix A line 26 and eq. 3: scatters `values` with exp(logit - largest logit of the pixel over taps and
/// layers).
Grid splat(const Grid& logits, const Grid& values);

/// eq. 4 and 5; 0 where no occupancy arrives.
Grid composite(const Grid& filtered_radiance, const Grid& filtered_weight, const Grid& filtered_occupancy);

/// The U-net's blocks by their numbers of convolutions.
struct UNetLayout {
  std::vector<int64_t> encoder, decoder;
  int64_t bottleneck = 1;
  bool bilinear = true;
};
Grid unet(const Grid& input, const Parameters& parameters, const UNetLayout& layout);

/// Appendix A from end to end.
Grid layer_network(const Grid& features, const Grid& radiance, const Grid& valid,
                   const Parameters& parameters, const UNetLayout& layout);

}  // namespace ld::reference
