#include "evaluation/map_quality.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <string>

#include "geometry/trajectory.hpp"

namespace matchbox_slam {
namespace {

constexpr unsigned char kNoWall = 0;
constexpr unsigned char kWall = 255;

/// Smaller patches of occupied cells are noise.
constexpr int kSmallestPatch = 5;    ///< [cells]
constexpr int kCornerDistance = 10;  ///< [cells]
/// Wider than all filters reach, so that the edge of the image is nowhere near a wall.
constexpr int kMargin = kCornerDistance + 6;

/// Share of an ideal corner's response. Of walls one to three cells thick, at any angle,
/// right-angled corners yield 0.91 and more; the steps of a slanting wall yield at most 0.53.
constexpr double kCornerThreshold = 0.6;
/// A response is counted in this many steps up to that of an ideal corner: sums in another order,
/// as in a turned map, must not make one of two equal corners the higher one.
constexpr double kResponseSteps = 1000.0;

constexpr int kSpaceConnectivity = 4;
constexpr int kWallConnectivity = 8;

/// Patches of nonzero pixels; number 0 is what lies between them.
struct Patches {
  cv::Mat1i number_at;
  cv::Mat1i statistics;
  cv::Mat1d centers;
  int count = 0;

  [[nodiscard]] int size(int number) const { return statistics(number, cv::CC_STAT_AREA); }
};

Patches find_patches(const cv::Mat1b& image, int connectivity) {
  Patches patches;
  patches.count = cv::connectedComponentsWithStats(image, patches.number_at, patches.statistics,
                                                   patches.centers, connectivity, CV_32S);
  return patches;
}

cv::Mat1b without_specks(const cv::Mat1b& walls) {
  const Patches patches = find_patches(walls, kWallConnectivity);
  cv::Mat1b clean = walls.clone();
  for (int y = 0; y < clean.rows; ++y) {
    for (int x = 0; x < clean.cols; ++x) {
      if (patches.size(patches.number_at(y, x)) < kSmallestPatch) {
        clean(y, x) = kNoWall;
      }
    }
  }
  return clean;
}

/// Closes gaps of up to two cells.
cv::Mat1b without_gaps(const cv::Mat1b& walls) {
  cv::Mat1b closed;
  cv::morphologyEx(walls, closed, cv::MORPH_CLOSE,
                   cv::getStructuringElement(cv::MORPH_RECT, {3, 3}));
  return closed;
}

/// Harris's response of every pixel, in units that only compare with each other. The window is of
/// 2 x 2 pixels, those above and to the left of the pixel and itself.
cv::Mat1f corner_response(const cv::Mat1b& walls) {
  cv::Mat1f image;
  walls.convertTo(image, CV_32F, 1.0 / kWall);
  cv::GaussianBlur(image, image, {5, 5}, 0.0);
  cv::Laplacian(image, image, CV_32F, 3);
  cv::Mat1f response;
  cv::cornerHarris(image, response, 2, 3, 0.04);
  return response;
}

/// What a right angle between two walls one cell thick yields at most.
double ideal_corner_response() {
  constexpr int kLength = 40;  ///< [cells], longer than all filters reach
  cv::Mat1b walls(2 * kLength, 2 * kLength, kNoWall);
  walls(cv::Rect(kLength, kLength, kLength, 1)) = kWall;
  walls(cv::Rect(kLength, kLength, 1, kLength)) = kWall;
  double highest = 0.0;
  // Without the ends of the walls.
  const cv::Rect corner(kLength - kMargin, kLength - kMargin, 2 * kMargin, 2 * kMargin);
  cv::minMaxLoc(corner_response(walls)(corner), nullptr, &highest);
  return highest;
}

/// The pixels that no other within the corner distance excels. Unlike in a search from the highest
/// response down, it does not matter which of several equal ones comes first.
cv::Mat1b distinct_pixels(const cv::Mat1f& response) {
  static const double kIdeal = ideal_corner_response();
  cv::Mat1w steps;  // saturates far above an ideal corner
  response.convertTo(steps, CV_16U, kResponseSteps / kIdeal);
  cv::Mat1w highest_around;
  constexpr int kWidth = 2 * kCornerDistance + 1;
  cv::dilate(steps, highest_around, cv::getStructuringElement(cv::MORPH_RECT, {kWidth, kWidth}));
  // Its constructor is explicit. NOLINTNEXTLINE(modernize-return-braced-init-list)
  return cv::Mat1b((steps == highest_around) & (steps > kCornerThreshold * kResponseSteps));
}

/// @param walls  with their margin.
std::vector<Eigen::Vector2d> find_corners(const cv::Mat1b& walls) {
  // Equal pixels within the corner distance are one corner; widened by it, they touch.
  cv::Mat1b corners;
  cv::dilate(distinct_pixels(corner_response(walls)), corners,
             cv::getStructuringElement(cv::MORPH_RECT, {kCornerDistance, kCornerDistance}));
  const Patches patches = find_patches(corners, kWallConnectivity);
  std::vector<Eigen::Vector2d> found;
  for (int number = 1; number < patches.count; ++number) {
    // An even width puts the middle half a pixel beyond, and the response's window half a pixel
    // before the pixel, whose own middle is half a pixel from where its number says.
    const double right = patches.centers(number, 0) - 0.5 - kMargin;
    const double down = patches.centers(number, 1) - 0.5 - kMargin;
    found.emplace_back(right, walls.rows - 2 * kMargin - down);
  }
  return found;
}

/// @param walls  with their margin.
std::vector<EnclosedArea> find_enclosed_areas(const cv::Mat1b& walls) {
  const Patches regions = find_patches(cv::Mat1b(walls == kNoWall), kSpaceConnectivity);
  const int outside = regions.number_at(0, 0);
  std::vector<EnclosedArea> by_number(static_cast<std::size_t>(regions.count));
  for (int y = 0; y < walls.rows; ++y) {
    for (int x = 0; x < walls.cols; ++x) {
      const int number = regions.number_at(y, x);
      if (number != 0 && number != outside) {
        by_number[static_cast<std::size_t>(number)].push_back(
            {x - kMargin, walls.rows - 1 - kMargin - y});
      }
    }
  }
  by_number.erase(std::remove_if(by_number.begin(), by_number.end(),
                                 [](const EnclosedArea& area) { return area.empty(); }),
                  by_number.end());
  return by_number;
}

/// Counts the cells, and returns the occupied ones as an image with a margin, top row first.
cv::Mat1b count_cells(const MapImage& map, MapQuality& quality) {
  cv::Mat1b walls(map.height + 2 * kMargin, map.width + 2 * kMargin, kNoWall);
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const CellState state = map.state({x, y});
      quality.free_cells += state == CellState::kFree ? 1U : 0U;
      if (state == CellState::kOccupied) {
        ++quality.occupied_cells;
        walls(kMargin + map.height - 1 - y, kMargin + x) = kWall;
      }
    }
  }
  return walls;
}

}  // namespace

MapQuality measure_map_quality(const MapImage& map) {
  MapQuality quality;
  const cv::Mat1b walls = without_gaps(without_specks(count_cells(map, quality)));
  if (quality.free_cells == 0) {
    throw EvaluationError(
        "none of the map's " + std::to_string(map.width) + " x " + std::to_string(map.height) +
        " cells is free (" + std::to_string(quality.occupied_cells) +
        " are occupied), but quality is measured against the free ones; do negate "
        "and free_thresh fit the image?");
  }
  quality.corners = find_corners(walls);
  quality.enclosed_areas = find_enclosed_areas(walls);
  return quality;
}

}  // namespace matchbox_slam
