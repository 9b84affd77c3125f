#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <unordered_map>
#include <vector>

#include "matchbox_slam/map/likelihood_field.hpp"
#include "matchbox_slam/map/map_image.hpp"

namespace matchbox_slam {

/// What the pixels of a map say, to be looked at often: the state of each, and where in the
/// occupied ones the wall is. All in pixels, from the image's lower left corner; a pixel is named
/// by its cell, whose lower left one is (0, 0).
class ImageWalls {
 public:
  explicit ImageWalls(const MapImage& image);

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] bool contains(const Cell& pixel) const {
    return pixel.x >= 0 && pixel.x < width_ && pixel.y >= 0 && pixel.y < height_;
  }
  /// Unknown outside of the image.
  [[nodiscard]] CellState state(const Cell& pixel) const {
    return contains(pixel) ? states_[index_of(pixel)] : CellState::kUnknown;
  }

  /// The wall of each occupied pixel, by rows: on the line through its occupied neighbours where
  /// they lie on one, else in its centre and without a normal.
  [[nodiscard]] const std::vector<SurfaceHit>& walls() const { return walls_; }

  /// The same as beams hit them: with normals towards free ground. A wall that has it on both
  /// sides, or on none, is there once for each side.
  [[nodiscard]] std::vector<SurfaceHit> faces() const;

  /// How far it is along a ray to the first wall: infinite where there is none up to `reach`, NaN
  /// where the ray leaves what is known. A few unknown pixels before a wall are no end of it.
  /// @param direction  of length 1.
  [[nodiscard]] double range(const Eigen::Vector2d& origin, const Eigen::Vector2d& direction,
                             double reach) const;

  /// Whether no wall and nothing unknown is between the centres of two pixels.
  [[nodiscard]] bool is_in_sight(const Cell& from, const Cell& to) const;

 private:
  [[nodiscard]] std::size_t index_of(const Cell& pixel) const {
    return static_cast<std::size_t>(pixel.y) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(pixel.x);
  }
  [[nodiscard]] SurfaceHit wall_in(const Cell& pixel) const;
  /// Whether a wall's free ground begins in a direction, with no other wall before it.
  [[nodiscard]] bool is_free_towards(const SurfaceHit& wall,
                                     const Eigen::Vector2d& direction) const;
  /// Centres of the occupied pixels around one that hang together with it: the other face of a
  /// thin wall is another line.
  [[nodiscard]] std::vector<Eigen::Vector2d> touching_around(const Cell& pixel) const;

  int width_;
  int height_;
  std::vector<CellState> states_;  ///< by rows, the lowest first
  std::vector<SurfaceHit> walls_;
  std::unordered_map<std::size_t, std::size_t> wall_of_;  ///< number in walls_, by index of pixel
};

}  // namespace matchbox_slam
