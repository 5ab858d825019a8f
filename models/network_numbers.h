// Numbers of the networks that their ONNX form has too. Free of LibTorch.
#pragma once

namespace ld {

// models/demodulation.h.
constexpr double kNoReflectance = 1e-4;  // a reflectance of at most so much in all channels counts as none
constexpr double kLeastReflectance = 0.02, kMostReflectance = 64;
constexpr double kLargestDemodulated = 1e35;  // of a radiance that is divided: 50 times it is finite
constexpr double kLargestModulated = 1e34;    // of a picture that is mixed; beyond, the plain one is taken
constexpr double kSteadyFalloff = 12;         // of beta's input with the variance

// models/rejection.h.
constexpr double kMostRejected = 16;  // a pixel's layer counts for e^-16, 1e-7, of another's at least

// models/history.h.
constexpr double kLongestHistory = 32;     // frames that a history counts for at most
constexpr double kBrightestHistory = 2;    // times the light of the present: no more of the past is believed
constexpr double kInitialHistory = -1;     // the gate's logit before anything is learnt, less
constexpr double kInitialChange = 20;      // so many times the relative change of the light
constexpr double kLargestCompared = 1e35;  // of light: sums over a neighbourhood are finite
constexpr int kComparedRadius = 2;         // pixels: of the neighbourhood, 5x5

// models/recurrent.h.
constexpr double kRecurrentSlope = 0.1;    // of its leaky ReLUs, below 0
constexpr double kLightPower = 0.2;        // light is seen, predicted and compared to this power
constexpr double kLeastTexture = 1e-3;     // what light is divided by at least
constexpr double kLargestState = 65504;    // what a frame hands on lies within: no sequence diverges
constexpr double kLargestRoot = 2.5e7;     // of light that is predicted: its fifth power is 1e37
constexpr double kLargestEmission = 3e38;  // beside which that fits into a float
constexpr double kLeastBesideEmission = 1.0 / 2048;  // part of it: less light is what halves round

// models/exposure.h.
constexpr double kMiddleGrey = 0.18;

}  // namespace ld
