#include "ros/transform_store.hpp"

#include <fmt/core.h>
#include <tf2/exceptions.h>
#include <tf2_eigen/tf2_eigen.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "matchbox_slam/common/options.hpp"
#include "ros/imu_heading.hpp"
#include "ros/message_conversion.hpp"
#include "ros/odometry_message.hpp"

namespace matchbox_slam {

namespace {

const ros::Duration kCache(60.0);

// A link whose first two transforms agree is taken to have stood so for this long before. Drivers
// stamp links that never change half a second ahead, which leaves the first scans uncovered.
const ros::Duration kHistoryLength(10.0);

// Transforms of a link, each too old for the newest, that tell a stamp that was wrong from one that
// is.
constexpr int kMinOutdatedInRow = 3;

/// False when the transform is none. Rotations that are nearly of unit length are made exactly so.
bool make_valid(geometry_msgs::TransformStamped& transform) {
  geometry_msgs::Quaternion& q = transform.transform.rotation;
  if (!is_rotation(q) || !is_usable(transform.transform.translation) ||
      !is_usable(transform.header.stamp)) {
    return false;
  }
  const double norm = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  if (std::abs(norm - 1.0) > 1e-9) {
    q.x /= norm;
    q.y /= norm;
    q.z /= norm;
    q.w /= norm;
  }
  return is_frame_id(transform.child_frame_id) && is_frame_id(transform.header.frame_id) &&
         transform.child_frame_id != transform.header.frame_id;
}

/// Whether a frame id, with or without leading slash, is the given one.
bool is_frame(const std::string& id, const std::string& frame) {
  const std::size_t slash = !id.empty() && id.front() == '/' ? 1 : 0;
  return id.compare(slash, std::string::npos, frame) == 0;
}

bool touches(const geometry_msgs::TransformStamped& transform, const std::string& frame) {
  return !frame.empty() &&
         (is_frame(transform.header.frame_id, frame) || is_frame(transform.child_frame_id, frame));
}

}  // namespace

std::string find_map_link(const tf2_msgs::TFMessage& message, const std::string& map_frame) {
  for (const geometry_msgs::TransformStamped& transform : message.transforms) {
    if (touches(transform, map_frame)) {
      return fmt::format("{} -> {}", without_leading_slash(transform.header.frame_id),
                         without_leading_slash(transform.child_frame_id));
    }
  }
  return {};
}

Pose2 project_to_plane(const Eigen::Isometry3d& pose) {
  const Eigen::Vector3d forward = pose.linear().col(0);
  return {pose.translation().x(), pose.translation().y(),
          wrap_angle(std::atan2(forward.y(), forward.x()))};
}

TransformStore::TransformStore(std::string map_frame)
    : map_frame_(std::move(map_frame)), buffer_(kCache) {}

void TransformStore::add(const tf2_msgs::TFMessage& message, bool is_static) {
  if (ignored_map_link_.empty()) {
    ignored_map_link_ = find_map_link(message, map_frame_);
  }
  for (const geometry_msgs::TransformStamped& transform : message.transforms) {
    if (!touches(transform, map_frame_)) {
      add_transform(transform, is_static);
    }
  }
}

void TransformStore::add_transform(const geometry_msgs::TransformStamped& received,
                                   bool is_static) {
  geometry_msgs::TransformStamped transform = received;
  transform.header.frame_id = without_leading_slash(received.header.frame_id);
  transform.child_frame_id = without_leading_slash(received.child_frame_id);
  if (!make_valid(transform)) {
    ++invalid_count_;
  } else if (is_static) {
    buffer_.setTransform(transform, "tf_static", true);
  } else {
    add_moving(transform);
  }
}

void TransformStore::add_moving(const geometry_msgs::TransformStamped& transform) {
  Link& link = links_[transform.child_frame_id];
  const ros::Time stamp = transform.header.stamp;
  if (link.count == 0 || link.parent != transform.header.frame_id) {
    link.parent = transform.header.frame_id;
    link.first = transform.transform;
    link.first_stamp = stamp;
    link.count = 0;
  }
  // tf2 refuses repeated and outdated transforms too, but not without a word for each of them.
  const bool outdated = !link.stamps.empty() && *link.stamps.rbegin() > stamp + kCache;
  if (outdated && ++link.outdated_in_a_row == kMinOutdatedInRow) {
    clear();  // the newest stamp was the wrong one: tf2 would refuse all that follow
    return add_moving(transform);
  }
  if (outdated || !link.stamps.insert(stamp).second) {
    return;
  }
  link.outdated_in_a_row = 0;
  ++link.count;
  buffer_.setTransform(transform, "tf");
  if (link.count == 2 && transform.transform == link.first &&
      link.first_stamp.toSec() > kHistoryLength.toSec()) {
    geometry_msgs::TransformStamped before = transform;
    before.header.stamp = link.first_stamp - kHistoryLength;
    if (link.stamps.insert(before.header.stamp).second) {
      buffer_.setTransform(before, "tf");
    }
  }
  while (*link.stamps.begin() + kCache < *link.stamps.rbegin()) {
    link.stamps.erase(link.stamps.begin());
  }
}

void TransformStore::clear() {
  buffer_.clear();
  links_.clear();
}

bool TransformStore::covers(const std::string& target, const std::string& source,
                            const ros::Time& stamp) const {
  return buffer_.canTransform(target, source, stamp);
}

std::optional<Eigen::Isometry3d> TransformStore::lookup(const std::string& target,
                                                        const std::string& source,
                                                        const ros::Time& stamp) const {
  try {
    return tf2::transformToEigen(buffer_.lookupTransform(target, source, stamp));
  } catch (const tf2::TransformException&) {
    return std::nullopt;
  }
}

bool TransformStore::is_below(std::string frame, const std::string& other) const {
  constexpr int kMostLinks = 100;  // tf may go in a circle
  for (int k = 0; k < kMostLinks && buffer_._getParent(frame, ros::Time(), frame); ++k) {
    if (frame == other) {
      return true;
    }
  }
  return false;
}

std::string TransformStore::others() const {
  std::vector<std::string> frames;
  buffer_._getFrameStrings(frames);
  const auto is_ours = [](const std::string& frame) {
    return frame == kImuHeadingFrame || frame == kOdometryChildFrame;
  };
  frames.erase(std::remove_if(frames.begin(), frames.end(), is_ours), frames.end());
  std::sort(frames.begin(), frames.end());
  return frames.empty() ? ", nor any other yet" : "; it has " + join(frames);
}

std::string TransformStore::why_not(const std::string& target, const std::string& source,
                                    const ros::Time& stamp) const {
  const bool by_imu = source == kImuHeadingFrame || target == kImuHeadingFrame;
  const bool by_odometry = source == kOdometryChildFrame;
  const std::string what =
      fmt::format("{} at {:.3f}: ",
                  by_imu        ? "no orientation by the IMU"
                  : by_odometry ? "no pose on the topic of odometry"
                                : fmt::format("no transform from '{}' to '{}'", source, target),
                  stamp.toSec());
  for (const std::string& frame : {source, target}) {
    if (!buffer_._frameExists(frame)) {
      return what + (by_imu && frame == kImuHeadingFrame
                         ? "no usable message of the IMU has come yet"
                     : by_odometry ? "no usable message of it has come yet"
                                   : fmt::format("tf has no frame '{}'{}", frame, others()));
    }
  }
  try {
    const ros::Time newest = buffer_.lookupTransform(target, source, ros::Time(0)).header.stamp;
    const double lag = seconds_between(newest, stamp);
    if (lag > 0.0) {
      return what + fmt::format("the newest is {:.3f} s older", lag);
    }
    return what + fmt::format("{} is there from later on only, up to {:.3f} s after that",
                              by_odometry ? "it" : "tf", -lag);
  } catch (const tf2::ConnectivityException&) {
    return what + (by_imu ? "tf does not say how it is mounted" : "tf does not connect them");
  } catch (const tf2::TransformException&) {
    return what + "the links between them share no time";
  }
}

}  // namespace matchbox_slam
