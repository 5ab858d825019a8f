// How a training begins: weights and biases of a new network.
#pragma once

#include "models/network.h"

namespace ld {

/// Weights as network.initialisation says, biases zero, the same bits for the same seed:
///  - xavier: uniform with variance 2 / (inputs + outputs) (Glorot and Bengio 2010, eq. 16), as [MH20]
///    section 4;
///  - he: uniform with variance 2 / ((1 + a^2) inputs), a the slope of its leaky ReLUs below 0 (0.01, or 0.1)
///  (He et al. 2015, eq. 14) for what a leaky ReLU
///    follows, so that activations keep their size through all layers; xavier for output layers (logits of
///    kernels and partition, context). Network "recurrent" has no such: all of its weights begin so, as
///    Chaitanya et al. 2017 have it.
/// A convolution's inputs and outputs count its taps. With network.initial_kernel all kernels begin as a
/// Gaussian of that deviation, and network "optimized" with its full resolution, so that a training begins
/// with a blur in place of the 9x9 or 17x17 box that kernels of equal logits are.
void initialise(Network& network, uint64_t seed);

}  // namespace ld
