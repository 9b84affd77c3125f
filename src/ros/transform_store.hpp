#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <ros/time.h>
#include <tf2/buffer_core.h>
#include <tf2_msgs/TFMessage.h>

#include <Eigen/Geometry>
#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "matchbox_slam/geometry/pose2.hpp"
#include "run/frames.hpp"

namespace matchbox_slam {

/// The pose in the plane below a pose in space: its position without z, the heading of its x axis.
[[nodiscard]] Pose2 project_to_plane(const Eigen::Isometry3d& pose);

/// The first link of a message that touches the map frame, as "odom -> map"; empty: none does.
/// @param map_frame  without leading slash; empty: none.
[[nodiscard]] std::string find_map_link(const tf2_msgs::TFMessage& message,
                                        const std::string& map_frame);

/// The transforms of a robot, as they come in on /tf and /tf_static: in any order, repeated,
/// stamped ahead of their time, with leading slashes, and with links that never change sent as if
/// they did. Whatever touches the map frame is left out, since that link is ours to say.
class TransformStore {
 public:
  /// @param map_frame  frame whose links are ignored, without leading slash; empty: none.
  explicit TransformStore(std::string map_frame);

  /// Takes over what is usable of a message.
  /// @param is_static  sent on /tf_static, good for all time.
  void add(const tf2_msgs::TFMessage& message, bool is_static);

  /// Forgets everything but what came from /tf_static; for when time has jumped back.
  void clear();

  /// Whether `lookup` finds a transform. Cost: the links between the frames, times the transforms
  /// that came after `stamp`.
  [[nodiscard]] bool covers(const std::string& target, const std::string& source,
                            const ros::Time& stamp) const;

  /// `target_from_source` at a stamp, interpolated. None where `covers` says no.
  [[nodiscard]] std::optional<Eigen::Isometry3d> lookup(const std::string& target,
                                                        const std::string& source,
                                                        const ros::Time& stamp) const;

  /// Whether there is a way between two frames at any one time.
  [[nodiscard]] bool connects(const std::string& target, const std::string& source) const {
    return covers(target, source, ros::Time(0));
  }

  /// Whether a frame hangs below another by its newest transforms.
  [[nodiscard]] bool is_below(std::string frame, const std::string& other) const;

  /// Why there is no transform, for people: both frames, and by how much tf misses the stamp.
  [[nodiscard]] std::string why_not(const std::string& target, const std::string& source,
                                    const ros::Time& stamp) const;

  /// The first link that was ignored for touching the map frame, as "odom -> map"; empty: none.
  [[nodiscard]] const std::string& ignored_map_link() const { return ignored_map_link_; }

  /// Transforms that were no rotation, no number or had no name.
  [[nodiscard]] std::size_t invalid_count() const { return invalid_count_; }

 private:
  /// What /tf said about one frame's place in its parent.
  struct Link {
    std::string parent;
    geometry_msgs::Transform first;
    ros::Time first_stamp;
    std::size_t count = 0;
    int outdated_in_a_row = 0;
    std::set<ros::Time> stamps;  ///< those that tf2 still holds
  };

  void add_transform(const geometry_msgs::TransformStamped& received, bool is_static);
  void add_moving(const geometry_msgs::TransformStamped& transform);
  /// The frames there are, for people who named one that is not.
  [[nodiscard]] std::string others() const;

  std::string map_frame_;
  tf2::BufferCore buffer_;
  std::map<std::string, Link> links_;  ///< by child frame
  std::string ignored_map_link_;
  std::size_t invalid_count_ = 0;
};

}  // namespace matchbox_slam
