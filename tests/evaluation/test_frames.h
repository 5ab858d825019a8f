// Small frames in memory for the tests of the evaluation.
#pragma once

#include <cmath>
#include <functional>
#include <string>

#include "core/error.h"
#include "core/random.h"
#include "evaluation/evaluator.h"

namespace ld {

/// A smooth picture that differs with `number`, [3, H, W].
inline Image smooth_picture(int width, int height, int number) {
  Image image(width, height, 3);
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        image.at(c, x, y) =
            0.6F + 0.4F * static_cast<float>(std::sin(0.2 * x + 0.1 * (c + number)) * std::cos(0.15 * y));
  return image;
}

/// The picture with multiplicative noise, `spp` samples a pixel; guides are 0.
inline EvaluationFrame noisy_frame(const std::string& name, int width, int height, int spp, int number) {
  EvaluationFrame result{name, Frame(width, height, spp), smooth_picture(width, height, number)};
  RandomStream stream(5, RandomPurpose::test, static_cast<uint32_t>(number));
  for (int s = 0; s < spp; ++s)
    for (int c = 0; c < 3; ++c)
      for (size_t i = 0; i < result.frame.plane_size(); ++i)
        result.frame.plane(s, c)[i] =
            result.reference.plane(c)[i] * static_cast<float>(std::exp(0.8 * stream.normal()));
  return result;
}

/// The same as a frame of a sequence: a wall that faces the camera and stands still.
inline EvaluationFrame still_frame(const std::string& name, int width, int height, int64_t sequence,
                                   int64_t position) {
  EvaluationFrame result = noisy_frame(name, width, height, 2, static_cast<int>(10 * sequence + position));
  result.reference = smooth_picture(width, height, static_cast<int>(sequence));
  result.in_sequence = SequencePlace{sequence, position};
  result.frame.features.emplace_back("flow");
  for (int s = 0; s < result.frame.spp; ++s)
    for (size_t i = 0; i < result.frame.plane_size(); ++i)
      result.frame.plane(s, kNormalOffset + 2)[i] = result.frame.plane(s, kDepthOffset)[i] = 1;
  return result;
}

/// The least of all methods.
inline Image mean_of_samples(const Frame& frame, SequenceState&) {
  return mean_radiance(frame);
}

/// What an Error said, "" when none was thrown.
inline std::string message_of(const std::function<void()>& body) {
  try {
    body();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

}  // namespace ld
