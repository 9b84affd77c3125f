#include "io/map_kind.hpp"

#include <algorithm>
#include <array>
#include <fstream>
#include <string_view>

namespace matchbox_slam {

bool is_bag(const std::string& path) {
  constexpr std::array<std::string_view, 3> kHeads = {"#ROSBAG V", "SQLite format 3", "\x89MCAP"};
  std::array<char, 16> bytes{};
  std::ifstream(path, std::ios::binary).read(bytes.data(), bytes.size());
  const std::string_view beginning(bytes.data(), bytes.size());
  return std::any_of(kHeads.begin(), kHeads.end(),
                     [&](const auto& head) { return beginning.substr(0, head.size()) == head; });
}

}  // namespace matchbox_slam
