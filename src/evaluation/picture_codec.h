// Pictures as text inside a web page: small, and every half float kept.
#pragma once

#include <string>

#include "frame/frame.h"

namespace ld {

/// Half floats (beyond +-65504 cut to it; NaN and infinities kept) of the planes one after the other; in each
/// row differences of neighbours' bits modulo 2^16; the high bytes of all values, then the low ones; zlib;
/// base64. The report's decode.js is the inverse. Throws Error when zlib fails.
std::string encode_picture(const Image& image);

/// What a screen shows of it, in a quarter of the space: tone-mapped 8 bits; in each row differences of
/// neighbours modulo 256; zlib; base64. NaN counts as black.
std::string encode_shown_picture(const Image& image);

}  // namespace ld
