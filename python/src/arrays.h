// Memory of ours as numpy arrays.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <memory>

namespace ld {

/// A Python object that keeps `owned` alive: the owner of arrays that look into it.
template <class T>
nanobind::capsule capsule_of(std::unique_ptr<T> owned) {
  nanobind::capsule owner(owned.get(), [](void* object) noexcept { delete static_cast<T*>(object); });
  owned.release();
  return owner;
}

}  // namespace ld
