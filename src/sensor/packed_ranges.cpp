#include "sensor/packed_ranges.hpp"

#include <algorithm>
#include <array>
#include <cstring>

// The numbers of floats of one sign rise with their bits, so that the difference between the bits
// of neighbours is small where their ranges are alike. Of each eight differences all are kept with
// as many bits as the largest takes, told by a byte before them; eight of w bits take w bytes.

namespace matchbox_slam {
namespace {

constexpr std::size_t kGroup = 8;
using Group = std::array<std::uint32_t, kGroup>;

std::uint32_t bits_of(float value) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, &value, sizeof bits);
  return bits;
}

float float_of(std::uint32_t bits) {
  float value = 0.0F;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

/// Differences of either sign, modulo 2^32, as numbers that are small when they are: 0, -1, 1, -2.
std::uint32_t folded(std::uint32_t difference) {
  return (difference << 1U) ^ (0U - (difference >> 31U));
}

std::uint32_t unfolded(std::uint32_t number) { return (number >> 1U) ^ (0U - (number & 1U)); }

unsigned width_of(const Group& group) {
  std::uint32_t all = 0;
  for (const std::uint32_t number : group) {
    all |= number;
  }
  unsigned width = 0;
  for (; all != 0; all >>= 1U) {
    ++width;
  }
  return width;
}

void pack(const Group& group, std::vector<std::uint8_t>& packed) {
  const unsigned width = width_of(group);
  packed.push_back(static_cast<std::uint8_t>(width));
  std::uint64_t waiting = 0;
  unsigned count = 0;
  for (const std::uint32_t number : group) {
    waiting |= std::uint64_t{number} << count;
    for (count += width; count >= 8; count -= 8) {
      packed.push_back(static_cast<std::uint8_t>(waiting));
      waiting >>= 8U;
    }
  }
}

/// @returns where the next group begins.
const std::uint8_t* unpack(const std::uint8_t* at, Group& group) {
  const unsigned width = *at++;
  const std::uint64_t mask = (std::uint64_t{1} << width) - 1;
  std::uint64_t waiting = 0;
  unsigned count = 0;
  for (std::uint32_t& number : group) {
    for (; count < width; count += 8) {
      waiting |= std::uint64_t{*at++} << count;
    }
    number = static_cast<std::uint32_t>(waiting & mask);
    waiting >>= width;
    count -= width;
  }
  return at;
}

}  // namespace

std::vector<std::uint8_t> pack_ranges(const std::vector<float>& ranges) {
  std::vector<std::uint8_t> packed;
  packed.reserve(ranges.size() * sizeof(float) + ranges.size() / kGroup + 1);
  std::uint32_t before = 0;
  for (std::size_t begin = 0; begin < ranges.size(); begin += kGroup) {
    Group group{};
    for (std::size_t i = begin; i < std::min(begin + kGroup, ranges.size()); ++i) {
      const std::uint32_t bits = bits_of(ranges[i]);
      group[i - begin] = folded(bits - before);
      before = bits;
    }
    pack(group, packed);
  }
  packed.shrink_to_fit();
  return packed;
}

std::vector<float> unpack_ranges(const std::vector<std::uint8_t>& packed, std::size_t count) {
  std::vector<float> ranges(count);
  std::uint32_t before = 0;
  const std::uint8_t* at = packed.data();
  for (std::size_t begin = 0; begin < count; begin += kGroup) {
    Group group{};
    at = unpack(at, group);
    for (std::size_t i = begin; i < std::min(begin + kGroup, count); ++i) {
      before += unfolded(group[i - begin]);
      ranges[i] = float_of(before);
    }
  }
  return ranges;
}

}  // namespace matchbox_slam
