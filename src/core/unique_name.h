// Names that nobody else gives to a file.
#pragma once

#include <string>

namespace ld {

/// Another text at every call, for the names of temporary files: the number of the process, by which people
/// find who left a file behind, and 64 random bits. Two containers on one disk may have the same host name
/// and the same numbers of processes; so these alone do not tell them apart.
std::string unique_name();

}  // namespace ld
