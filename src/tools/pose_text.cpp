#include "tools/pose_text.hpp"

#include <cmath>
#include <vector>

#include "common/number_text.hpp"
#include "matchbox_slam/common/options.hpp"

namespace matchbox_slam {

std::optional<Pose2> parse_pose(const std::string& text, std::size_t least) {
  constexpr std::size_t kAll = 3;
  constexpr double kFarthest = 1e8;  // [m], as of start_x
  std::vector<double> numbers;
  for (const std::string& word : split(text, ',')) {
    const std::optional<double> number = finite_number(word);
    if (!number) {
      return std::nullopt;
    }
    numbers.push_back(*number);
  }
  if (numbers.size() < least || numbers.size() > kAll) {
    return std::nullopt;
  }
  numbers.resize(kAll, 0.0);
  if (std::abs(numbers[0]) > kFarthest || std::abs(numbers[1]) > kFarthest) {
    return std::nullopt;
  }
  return Pose2{numbers[0], numbers[1], wrap_angle(numbers[2])};
}

}  // namespace matchbox_slam
