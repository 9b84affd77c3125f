#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "io/picture.hpp"

namespace matchbox_slam {

// How maps are drawn for people, in pictures and movies alike. The lines differ in lightness and in
// dashes too, for those who do not tell the hues apart.
constexpr Color kUnknownColor{222, 225, 229};
constexpr Color kFreeColor{255, 255, 255};
constexpr Color kOccupiedColor{28, 36, 48};
constexpr Color kTextColor{52, 60, 72};
constexpr Color kRuleColor{190, 195, 202};
constexpr Color kStartColor{25, 150, 70};
constexpr Stroke kOdometryStroke{{240, 130, 20}, 2.2, 8.0};
constexpr Stroke kTrajectoryStroke{{20, 95, 215}, 2.6, 0.0};
constexpr Stroke kLoopStroke{{200, 20, 120}, 3.4, 0.0};

/// How dark a cell is drawn, 0...1. One that is nearly sure is drawn as if it were: clean white and
/// dark are easier to read.
[[nodiscard]] inline double darkness_of(double occupancy) {
  constexpr double kWhiteOccupancy = 0.2;
  constexpr double kBlackOccupancy = 0.8;
  return std::clamp((occupancy - kWhiteOccupancy) / (kBlackOccupancy - kWhiteOccupancy), 0.0, 1.0);
}

/// The color of a cell that was seen.
[[nodiscard]] inline Color color_of_darkness(double darkness) {
  const auto blend = [darkness](int free, int occupied) {
    return static_cast<std::uint8_t>(std::lround(free + darkness * (occupied - free)));
  };
  return {blend(kFreeColor.red, kOccupiedColor.red), blend(kFreeColor.green, kOccupiedColor.green),
          blend(kFreeColor.blue, kOccupiedColor.blue)};
}

}  // namespace matchbox_slam
