#pragma once

#include <Eigen/Core>
#include <vector>

#include "geometry/trajectory.hpp"
#include "io/picture.hpp"
#include "matchbox_slam/graph/pose_graph.hpp"
#include "matchbox_slam/map/occupancy_grid.hpp"

namespace matchbox_slam {

/// The map for people: what is free is white, walls are dark, the unknown is grey; over it the
/// odometry, dashed, the corrected trajectory and the loops that were closed, with a scale bar and
/// a legend below. x goes to the right and y up, as rviz shows it.
///
/// A cell of a small map is several pixels wide, always a whole number of them; a pixel of a huge
/// map several cells, so that no picture is much wider or higher than 4000 pixels. The picture
/// shows the observed part of the map and the whole trajectory; odometry that runs away from both
/// is cut off.
/// @param trajectory  of the base in the map; may be empty.
/// @param odometry    of the base in any frame; it is drawn so that its first pose coincides with
/// the
///                    trajectory's first. May be empty.
/// @param graph       of the map's key scans; its loops that are inliers are drawn as lines from
///                    one key scan to the other, which has a dot.
[[nodiscard]] Picture draw_map(const OccupancyGrid& map, const Trajectory& trajectory,
                               const Trajectory& odometry, const PoseGraph& graph = {});

/// The same with several drives, each in a colour of its own, by their numbers from 1 on.
/// @param drives  in the map; those that are empty are left out.
[[nodiscard]] Picture draw_drives(const OccupancyGrid& map, const std::vector<Trajectory>& drives,
                                  const PoseGraph& graph);

/// Where the map's frame lies in a picture.
struct PictureFrame {
  double pixels_per_metre = 1.0;
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();  ///< (0, 0) of the map [pixels], y down
};

/// That of the picture that draw_map draws of the same.
[[nodiscard]] PictureFrame frame_of_picture(const OccupancyGrid& map, const Trajectory& trajectory);

}  // namespace matchbox_slam
