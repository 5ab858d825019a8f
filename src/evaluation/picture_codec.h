// Pictures as text inside a web page: small, and every half float kept.
#pragma once

#include <string>

#include "frame/frame.h"

namespace ld {

/// Half floats (beyond +-65504 cut to it; NaN and infinities kept) of the planes one after the other; in each
/// row differences of neighbours' bits modulo 2^16; the high bytes of all values, then the low ones; zlib;
/// base64. The report's decode.js is the inverse. Throws Error when zlib fails.
std::string encode_picture(const Image& image);

}  // namespace ld
