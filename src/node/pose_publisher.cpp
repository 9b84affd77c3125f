#include "node/pose_publisher.hpp"

#include <geometry_msgs/Pose2D.h>
#include <geometry_msgs/PoseArray.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>

#include <algorithm>

#include "matchbox_slam/LikelyPoses.h"
#include "matchbox_slam/MatchInfo.h"
#include "ros/message_conversion.hpp"

namespace matchbox_slam {
namespace {

geometry_msgs::Pose2D to_pose_2d(const Pose2& pose) {
  geometry_msgs::Pose2D message;
  message.x = pose.x;
  message.y = pose.y;
  message.theta = pose.theta;
  return message;
}

}  // namespace

PosePublisher::PosePublisher(ros::NodeHandle& node, const SlamSetup& setup)
    : options_(setup.run),
      transform_period_(setup.node.transform_publish_period),
      pose_(node.advertise<geometry_msgs::PoseWithCovarianceStamped>("pose", 10)),
      match_info_(node.advertise<MatchInfo>("match_info", 10)),
      particles_(node.advertise<geometry_msgs::PoseArray>("particlecloud", 10)),
      likely_poses_(node.advertise<LikelyPoses>("likely_poses", 10)) {
  set_options(setup.node);
  timer_ = node.createTimer(ros::Duration(setup.node.transform_publish_period),
                            [this](const ros::TimerEvent&) { repeat_transform(); });
}

void PosePublisher::set_options(const SlamNodeOptions& options) {
  publish_tf_ = options.publish_tf;
  transform_tolerance_ = options.transform_tolerance;
  const std::lock_guard<std::mutex> lock(mutex_);
  tf_while_lost_ = options.tf_while_lost;
}

void PosePublisher::publish(const ReadyScan& scan, const ScanOutcome& outcome, double match_seconds,
                            const std::string& matcher) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    choose_transform(scan, outcome);
  }
  publish_pose(scan, outcome);
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    publish_transform(ros::Time::now());
  }
  publish_match_info(scan, outcome, match_seconds, matcher);
}

void PosePublisher::forget() {
  const std::lock_guard<std::mutex> lock(mutex_);
  map_transform_.reset();
  sure_transform_.reset();
}

/// Navigation had better wait, or go on by odometry, than follow a guess.
void PosePublisher::choose_transform(const ReadyScan& scan, const ScanOutcome& outcome) {
  if (outcome.state != TrackingState::kLost || tf_while_lost_ == "best") {
    map_transform_ = map_transform(scan, outcome);
  } else if (tf_while_lost_ == "hold") {
    map_transform_ = sure_transform_;
  } else {
    map_transform_.reset();
  }
  if (outcome.state == TrackingState::kTracking || outcome.state == TrackingState::kRecovered) {
    sure_transform_ = map_transform_;
  }
}

void PosePublisher::publish_likely(const ReadyScan& scan, const std::vector<WeightedPose>& likely) {
  LikelyPoses message;
  message.header.frame_id = options_.map_frame;
  message.header.stamp = scan.stamp;
  message.elsewhere = 1.0;
  for (const WeightedPose& pose : likely) {
    message.poses.push_back(to_pose_message(pose.map_from_base));
    message.weights.push_back(pose.weight);
    message.elsewhere -= pose.weight;
  }
  message.elsewhere = std::max(message.elsewhere, 0.0);
  geometry_msgs::PoseArray particles;
  particles.header = message.header;
  particles.poses = message.poses;
  particles_.publish(particles);
  likely_poses_.publish(message);
}

void PosePublisher::publish_pose(const ReadyScan& scan, const ScanOutcome& outcome) {
  geometry_msgs::PoseWithCovarianceStamped message;
  message.header.frame_id = options_.map_frame;
  message.header.stamp = scan.stamp;
  message.pose = to_pose_message(outcome.map_from_base, outcome.covariance);
  pose_.publish(message);
}

void PosePublisher::publish_match_info(const ReadyScan& scan, const ScanOutcome& outcome,
                                       double match_seconds, const std::string& matcher) {
  if (match_info_.getNumSubscribers() == 0) {
    return;
  }
  MatchInfo message;
  message.header.frame_id = options_.map_frame;
  message.header.stamp = scan.stamp;
  message.scan_frame = scan.frame;
  message.status = status_text(outcome);
  message.score = outcome.match.score;
  message.rival_share = outcome.match.rival_share;
  message.evidence = outcome.evidence.mean;
  message.state = to_string(outcome.state);
  message.certainty = to_string(outcome.certainty);
  message.predicted = to_pose_2d(outcome.predicted_map_from_base);
  message.pose = to_pose_2d(outcome.map_from_base);
  for (const Eigen::Vector2d& direction : outcome.match.unconstrained_directions) {
    geometry_msgs::Vector3 vector;
    vector.x = direction.x();
    vector.y = direction.y();
    message.unconstrained_directions.push_back(vector);
  }
  message.candidates = outcome.match.candidates;
  if (const std::optional<OptimalityProof>& proof = outcome.match.proof) {
    message.proven = static_cast<std::uint8_t>(proof->is_proven());
    message.gap = proof->gap();
    message.window_clipped = static_cast<std::uint8_t>(proof->clipped);
    message.on_edge = static_cast<std::uint8_t>(proof->on_edge);
  }
  const Eigen::Vector3d& refined_by = outcome.match.refined_by;
  message.refined_by = to_pose_2d({refined_by.x(), refined_by.y(), refined_by.z()});
  message.match_time = match_seconds;
  message.inserted = static_cast<std::uint8_t>(outcome.inserted);
  message.closed_loop = static_cast<std::uint8_t>(outcome.corrected.has_value());
  message.matcher = matcher;
  match_info_.publish(message);
}

geometry_msgs::TransformStamped PosePublisher::map_transform(const ReadyScan& scan,
                                                             const ScanOutcome& outcome) const {
  geometry_msgs::TransformStamped transform;
  transform.header.frame_id = options_.map_frame;
  transform.header.stamp = scan.stamp;
  // Below an odometry frame that tf does not have there would be nothing.
  const bool is_to_odometry = outcome.odom_from_base && scan.is_odometry_in_tf;
  transform.child_frame_id = is_to_odometry ? options_.odom_frame : options_.base_frame;
  transform.transform = to_transform_message(is_to_odometry ? outcome.map_from_base *
                                                                  outcome.odom_from_base->inverse()
                                                            : outcome.map_from_base);
  return transform;
}

/// Not so soon after a scan has sent it: at 40 Hz none is repeated.
void PosePublisher::repeat_transform() {
  const std::lock_guard<std::mutex> lock(mutex_);
  const ros::Time now = ros::Time::now();
  const double passed = (now - last_transform_time_).toSec();
  if (passed < 0.0 || passed >= 0.5 * transform_period_) {
    publish_transform(now);
  }
}

void PosePublisher::publish_transform(const ros::Time& now) {
  // Simulated time goes in steps: within one, tf would complain of repeated data.
  if (!publish_tf_ || !map_transform_ || now.isZero() || now == last_transform_time_) {
    return;
  }
  last_transform_time_ = now;
  geometry_msgs::TransformStamped transform = *map_transform_;
  transform.header.stamp = now + ros::Duration(transform_tolerance_);
  broadcaster_.sendTransform(transform);
}

}  // namespace matchbox_slam
