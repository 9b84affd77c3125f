#pragma once

#include <Eigen/Core>
#include <vector>

#include "io/picture.hpp"
#include "matchbox_slam/map/grid_geometry.hpp"
#include "tools/movie_frame.hpp"

namespace matchbox_slam {

/// Draws frames as pictures of one size, at most kMostPixels wide and high, which all show the same
/// ground: what any of them shows. x goes to the right and y up, as in map.png, whose colours these
/// are; where else the robot may be is orange.
class MovieView {
 public:
  static constexpr int kMostPixels = 800;

  /// @param frames             of one movie, at least one.
  /// @param finest_resolution  of cells of level 0 [m].
  MovieView(const std::vector<MovieFrame>& frames, double finest_resolution);

  [[nodiscard]] int width() const { return width_; }    ///< [pixels], even
  [[nodiscard]] int height() const { return height_; }  ///< likewise, for encoders of films

  [[nodiscard]] Picture draw(const MovieFrame& frame) const;

  /// Colors that pictures have much of.
  [[nodiscard]] static std::vector<Color> main_colors();

 private:
  void fit(const std::vector<MovieFrame>& frames);
  void draw_cells(const MovieFrame& frame, Picture& picture) const;
  void draw_paths(const MovieFrame& frame, Picture& picture) const;
  void draw_robots(const MovieFrame& frame, Picture& picture) const;
  void draw_caption(const MovieFrame& frame, Picture& picture) const;
  void draw_robot(const Pose2& pose, double radius, const Color& color, Picture& picture) const;
  [[nodiscard]] Eigen::Vector2d to_picture(const Eigen::Vector2d& point) const;

  double finest_resolution_;
  int level_ = 0;  ///< of the cells that are drawn
  CellBox cells_;  ///< that are shown
  int pixels_per_cell_ = 1;
  int width_ = 0;
  int height_ = 0;
  int left_ = 0;  ///< of the map [pixels]
};

}  // namespace matchbox_slam
