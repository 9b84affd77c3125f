#include "map/image_viewpoints.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <queue>
#include <utility>

namespace matchbox_slam {
namespace {

constexpr double kStep = 0.4;        // [m] between places that are looked at
constexpr double kRoom = 0.2;        // [m] that is free around a robot
constexpr double kSharedView = 2.0;  // [m] from which a viewpoint sees what is seen from a place

int pixels(double metres, double resolution) {
  return std::max(1, static_cast<int>(std::lround(metres / resolution)));
}

/// Whether the square around a pixel is free.
bool has_room(const ImageWalls& walls, const Cell& pixel, int around) {
  for (int y = pixel.y - around; y <= pixel.y + around; ++y) {
    for (int x = pixel.x - around; x <= pixel.x + around; ++x) {
      if (walls.state({x, y}) != CellState::kFree) {
        return false;
      }
    }
  }
  return true;
}

/// Places a step apart where a robot has room, and which of them see each other.
class Places {
 public:
  Places(const ImageWalls& walls, double resolution)
      : step_(pixels(kStep, resolution)),
        columns_((walls.width() + step_ - 1) / step_),
        rows_((walls.height() + step_ - 1) / step_),
        number_of_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), kNone) {
    const int around = static_cast<int>(kRoom / resolution);
    for (int row = 0; row < rows_; ++row) {
      for (int column = 0; column < columns_; ++column) {
        if (const auto pixel = first_with_room(column, row, around, walls)) {
          number_of_[index_of(column, row)] = pixels_.size();
          pixels_.push_back(*pixel);
        }
      }
    }
    const int reach = std::max(1, static_cast<int>(kSharedView / (step_ * resolution)));
    for (const Cell& pixel : pixels_) {
      seen_.push_back(seen_from(pixel, reach, walls));
    }
  }

  [[nodiscard]] const std::vector<Cell>& all() const { return pixels_; }
  /// Numbers of the places near one that it sees, itself among them.
  [[nodiscard]] const std::vector<std::size_t>& seen(std::size_t place) const {
    return seen_[place];
  }

 private:
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

  [[nodiscard]] std::size_t index_of(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(column);
  }

  /// The one in the middle of a step where that has room: a narrow corridor lies as it likes.
  [[nodiscard]] std::optional<Cell> first_with_room(int column, int row, int around,
                                                    const ImageWalls& walls) const {
    for (int i = 0; i < step_ * step_; ++i) {
      const int x = (i + step_ / 2) % step_;
      const int y = (i / step_ + step_ / 2) % step_;
      const Cell pixel{column * step_ + x, row * step_ + y};
      if (has_room(walls, pixel, around)) {
        return pixel;
      }
    }
    return std::nullopt;
  }

  [[nodiscard]] std::vector<std::size_t> seen_from(const Cell& from, int reach,
                                                   const ImageWalls& walls) const {
    std::vector<std::size_t> seen;
    const int column = from.x / step_;
    const int row = from.y / step_;
    for (int y = std::max(0, row - reach); y <= std::min(rows_ - 1, row + reach); ++y) {
      for (int x = std::max(0, column - reach); x <= std::min(columns_ - 1, column + reach); ++x) {
        const std::size_t place = number_of_[index_of(x, y)];
        const int apart = (x - column) * (x - column) + (y - row) * (y - row);
        if (place != kNone && apart <= reach * reach && walls.is_in_sight(from, pixels_[place])) {
          seen.push_back(place);
        }
      }
    }
    return seen;
  }

  int step_;
  int columns_;
  int rows_;
  std::vector<std::size_t> number_of_;  ///< by place in the lattice
  std::vector<Cell> pixels_;
  std::vector<std::vector<std::size_t>> seen_;
};

}  // namespace

std::vector<Cell> viewpoints(const ImageWalls& walls, double resolution) {
  const Places places(walls, resolution);
  std::vector<bool> is_covered(places.all().size(), false);
  const auto gain_of = [&](std::size_t place) {
    const std::vector<std::size_t>& seen = places.seen(place);
    return std::count_if(seen.begin(), seen.end(),
                         [&](std::size_t other) { return !is_covered[other]; });
  };
  // What a place adds only shrinks: it is counted again when it is first.
  std::priority_queue<std::pair<std::ptrdiff_t, std::size_t>> queue;
  for (std::size_t place = 0; place < places.all().size(); ++place) {
    queue.push({gain_of(place), place});
  }
  std::vector<Cell> chosen;
  while (!queue.empty()) {
    const std::size_t place = queue.top().second;
    const std::ptrdiff_t thought = queue.top().first;
    queue.pop();
    const std::ptrdiff_t gain = gain_of(place);
    if (gain == thought && gain > 0) {
      chosen.push_back(places.all()[place]);
      for (const std::size_t other : places.seen(place)) {
        is_covered[other] = true;
      }
    } else if (gain > 0) {
      queue.push({gain, place});
    }
  }
  return chosen;
}

}  // namespace matchbox_slam
