// What follows a convolution.
#pragma once

namespace ld {

enum class Activation { none, leaky_relu, relu, tanh };

}  // namespace ld
