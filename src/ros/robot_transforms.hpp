#pragma once

#include <nav_msgs/Odometry.h>
#include <ros/time.h>
#include <sensor_msgs/Imu.h>
#include <tf2_msgs/TFMessage.h>

#include <Eigen/Geometry>
#include <cstddef>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/sensor/scan_input.hpp"
#include "ros/imu_heading.hpp"
#include "ros/transform_store.hpp"

namespace matchbox_slam {

/// A robot's frames, and what tells how they move. Without leading slash.
struct RobotFrames {
  std::string base_frame;
  std::optional<std::string> odom_frame;  ///< none: scans carry no odometry
  bool odometry_by_topic = false;         ///< by `add_odometry`, and not by tf
  std::string map_frame;
  bool use_imu = false;         ///< its roll and pitch count where the odometry has none
  bool heading_by_imu = false;  ///< its yaw counts, too: there is no odometry
  /// Of the lasers on the base, where tf is not to tell; by laser, none for those behind.
  std::vector<Eigen::Isometry3d> laser_poses;
  bool is_live = true;  ///< what to type is said for the node; else for map_bag
};

/// When the first beam of a scan was measured, and the last.
struct BeamStamps {
  ros::Time first;
  ros::Time last;
};

/// Where a laser was while it took a scan, and what the robot did meanwhile: as of ScanInput.
struct PlacedLaser {
  Eigen::Isometry3d base_from_laser = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d laser_motion = Eigen::Isometry3d::Identity();
  std::optional<ScanOdometry> odometry;
  bool is_odometry_in_tf = true;  ///< somebody publishes it there
};

/// Tells where a robot's lasers were, by tf, by messages of odometry and by an IMU. Roll and pitch
/// of the base in the odometry frame, or by an IMU where tf shows none, count as the laser's: the
/// base comes out upright. When the base frame is the scan's own, no transform to it is needed.
class RobotTransforms {
 public:
  /// What a transform is needed for.
  enum class Need { kLaser, kOdometry, kImu };
  /// A transform that a scan needs.
  struct Needed {
    const std::string& target;
    const std::string& source;
    ros::Time stamp;
    Need need = Need::kLaser;
  };

  explicit RobotTransforms(RobotFrames frames);

  void add(const tf2_msgs::TFMessage& message, bool is_static);

  /// The orientation of an IMU is kept as a transform, and so has tf to say how it is mounted.
  /// Returns why it tells none, for people; empty: it does.
  [[nodiscard]] std::string add_imu(const sensor_msgs::Imu& message);

  /// A pose of odometry is kept likewise, whatever tf says of its frames. Returns why it tells
  /// none, for people; empty: it does.
  [[nodiscard]] std::string add_odometry(const nav_msgs::Odometry& message);
  /// Messages that told none.
  [[nodiscard]] std::size_t invalid_odometry() const { return invalid_odometry_; }

  /// Time jumped back: nothing of before has to do with what follows.
  void clear();

  /// The first transform that a scan needs and that is not there; none: all are.
  /// @param frame  of the scan; it has to outlive the answer.
  [[nodiscard]] std::optional<Needed> missing(int laser, const std::string& frame,
                                              const BeamStamps& beams) const;

  /// For people, with what to type where there is no way in tf at all.
  [[nodiscard]] std::string why_missing(const Needed& missing) const;

  /// With nothing missing.
  [[nodiscard]] PlacedLaser place(int laser, const std::string& frame,
                                  const BeamStamps& beams) const;

  /// What tf says of a laser that is said to be elsewhere, for people; empty: the same, or nothing
  /// yet. Once a laser.
  [[nodiscard]] std::string take_overruled(int laser, const std::string& frame,
                                           const ros::Time& stamp);

  /// Where odometry has the base; none: it is not known there.
  [[nodiscard]] std::optional<Pose2> odom_from_base(const ros::Time& stamp) const;

  /// Whether the odometry frame hangs below the base in tf.
  [[nodiscard]] bool are_frames_swapped() const;

  [[nodiscard]] const TransformStore& store() const { return store_; }

 private:
  [[nodiscard]] std::string add_gyro(const sensor_msgs::Imu& message);
  void add_link(const geometry_msgs::TransformStamped& link);
  void need_odometry(const ros::Time& stamp, std::vector<Needed>& needed) const;
  [[nodiscard]] bool is_missing(const Needed& needed) const;
  [[nodiscard]] std::string advice_for(const Needed& missing) const;
  [[nodiscard]] bool is_by_tf(int laser, const std::string& frame) const;
  [[nodiscard]] bool is_tilted(int laser, const std::string& frame, const ros::Time& stamp) const;
  [[nodiscard]] Eigen::Isometry3d base_from_laser(int laser, const std::string& frame,
                                                  const ros::Time& stamp) const;
  [[nodiscard]] Eigen::Isometry3d known_odom_from_base(const ros::Time& stamp) const;
  [[nodiscard]] Eigen::Isometry3d attitude(const Eigen::Isometry3d& odom_from_base,
                                           const ros::Time& stamp) const;
  [[nodiscard]] Pose2 heading_by_imu(const ros::Time& stamp) const;

  RobotFrames frames_;
  TransformStore store_;
  GyroHeading gyro_;
  std::set<int> compared_;      ///< lasers whose places as said were compared with those of tf
  std::string odometry_child_;  ///< whose pose odometry messages tell; empty: none has come
  std::size_t invalid_odometry_ = 0;
};

}  // namespace matchbox_slam
