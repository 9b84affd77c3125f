#include "io/scale_bar.hpp"

#include <cmath>
#include <string>

#include "io/map_style.hpp"
#include "matchbox_slam/common/parameters.hpp"

namespace matchbox_slam {
namespace {

/// The longest of 1, 2 or 5 times a power of ten metres that is at most `longest`.
double round_length(double longest) {
  const double power = std::pow(10.0, std::floor(std::log10(longest)));
  for (const double factor : {5.0, 2.0}) {
    if (factor * power <= longest) {
      return factor * power;
    }
  }
  return power;
}

std::string length_text(double metres) {
  return (metres >= 1.0 ? std::to_string(std::lround(metres)) : to_string(metres)) + " m";
}

}  // namespace

void draw_scale_bar(const ScaleBar& bar, Picture& picture) {
  const double metres = round_length(bar.longest / bar.pixels_per_metre);
  const int dot = bar.dot;
  const int right = bar.left + static_cast<int>(std::lround(metres * bar.pixels_per_metre));
  const int middle = bar.middle;
  picture.fill(bar.left, middle - dot / 2, right, middle + dot - dot / 2, kTextColor);
  picture.fill(bar.left, middle - 3 * dot, bar.left + dot, middle + 3 * dot, kTextColor);
  picture.fill(right - dot, middle - 3 * dot, right, middle + 3 * dot, kTextColor);
  picture.draw_text(right + 5 * dot, middle, length_text(metres), bar.font_size, kTextColor);
}

}  // namespace matchbox_slam
