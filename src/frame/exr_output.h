// EXR files through a stream of ours: OpenEXR writes the end of a file in a destructor, which tells nobody
// when there is no room for it.
#pragma once

#include <ImfIO.h>

#include <filesystem>
#include <functional>

namespace ld {

/// Calls write(stream), in which OpenEXR's object for the file begins and ends, and writes what it gives to
/// `temporary`. Throws Error, which names `path`, for the first byte that could not be written and for what
/// OpenEXR throws.
void write_exr_file(const std::filesystem::path& temporary, const std::filesystem::path& path,
                    const std::function<void(Imf::OStream&)>& write);

}  // namespace ld
