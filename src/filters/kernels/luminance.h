// Luminance of linear colours: ITU-R BT.709.
#pragma once

namespace ld {

constexpr float kLuminanceRed = 0.2126F, kLuminanceGreen = 0.7152F, kLuminanceBlue = 0.0722F;

}  // namespace ld
