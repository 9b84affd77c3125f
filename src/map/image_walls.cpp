#include "map/image_walls.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "matchbox_slam/map/reflection_grid.hpp"

namespace matchbox_slam {
namespace {

constexpr int kNeighbourhood = 3;  // [pixels] to each side, in which a wall is taken as straight
constexpr std::size_t kFewestOnLine = 4;  // a guess: half and double were not tried
constexpr double kLineThickness = 0.3;    // of its length, at most; rounder spots tell no direction

/// The pixels that a ray passes, exactly and in their order.
class RayWalk {
 public:
  RayWalk(const Eigen::Vector2d& origin, const Eigen::Vector2d& direction)
      : pixel_{cell_index(origin.x()), cell_index(origin.y())},
        step_{direction.x() < 0.0 ? -1 : 1, direction.y() < 0.0 ? -1 : 1},
        each_(1.0 / std::abs(direction.x()), 1.0 / std::abs(direction.y())),
        next_(first_border(origin.x(), pixel_.x, direction.x()),
              first_border(origin.y(), pixel_.y, direction.y())) {}

  [[nodiscard]] const Cell& pixel() const { return pixel_; }
  /// How far along the ray it was entered.
  [[nodiscard]] double entered() const { return entered_; }

  void go_on() {
    const bool is_along_x = next_.x() < next_.y();
    entered_ = is_along_x ? next_.x() : next_.y();
    if (is_along_x) {
      pixel_.x += step_.x;
      next_.x() += each_.x();
    } else {
      pixel_.y += step_.y;
      next_.y() += each_.y();
    }
  }

 private:
  /// Infinite where the ray runs along it.
  static double first_border(double from, int pixel, double direction) {
    if (direction == 0.0) {
      return std::numeric_limits<double>::infinity();
    }
    const double to_border = direction > 0.0 ? pixel + 1.0 - from : from - pixel;
    return to_border / std::abs(direction);
  }

  Cell pixel_;
  Cell step_;
  Eigen::Vector2d each_;
  Eigen::Vector2d next_;
  double entered_ = 0.0;
};

/// How far along a ray a wall is that it meets in a pixel, where the ray is `entered` far.
double range_to(const SurfaceHit& wall, const Eigen::Vector2d& origin,
                const Eigen::Vector2d& direction, double entered) {
  constexpr double kMaxPixelDistance = 1.5;  // [pixels]; a grazing ray meets the line anywhere
  const Eigen::Vector2d way = wall.position - origin;
  const double facing = wall.normal.dot(direction);
  const double on_line = wall.normal.dot(way) / facing;  // not finite where it faces nothing
  return std::abs(on_line - entered) <= kMaxPixelDistance ? on_line
                                                          : std::max(entered, way.dot(direction));
}

}  // namespace

ImageWalls::ImageWalls(const MapImage& image)
    : width_(image.width), height_(image.height), states_(image.pixels.size()) {
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      states_[index_of({x, y})] = image.state({x, y});
    }
  }
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      if (state({x, y}) == CellState::kOccupied) {
        wall_of_.emplace(index_of({x, y}), walls_.size());
        walls_.push_back(wall_in({x, y}));
      }
    }
  }
}

std::vector<Eigen::Vector2d> ImageWalls::touching_around(const Cell& pixel) const {
  constexpr int kSide = 2 * kNeighbourhood + 1;
  std::array<bool, std::size_t{kSide} * kSide> is_taken{};
  const auto take = [&](const Cell& near) {
    const int x = near.x - pixel.x + kNeighbourhood;
    const int y = near.y - pixel.y + kNeighbourhood;
    return x >= 0 && x < kSide && y >= 0 && y < kSide && state(near) == CellState::kOccupied &&
           !std::exchange(
               is_taken[static_cast<std::size_t>(y) * kSide + static_cast<std::size_t>(x)], true);
  };
  std::vector<Cell> touching;
  if (take(pixel)) {
    touching.push_back(pixel);
  }
  std::vector<Eigen::Vector2d> centers;
  for (std::size_t i = 0; i < touching.size(); ++i) {
    const Cell here = touching[i];
    centers.emplace_back(here.x + 0.5, here.y + 0.5);
    for (int y = here.y - 1; y <= here.y + 1; ++y) {
      for (int x = here.x - 1; x <= here.x + 1; ++x) {
        if (take({x, y})) {
          touching.push_back({x, y});
        }
      }
    }
  }
  return centers;
}

SurfaceHit ImageWalls::wall_in(const Cell& pixel) const {
  const Eigen::Vector2d center(pixel.x + 0.5, pixel.y + 0.5);
  const std::vector<Eigen::Vector2d> around = touching_around(pixel);
  if (around.size() < kFewestOnLine) {
    return {center, Eigen::Vector2d::Zero()};
  }
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& point : around) {
    mean += point / static_cast<double>(around.size());
  }
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector2d& point : around) {
    scatter += (point - mean) * (point - mean).transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(scatter);  // ascending
  if (std::sqrt(axes.eigenvalues()(0)) > kLineThickness * std::sqrt(axes.eigenvalues()(1))) {
    return {center, Eigen::Vector2d::Zero()};
  }
  const Eigen::Vector2d normal = axes.eigenvectors().col(0);
  return {center - normal * normal.dot(center - mean), normal};
}

std::vector<SurfaceHit> ImageWalls::faces() const {
  std::vector<SurfaceHit> faces;
  faces.reserve(walls_.size());
  for (const SurfaceHit& wall : walls_) {
    const bool is_front = is_free_towards(wall, wall.normal);
    const bool is_back = is_free_towards(wall, -wall.normal);
    if (is_front || !is_back) {
      faces.push_back(wall);
    }
    if (!wall.normal.isZero() && (is_back || !is_front)) {
      faces.push_back({wall.position, -wall.normal});
    }
  }
  return faces;
}

bool ImageWalls::is_free_towards(const SurfaceHit& wall, const Eigen::Vector2d& direction) const {
  constexpr double kWayStep = 0.5;  // [pixels]
  bool is_behind = false;           // the wall itself, which may be some pixels thick
  for (double way = 0.0; way <= kNeighbourhood; way += kWayStep) {
    const Eigen::Vector2d here = wall.position + way * direction;
    const CellState there = state({cell_index(here.x()), cell_index(here.y())});
    if (there == CellState::kFree) {
      return true;
    }
    if (there == CellState::kOccupied && is_behind) {
      return false;
    }
    is_behind = is_behind || there == CellState::kUnknown;
  }
  return false;
}

double ImageWalls::range(const Eigen::Vector2d& origin, const Eigen::Vector2d& direction,
                         double reach) const {
  constexpr int kMostUnknown = 3;  // before a wall, where beams that hit and that passed differ
  int unknown = 0;
  for (RayWalk walk(origin, direction); walk.entered() <= reach; walk.go_on()) {
    const CellState here = state(walk.pixel());
    if (here == CellState::kOccupied) {
      return range_to(walls_[wall_of_.at(index_of(walk.pixel()))], origin, direction,
                      walk.entered());
    }
    unknown = here == CellState::kUnknown ? unknown + 1 : 0;
    if (unknown > kMostUnknown || !contains(walk.pixel())) {
      return std::numeric_limits<double>::quiet_NaN();
    }
  }
  return std::numeric_limits<double>::infinity();
}

bool ImageWalls::is_in_sight(const Cell& from, const Cell& to) const {
  bool is_free = true;
  walk_cells(from, to,
             [&](const Cell& pixel) { is_free = is_free && state(pixel) == CellState::kFree; });
  return is_free && state(to) == CellState::kFree;
}

}  // namespace matchbox_slam
