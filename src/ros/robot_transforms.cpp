#include "ros/robot_transforms.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "matchbox_slam/sensor/point_scan.hpp"
#include "ros/message_conversion.hpp"
#include "ros/odometry_message.hpp"

namespace matchbox_slam {
namespace {

/// Below, a laser that moves on the robot is taken to have the same place for the whole scan [rad].
constexpr double kMinTilt = 1e-3;

/// The rotation of a frame but for its heading; exactly none where its z axis is upright.
Eigen::Isometry3d attitude_of(const Eigen::Isometry3d& odom_from_base) {
  Eigen::Isometry3d attitude = Eigen::Isometry3d::Identity();
  if (odom_from_base.linear()(2, 2) != 1.0) {
    const double heading = project_to_plane(odom_from_base).theta;
    attitude.linear() =
        Eigen::AngleAxisd(-heading, Eigen::Vector3d::UnitZ()) * odom_from_base.linear();
  }
  return attitude;
}

}  // namespace

RobotTransforms::RobotTransforms(RobotFrames frames)
    : frames_(std::move(frames)), store_(frames_.map_frame) {}

std::string RobotTransforms::add_imu(const sensor_msgs::Imu& message) {
  if (frames_.heading_by_imu && has_no_orientation(message)) {
    return add_gyro(message);
  }
  std::string defect = find_defect(message);
  if (defect.empty()) {
    add_link(heading_link(message));
  }
  return defect;
}

/// Which tells the heading alone: it comes upright, however the IMU is mounted.
std::string RobotTransforms::add_gyro(const sensor_msgs::Imu& message) {
  std::string defect = GyroHeading::find_defect(message);
  if (!defect.empty()) {
    return defect;
  }
  const std::string frame = without_leading_slash(message.header.frame_id);
  const std::optional<Eigen::Isometry3d> mount =
      frame == frames_.base_frame ? Eigen::Isometry3d::Identity()
                                  : store_.lookup(frames_.base_frame, frame, ros::Time(0));
  if (!mount) {
    return fmt::format("until tf says how it is mounted, which takes a way from '{}' to '{}'",
                       frame, frames_.base_frame);
  }
  if (const auto link = gyro_.add(message, mount->linear())) {
    add_link(*link);
  }
  return {};
}

std::string RobotTransforms::add_odometry(const nav_msgs::Odometry& message) {
  std::string defect = find_defect(message, frames_.odom_frame.value_or(""));
  const std::string named = without_leading_slash(message.child_frame_id);
  const std::string& child = named.empty() ? frames_.base_frame : named;
  if (defect.empty() && !odometry_child_.empty() && child != odometry_child_) {
    defect = fmt::format("its child_frame_id is '{}', and '{}' before", child, odometry_child_);
  }
  if (!defect.empty()) {
    ++invalid_odometry_;
    return defect;
  }
  odometry_child_ = child;
  add_link(odometry_link(message, *frames_.odom_frame));
  return {};
}

void RobotTransforms::add_link(const geometry_msgs::TransformStamped& link) {
  tf2_msgs::TFMessage message;
  message.transforms = {link};
  add(message, false);
}

void RobotTransforms::add(const tf2_msgs::TFMessage& message, bool is_static) {
  store_.add(message, is_static);
}

void RobotTransforms::clear() {
  store_.clear();
  gyro_.clear();
}

std::optional<RobotTransforms::Needed> RobotTransforms::missing(int laser, const std::string& frame,
                                                                const BeamStamps& beams) const {
  static const std::string kImu = kImuHeadingFrame;
  const std::string& base = frames_.base_frame;
  std::vector<Needed> needed;
  if (is_by_tf(laser, frame)) {
    needed.push_back({base, frame, beams.first});
  }
  if (frames_.odom_frame) {
    need_odometry(beams.first, needed);
    need_odometry(beams.last, needed);
  }
  if (frames_.use_imu) {
    needed.push_back({kImu, base, beams.first, Need::kImu});
    needed.push_back({kImu, base, beams.last, Need::kImu});
  }
  const auto missing = std::find_if(needed.begin(), needed.end(),
                                    [this](const Needed& one) { return is_missing(one); });
  if (missing != needed.end()) {
    return *missing;
  }
  // Where it is tilted, it may be tilting.
  const Needed last{base, frame, beams.last};
  if (is_tilted(laser, frame, beams.first) && is_missing(last)) {
    return last;
  }
  return std::nullopt;
}

void RobotTransforms::need_odometry(const ros::Time& stamp, std::vector<Needed>& needed) const {
  static const std::string kChild = kOdometryChildFrame;
  const std::string& base = frames_.base_frame;
  if (!frames_.odometry_by_topic) {
    needed.push_back({*frames_.odom_frame, base, stamp, Need::kOdometry});
    return;
  }
  needed.push_back({*frames_.odom_frame, kChild, stamp, Need::kOdometry});
  if (!odometry_child_.empty() && odometry_child_ != base) {
    needed.push_back({odometry_child_, base, stamp, Need::kOdometry});
  }
}

bool RobotTransforms::is_missing(const Needed& needed) const {
  return !store_.covers(needed.target, needed.source, needed.stamp);
}

std::string RobotTransforms::why_missing(const Needed& missing) const {
  const std::string why = store_.why_not(missing.target, missing.source, missing.stamp);
  // One that is late or early is no wrong name.
  return store_.connects(missing.target, missing.source) ? why : why + advice_for(missing);
}

/// What to type where there is no way in tf at all.
std::string RobotTransforms::advice_for(const Needed& missing) const {
  const bool is_live = frames_.is_live;
  if (missing.need == Need::kImu) {
    return "; leave out imu_topic to map without";
  }
  if (missing.need == Need::kLaser) {
    return is_live ? "; if base_frame is right, say where the laser is on it with "
                     "laser_pose:=X,Y,YAW"
                   : "; if --base-frame is right, say where the laser is on it with --laser-pose "
                     "X,Y,YAW";
  }
  if (frames_.odometry_by_topic) {
    return is_live
               ? "; set odom_topic to what publishes nav_msgs/Odometry, and base_frame to its "
                 "child_frame_id or a frame that tf connects with it"
               : "; give another --odom-topic, or as --base-frame its child_frame_id or a frame "
                 "that tf connects with it";
  }
  return is_live ? "; set odom_frame and base_frame to frames that there are, or odom_topic to a "
                   "topic of nav_msgs/Odometry, or use_odometry to false"
                 : "; give frames that there are as --odom-frame and --base-frame, or a topic of "
                   "nav_msgs/Odometry as --odom-topic, or --no-odom";
}

/// Whether tf has to tell where a laser is.
bool RobotTransforms::is_by_tf(int laser, const std::string& frame) const {
  return static_cast<std::size_t>(laser) >= frames_.laser_poses.size() &&
         frame != frames_.base_frame;
}

/// Whether a laser's plane is not that of the base. Its transform is there.
bool RobotTransforms::is_tilted(int laser, const std::string& frame, const ros::Time& stamp) const {
  return is_by_tf(laser, frame) && tilt_of(base_from_laser(laser, frame, stamp)) > kMinTilt;
}

/// Its transform is there.
Eigen::Isometry3d RobotTransforms::base_from_laser(int laser, const std::string& frame,
                                                   const ros::Time& stamp) const {
  if (is_by_tf(laser, frame)) {
    return *store_.lookup(frames_.base_frame, frame, stamp);
  }
  const auto number = static_cast<std::size_t>(laser);
  return number < frames_.laser_poses.size() ? frames_.laser_poses[number]
                                             : Eigen::Isometry3d::Identity();
}

std::string RobotTransforms::take_overruled(int laser, const std::string& frame,
                                            const ros::Time& stamp) {
  constexpr double kRounding = 0.005;  // [m] or [rad] that people leave out
  const std::string& base = frames_.base_frame;
  if (frame == base || is_by_tf(laser, frame) || compared_.count(laser) != 0) {
    return {};
  }
  const auto place = store_.lookup(base, frame, stamp);
  if (!place) {
    return {};
  }
  compared_.insert(laser);
  const Pose2 said = project_to_plane(base_from_laser(laser, frame, stamp));
  const Pose2 by_tf = project_to_plane(*place);
  const Pose2 off = by_tf.inverse() * said;
  if (off.translation().norm() <= kRounding && std::abs(off.theta) <= kRounding) {
    return {};
  }
  const auto text = [](const Pose2& pose) {
    return fmt::format("{:.3f},{:.3f},{:.3f}", pose.x, pose.y, pose.theta);
  };
  return fmt::format("tf has {} at {} on {}; {} {} is used instead", frame, text(by_tf), base,
                     frames_.is_live ? "laser_pose" : "--laser-pose", text(said));
}

std::optional<Pose2> RobotTransforms::odom_from_base(const ros::Time& stamp) const {
  std::vector<Needed> needed;
  need_odometry(stamp, needed);
  const bool is_known = std::none_of(needed.begin(), needed.end(),
                                     [this](const Needed& one) { return is_missing(one); });
  return is_known ? std::optional(project_to_plane(known_odom_from_base(stamp))) : std::nullopt;
}

/// By what tells the odometry, which is there.
Eigen::Isometry3d RobotTransforms::known_odom_from_base(const ros::Time& stamp) const {
  const std::string& odom = *frames_.odom_frame;
  const std::string& base = frames_.base_frame;
  if (!frames_.odometry_by_topic) {
    return *store_.lookup(odom, base, stamp);
  }
  const Eigen::Isometry3d odom_from_child = *store_.lookup(odom, kOdometryChildFrame, stamp);
  return odometry_child_ == base ? odom_from_child
                                 : odom_from_child * *store_.lookup(odometry_child_, base, stamp);
}

/// How the base leans by its odometry or, where that shows nothing, by the IMU.
Eigen::Isometry3d RobotTransforms::attitude(const Eigen::Isometry3d& odom_from_base,
                                            const ros::Time& stamp) const {
  const Eigen::Isometry3d by_odometry = attitude_of(odom_from_base);
  return frames_.use_imu && tilt_of(by_odometry) < kMinTilt
             ? attitude_of(*store_.lookup(kImuHeadingFrame, frames_.base_frame, stamp))
             : by_odometry;
}

/// Its orientation is there; a place it does not tell.
Pose2 RobotTransforms::heading_by_imu(const ros::Time& stamp) const {
  const Eigen::Isometry3d at = *store_.lookup(kImuHeadingFrame, frames_.base_frame, stamp);
  return {0.0, 0.0, project_to_plane(at).theta};
}

PlacedLaser RobotTransforms::place(int laser, const std::string& frame,
                                   const BeamStamps& beams) const {
  PlacedLaser placed;
  Eigen::Isometry3d at_first = base_from_laser(laser, frame, beams.first);
  Eigen::Isometry3d at_last =
      is_tilted(laser, frame, beams.first) ? base_from_laser(laser, frame, beams.last) : at_first;
  Eigen::Isometry3d first_base = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d last_base = Eigen::Isometry3d::Identity();
  if (frames_.odom_frame) {
    first_base = known_odom_from_base(beams.first);
    last_base = known_odom_from_base(beams.last);
    placed.odometry = ScanOdometry{project_to_plane(first_base), project_to_plane(last_base)};
    placed.is_odometry_in_tf =
        !frames_.odometry_by_topic || store_.is_below(frames_.base_frame, *frames_.odom_frame);
  } else if (frames_.heading_by_imu) {
    placed.odometry = ScanOdometry{heading_by_imu(beams.first), heading_by_imu(beams.last), true};
  }
  at_first = attitude(first_base, beams.first) * at_first;
  at_last = attitude(last_base, beams.last) * at_last;
  placed.base_from_laser = at_first;
  if (at_last.matrix() != at_first.matrix()) {
    placed.laser_motion = at_first.inverse() * at_last;
  }
  return placed;
}

bool RobotTransforms::are_frames_swapped() const {
  const bool by_imu = frames_.odom_frame == kImuHeadingFrame;  // which hangs below on purpose
  return frames_.odom_frame && !by_imu && !frames_.odometry_by_topic &&
         store_.is_below(*frames_.odom_frame, frames_.base_frame);
}

}  // namespace matchbox_slam
