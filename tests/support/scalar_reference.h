// The parts of [MH20]'s networks as plain loops in double, written from its equations and appendix A (with k
// >= l in eq. 2, layers 0 to N-1 in eq. 5 and the embeddings divided by the number of samples): independent
// of src/ops and models, without their stable formulation, for logits of moderate size. The whole networks
// are in scalar_networks.h.
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
/// Full resolution (the context) first, then the outputs of the decoder blocks at 1/2, 1/4, ... and of the
/// bottleneck, each of ceil(h / 2^i) x ceil(w / 2^i).
std::vector<Grid> unet(const Grid& input, const Parameters& parameters, const UNetLayout& layout);

/// A picture scaled up, pixel centres of the fine grid between those of the coarse one.
Grid upsample(const Grid& in, int64_t factor, bool bilinear);

/// A picture of another size: the last row and column repeated, or cropped.
Grid resize(const Grid& in, int64_t h, int64_t w);

/// Calls body(b, s, y, x) for all pixels of all S.
template <class Body>
void each(const Grid& g, Body body) {
  for (int64_t b = 0; b < g.b; ++b)
    for (int64_t s = 0; s < g.s; ++s)
      for (int64_t y = 0; y < g.h; ++y)
        for (int64_t x = 0; x < g.w; ++x) body(b, s, y, x);
}

}  // namespace ld::reference
