// Crops of packed frames as frames and images again, for tests. Link ld_frame_store.
#pragma once

#include "dataset/crop.h"

namespace ld {

inline Augmentation whole_frame(int width, int height, bool flip_x = false, bool flip_y = false,
                                int quarter_turns = 0) {
  Augmentation a;
  a.width = width;
  a.height = height;
  a.flip_x = flip_x;
  a.flip_y = flip_y;
  a.quarter_turns = quarter_turns;
  return a;
}

struct CropOfFrame {
  Frame frame;  // its channels as a network sees them (frame/encoding.h)
  std::vector<float> radiance;
  Image reference;
};

inline CropOfFrame crop_of(const PackedFrame& packed, const Augmentation& a) {
  CropOfFrame crop = {Frame(a.result_width(), a.result_height(), packed.spp, frame_channels(packed.features)),
                      {},
                      Image(a.result_width(), a.result_height(), 3)};
  const size_t pixels = crop.frame.plane_size(), samples = pixels * static_cast<size_t>(packed.spp);
  crop.frame.features = packed.features;
  crop.radiance.resize(3 * samples);
  std::vector<float> features(samples * static_cast<size_t>(packed.channels())), valid(samples);
  read_crop(packed, a, packed.features,
            {features.data(), crop.radiance.data(), valid.data(), crop.reference.pixels.data()});
  const float* plane = features.data();
  for (int s = 0; s < packed.spp; ++s)
    for (const std::string& name : packed.features)
      for (int c = 0; c < find_feature(name).channels; ++c, plane += pixels)
        std::copy_n(plane, pixels, crop.frame.plane(s, find_feature(name).offset + c));
  crop.frame.valid.assign(valid.begin(), valid.end());
  return crop;
}

inline PackedFrame pack(const Frame& frame, const Image& reference,
                        const std::vector<std::string>& features) {
  FramePair pair;
  pair.frame = frame;
  pair.reference.image = reference;
  return pack(pair, features);
}

/// A frame packed with its mean as the reference.
inline PackedFrame pack(const Frame& frame) {
  return pack(frame, mean_radiance(frame), frame.features);
}

}  // namespace ld
