// Modules: parts of the programs that are loaded when they are first needed. What reads other programs' files
// brings hundreds of libraries (OpenImageIO's are OpenCV, GDAL, FFmpeg, ...), for which nobody should wait
// who has no such files.
//
// A module is a shared library of its own (`ld_module` in CMakeLists.txt) in lib/layer_denoiser beside the
// program's bin/, built or installed. It exports one C function, ld_module(), that returns a pointer to an
// abstract interface which both sides know; LD_MODULE writes it. Modules and programs are compiled together,
// so all types may cross. A module links none of our libraries: what holds state (log, signals, progress)
// stays with the program. It has a copy of core/error.cpp, and what it throws is caught as an Error: types
// are compared by name.
#pragma once

#include <string>

/// At the end of a module, outside namespaces: the object of this type is what load_module() returns.
#define LD_MODULE(Interface, Implementation)                                 \
  extern "C" __attribute__((visibility("default"))) const void* ld_module(); \
  const void* ld_module() {                                                  \
    static const Implementation implementation;                              \
    return static_cast<const Interface*>(&implementation);                   \
  }

namespace ld {

/// Loads libNAME.so and returns its interface; it stays loaded. `use` says what it is for ("reads HDF5
/// files"), `remedy` what to do where it is missing. Throws Error: missing, or something that it needs is.
const void* load_module(const std::string& name, const std::string& use, const std::string& remedy);

}  // namespace ld
