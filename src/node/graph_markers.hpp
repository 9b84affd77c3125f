#pragma once

#include <ros/time.h>
#include <visualization_msgs/MarkerArray.h>

#include <string>

#include "matchbox_slam/graph/pose_graph.hpp"

namespace matchbox_slam {

/// The edges of a graph as lines between its poses, for rviz, in three namespaces: `motion`, thin;
/// `loops`, from green to red as their chi square comes near what makes a loop an outlier;
/// and `refused`, the outliers, thin and purple. One that has no edge is deleted.
[[nodiscard]] visualization_msgs::MarkerArray to_markers(const PoseGraph& graph,
                                                         const std::string& map_frame,
                                                         const ros::Time& stamp);

}  // namespace matchbox_slam
