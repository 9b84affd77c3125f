#pragma once

#include <cstddef>
#include <memory>
#include <type_traits>

namespace matchbox_slam {

/// An array for what is written before it is read: nothing is filled or copied when it grows, and
/// its memory is kept from one use to the next, but for what only a large use needs.
template <typename T>
class ScratchBuffer {
 public:
  static_assert(std::is_trivial_v<T>);

  /// Bytes that are kept when fewer are wanted.
  static constexpr std::size_t kKeptBytes = std::size_t{1} << 21;

  /// Makes room for so many elements, of which none is set.
  T* make(std::size_t size) {
    if (size > capacity_ ||
        (sizeof(T) * capacity_ > kKeptBytes && sizeof(T) * size <= kKeptBytes)) {
      // A bit more, since the next use may want a bit more.
      capacity_ = sizeof(T) * size <= kKeptBytes ? size + size / 4 : size;
      elements_.reset();  // before there are both
      elements_.reset(new T[capacity_]);
    }
    return elements_.get();
  }

  [[nodiscard]] std::size_t capacity() const { return capacity_; }
  [[nodiscard]] T* data() { return elements_.get(); }
  [[nodiscard]] const T* data() const { return elements_.get(); }

 private:
  std::unique_ptr<T[]> elements_;  // NOLINT(modernize-avoid-c-arrays): as many as it takes
  std::size_t capacity_ = 0;
};

}  // namespace matchbox_slam
