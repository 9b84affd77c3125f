#pragma once

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "bag/byte_reader.hpp"

namespace matchbox_slam {

/// Walks through a message in the Common Data Representation of OMG (XCDR version 1, plain), either
/// byte order, as ROS 2 records it: four bytes that tell the order, then the fields, each aligned
/// to its own size. Whatever would go beyond the end throws ByteError.
class CdrReader {
 public:
  explicit CdrReader(ByteReader bytes) {
    const ByteReader head = bytes.take(4);
    constexpr std::uint8_t kLittleEndian = 1;
    if (head.data()[0] != 0 || head.data()[1] > kLittleEndian) {
      throw ByteError(fmt::format(
          "it is not in plain CDR: it begins with the bytes {} and {}; allowed: 0, then 0 or 1",
          head.data()[0], head.data()[1]));
    }
    is_swapped_ = head.data()[1] != kLittleEndian;
    size_ = bytes.size();
    left_ = bytes;
  }

  template <typename Number>
  Number number() {
    Number value{};
    read(&value, 1);
    return value;
  }

  bool boolean() { return number<std::uint8_t>() != 0; }

  /// Text, after its length with the zero at its end.
  std::string text() {
    const std::string text = left_with_count(1).text();
    const std::size_t end = text.find('\0');
    return end == std::string::npos ? text : text.substr(0, end);
  }

  /// Numbers of which there are so many.
  template <typename Array>
  void fixed_array(Array& numbers) {
    read(numbers.data(), numbers.size());
  }

  /// Numbers after their count.
  template <typename Number>
  void sequence(std::vector<Number>& numbers) {
    const auto count = number<std::uint32_t>();
    if (count == 0) {
      numbers.clear();
      return;
    }
    align(sizeof(Number));
    (void)ByteReader(left_).take(count, sizeof(Number));  // before the memory for them is got
    numbers.resize(count);
    read(numbers.data(), count);
  }

  /// The count of what follows, each of so many bytes at least.
  std::size_t count(std::size_t least_bytes) {
    const auto count = number<std::uint32_t>();
    (void)ByteReader(left_).take(count, least_bytes);
    return count;
  }

 private:
  ByteReader left_with_count(std::size_t element_size) {
    const auto count = number<std::uint32_t>();
    return left_.take(count, element_size);
  }

  void align(std::size_t size) {
    const std::size_t beyond = (size_ - left_.size()) % size;
    (void)left_.take(beyond == 0 ? 0 : size - beyond);
  }

  template <typename Number>
  void read(Number* numbers, std::size_t count) {
    align(sizeof(Number));
    const ByteReader taken = left_.take(count, sizeof(Number));
    if (!is_swapped_) {
      std::memcpy(numbers, taken.data(), taken.size());
      return;
    }
    for (std::size_t k = 0; k < count; ++k) {
      std::array<std::uint8_t, sizeof(Number)> bytes{};
      const std::uint8_t* begin = taken.data() + k * sizeof(Number);
      std::reverse_copy(begin, begin + sizeof(Number), bytes.begin());
      std::memcpy(numbers + k, bytes.data(), sizeof(Number));
    }
  }

  ByteReader left_;
  std::size_t size_ = 0;  ///< of all after the first four bytes, from which alignment counts
  bool is_swapped_ = false;
};

}  // namespace matchbox_slam
