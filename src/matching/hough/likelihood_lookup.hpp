#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "matchbox_slam/map/likelihood_field.hpp"
#include "matchbox_slam/matching/hough/hough_transform.hpp"

namespace matchbox_slam {

/// Looks up how likely points are in a field: turned once, then moved to many places.
class LikelihoodLookup {
 public:
  /// @param field  outlives this object, and does not change meanwhile.
  explicit LikelihoodLookup(const LikelihoodField& field);

  /// Takes other points, or another turn.
  /// @param theta  of the points in the field [rad].
  void turn(const HoughPoints& points, double theta);

  /// The mean likelihood of the points, by the length of wall that they stand for, 0...1.
  /// @param translation  of the turned points [m].
  [[nodiscard]] double mean_at(const Eigen::Vector2d& translation);

 private:
  GridGeometry geometry_;
  /// Of all tiles within the bounds, and of a margin of one around them, row by row.
  std::vector<const std::uint8_t*> tiles_;
  Cell first_tile_;
  int columns_;
  int rows_;
  // of the points
  std::vector<double> cosine_x_, cosine_y_, sine_x_, sine_y_;  ///< products of the turn
  std::vector<double> weight_;
  double total_weight_ = 0.0;
  std::vector<std::int32_t> tile_;  ///< number of each point's tile
  std::vector<std::int32_t> cell_;  ///< within it
};

}  // namespace matchbox_slam
