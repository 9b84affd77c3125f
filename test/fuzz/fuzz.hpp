#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <string>
#include <vector>

#include "matchbox_slam/common/random.hpp"

namespace matchbox_slam {

/// How many inputs a driver tries: a few in every test run, more where MATCHBOX_FUZZ_INPUTS says
/// so.
[[nodiscard]] inline std::uint64_t fuzz_inputs(std::uint64_t usual) {
  const char* text = std::getenv("MATCHBOX_FUZZ_INPUTS");
  return text != nullptr ? std::strtoull(text, nullptr, 10) : usual;
}

/// The first input's number; every number is an input that can be tried again by itself.
[[nodiscard]] inline std::uint64_t first_fuzz_input() {
  const char* text = std::getenv("MATCHBOX_FUZZ_FIRST");
  return text != nullptr ? std::strtoull(text, nullptr, 10) : 0;
}

/// Whether more than a share of all inputs came out so. Of a few, such as one that is tried again
/// by itself, none has to.
[[nodiscard]] inline bool is_enough(std::uint64_t found, std::uint64_t count, double share) {
  constexpr std::uint64_t kFew = 200;
  return count < kFew || static_cast<double>(found) > share * static_cast<double>(count);
}

[[nodiscard]] inline std::size_t below(std::size_t count, Random& random) {
  return static_cast<std::size_t>(random.next() % count);
}

[[nodiscard]] inline bool happens(double probability, Random& random) {
  return random.uniform() < probability;
}

template <typename Element>
[[nodiscard]] const Element& one_of(const std::vector<Element>& elements, Random& random) {
  return elements[below(elements.size(), random)];
}

/// A number that programs do not expect.
[[nodiscard]] inline double odd_number(Random& random) {
  using Limits = std::numeric_limits<double>;
  static const std::vector<double> kNumbers = {0.0,
                                               -0.0,
                                               1.0,
                                               -1.0,
                                               1e-300,
                                               1e-30,
                                               1e-9,
                                               -1e-9,
                                               0.1,
                                               3.2,
                                               100.,
                                               1e5,
                                               -1e5,
                                               1e9,
                                               -1e9,
                                               2147483648.0,
                                               4294967295.0,
                                               9.2e18,
                                               1e30,
                                               1e38,
                                               4e38,
                                               -1e30,
                                               1e154,
                                               1e300,
                                               Limits::max(),
                                               Limits::min(),
                                               Limits::denorm_min(),
                                               Limits::infinity(),
                                               -Limits::infinity(),
                                               Limits::quiet_NaN()};
  return happens(0.7, random) ? one_of(kNumbers, random)
                              : random.gaussian() * std::pow(10.0, random.uniform(-6.0, 9.0));
}

/// The bytes with a few of them changed, left out, repeated or replaced by one of the words.
[[nodiscard]] inline std::string mutated(std::string bytes, const std::vector<std::string>& words,
                                         Random& random) {
  for (std::size_t left = 1 + below(6, random); left > 0; --left) {
    const std::size_t at = below(bytes.size() + 1, random);
    const std::size_t count = below(std::min<std::size_t>(bytes.size() - at, 40) + 1, random);
    switch (below(6, random)) {
      case 0:
        if (at < bytes.size()) {
          bytes[at] = static_cast<char>(bytes[at] ^ (1 << below(8, random)));
        }
        break;
      case 1:
        if (at < bytes.size()) {
          bytes[at] = static_cast<char>(random.next());
        }
        break;
      case 2:
        bytes.erase(at, count);
        break;
      case 3:
        bytes.insert(below(bytes.size() + 1, random), bytes.substr(at, count));
        break;
      case 4:
        bytes.replace(at, count, one_of(words, random));
        break;
      default:
        bytes.insert(at, one_of(words, random));
        break;
    }
  }
  if (happens(0.02, random)) {
    bytes.resize(below(bytes.size() + 1, random));
  }
  return bytes;
}

}  // namespace matchbox_slam
