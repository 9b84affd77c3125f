#pragma once

#include <fmt/core.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>

namespace matchbox_slam {

/// Thrown when bytes end before what they announce.
class ByteError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Walks through bytes whose lengths may be lies, in the byte order of ROS, which is little-endian.
/// Whatever would go beyond the end throws ByteError instead. Does not own the bytes.
class ByteReader {
 public:
  ByteReader() = default;
  ByteReader(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}

  [[nodiscard]] const std::uint8_t* data() const { return data_; }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool empty() const { return size_ == 0; }

  /// The next `count` elements of so many bytes each.
  ByteReader take(std::size_t count, std::size_t element_size = 1) {
    if (count > size_ / element_size) {
      throw ByteError(fmt::format("{} elements of {} bytes are announced where {} bytes are left",
                                  count, element_size, size_));
    }
    const ByteReader taken(data_, count * element_size);
    data_ += taken.size_;
    size_ -= taken.size_;
    return taken;
  }

  template <typename Number>
  Number number() {
    Number value{};
    std::memcpy(&value, take(sizeof(Number)).data_, sizeof(Number));
    return value;
  }

  /// What follows a length of 32 bits and has this many elements.
  ByteReader array(std::size_t element_size = 1) {
    return take(number<std::uint32_t>(), element_size);
  }

  [[nodiscard]] std::string text() const { return {data_, data_ + size_}; }

 private:
  const std::uint8_t* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace matchbox_slam
