// Settings of a thread that hold while a scope lives, for what every call of it would otherwise have to hand
// on.
#pragma once

#include <utility>

namespace ld {

/// While a `Setting` (the class that derives from this) lives, current() of its thread is the value that it
/// was made with; then it is what it was before, so scopes nest. Outside of all it is Setting::outside().
template <class Setting, class T>
class ScopedValue {
 public:
  explicit ScopedValue(T value) : before_(std::exchange(place(), std::move(value))) {}
  ~ScopedValue() { place() = std::move(before_); }
  ScopedValue(const ScopedValue&) = delete;
  ScopedValue& operator=(const ScopedValue&) = delete;

  static const T& current() { return place(); }

 protected:
  static T outside() { return T(); }

 private:
  static T& place() {
    static thread_local T value = Setting::outside();
    return value;
  }

  T before_;
};

}  // namespace ld
