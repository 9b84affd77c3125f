#include "simulation/solid_plan.hpp"

#include <algorithm>
#include <cmath>

namespace matchbox_slam {
namespace {

constexpr double kCellsPerMetre = 10.0;

int to_cells(double metres) { return static_cast<int>(std::lround(kCellsPerMetre * metres)); }

}  // namespace

SolidPlan::SolidPlan(const Eigen::Vector2d& size)
    : columns_(to_cells(size.x())),
      rows_(to_cells(size.y())),
      free_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), false) {}

bool SolidPlan::is_free(int column, int row) const {
  return column >= 0 && column < columns_ && row >= 0 && row < rows_ &&
         free_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
               static_cast<std::size_t>(column)];
}

void SolidPlan::set(const Eigen::Vector2d& corner, const Eigen::Vector2d& opposite, bool is_free) {
  const Eigen::Vector2d low = corner.cwiseMin(opposite);
  const Eigen::Vector2d high = corner.cwiseMax(opposite);
  const int left = std::clamp(to_cells(low.x()), 0, columns_);
  const int right = std::clamp(to_cells(high.x()), 0, columns_);
  for (int row = std::max(0, to_cells(low.y())); row < std::min(rows_, to_cells(high.y())); ++row) {
    const auto first = free_.begin() + static_cast<std::ptrdiff_t>(row) * columns_;
    std::fill(first + left, first + right, is_free);
  }
}

void SolidPlan::add_walls(bool along_x, std::vector<WallSegment>& walls) const {
  const int length = along_x ? columns_ : rows_;
  const int lines = along_x ? rows_ : columns_;
  const auto is_wall = [&](int line, int at) {
    return along_x ? is_free(at, line) != is_free(at, line - 1)
                   : is_free(line, at) != is_free(line - 1, at);
  };
  const auto point = [&](int line, int at) {
    const Eigen::Vector2d cells = along_x ? Eigen::Vector2d(at, line) : Eigen::Vector2d(line, at);
    return Eigen::Vector2d(cells / kCellsPerMetre);
  };
  for (int line = 0; line <= lines; ++line) {
    for (int at = 0; at < length; ++at) {
      const int begin = at;
      while (at < length && is_wall(line, at)) {
        ++at;
      }
      if (at > begin) {
        walls.push_back({point(line, begin), point(line, at)});
      }
    }
  }
}

std::vector<WallSegment> SolidPlan::walls() const {
  std::vector<WallSegment> walls;
  add_walls(true, walls);
  add_walls(false, walls);
  return walls;
}

}  // namespace matchbox_slam
