#include "node/slam_node.hpp"

#include <filesystem>
#include <utility>

#include "matchbox_slam/MatchInfo.h"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/saved_map.hpp"
#include "ros/message_conversion.hpp"
#include "ros/queue_settings.hpp"
#include "ros/ros_parameters.hpp"
#include "run/frames.hpp"

namespace matchbox_slam {

namespace {

constexpr std::size_t kRecentScans = 200;

LiveConfiguration read_configuration(const ros::NodeHandle& private_node,
                                     const MatcherLoader& loader) {
  LiveConfiguration configuration(read_ros_parameters(private_node), loader);
  check_frames(configuration.setup().run);
  const std::string& trajectory_file = configuration.setup().node.trajectory_file;
  if (!trajectory_file.empty()) {
    const std::filesystem::path folder = std::filesystem::absolute(trajectory_file).parent_path();
    require_writable_folder(folder.string());
  }
  return configuration;
}

ScanQueueSettings node_queue_settings(const RunOptions& options) {
  return queue_settings(options, fixed_scan_time_offset(options).value_or(0.0));
}

/// A whole trajectory is only kept where it is asked for: it grows as long as the node runs.
RunRecords records_for(const SlamNodeOptions& options) {
  return options.trajectory_file.empty() ? RunRecords::kRecent : RunRecords::kAll;
}

geometry_msgs::Pose2D to_pose_2d(const Pose2& pose) {
  geometry_msgs::Pose2D message;
  message.x = pose.x;
  message.y = pose.y;
  message.theta = pose.theta;
  return message;
}

}  // namespace

SlamNode::SlamNode(const ros::NodeHandle& node, const ros::NodeHandle& private_node)
    : node_(node),
      private_node_(private_node),
      configuration_(read_configuration(private_node_, loader_)),
      options_(configuration_.setup().run),
      trajectory_file_(configuration_.setup().node.trajectory_file),
      queue_(node_queue_settings(options_)),
      clock_watch_(options_.map_frame),
      holds_scans_(!fixed_scan_time_offset(options_)),
      run_(configuration_.setup(), records_for(configuration_.setup().node)),
      matcher_name_(configuration_.setup().matcher_name),
      publish_tf_(configuration_.setup().node.publish_tf),
      transform_tolerance_(configuration_.setup().node.transform_tolerance),
      diagnostic_updater_(node_, private_node_, private_node_.getNamespace()),
      pose_publisher_(node_.advertise<geometry_msgs::PoseWithCovarianceStamped>("pose", 10)),
      match_info_publisher_(node_.advertise<MatchInfo>("match_info", 10)) {
  const SlamNodeOptions& node_options = configuration_.setup().node;
  if (!node_options.initial_map.empty()) {
    initial_map_ = read_initial_map(node_options.initial_map);
    start_from(initial_map_);
  }
  map_publisher_ = std::make_unique<MapPublisher>(
      node_, options_.map_frame, node_options.map_update_interval,
      [this] { return map_revision(); }, [this] { return map_snapshot(); });
  start_services();
  transform_timer_ = node_.createTimer(ros::Duration(node_options.transform_publish_period),
                                       [this](const ros::TimerEvent&) { publish_transform(); });
  subscribe();
  service_spinner_->start();  // from here on the configuration may change
  mapping_thread_ = std::thread([this] { run_mapping(); });
}

SlamNode::~SlamNode() {
  initial_pose_subscriber_.shutdown();
  for (ros::Subscriber& subscriber : scan_subscribers_) {
    subscriber.shutdown();
  }
  transform_subscriber_.shutdown();
  static_transform_subscriber_.shutdown();
  service_spinner_->stop();
  diagnostic_timer_.stop();
  silence_timer_.stop();
  transform_timer_.stop();
  map_publisher_.reset();
  {
    const std::lock_guard<std::mutex> lock(queue_mutex_);
    stop_ = true;
  }
  queue_changed_.notify_all();
  mapping_thread_.join();
  try {
    save_trajectory();
  } catch (const std::exception& error) {
    ROS_ERROR_STREAM(error.what());
  }
}

// --- mapping ---

void SlamNode::run_mapping() {
  while (true) {
    std::optional<ScanQueue::Item> item;
    {
      std::unique_lock<std::mutex> lock(queue_mutex_);
      queue_changed_.wait(lock, [&] {
        item = queue_.next();
        return item || stop_;
      });
    }
    if (!item) {
      return;
    }
    try {
      handle(*item);
    } catch (const std::exception& error) {  // the next scan may be better
      ROS_ERROR_STREAM_THROTTLE(10.0, "mapping: " << error.what());
    }
  }
}

void SlamNode::handle(const ScanQueue::Item& item) {
  if (const auto* scan = std::get_if<ReadyScan>(&item)) {
    map_scan(*scan);
  } else {
    jump(std::get<TimeJump>(item));
  }
}

void SlamNode::map_scan(const ReadyScan& scan) {
  ScanOutcome outcome;
  double match_seconds = 0.0;
  {
    const std::lock_guard<std::mutex> lock(run_mutex_);
    outcome = run_.process(scan.input);
    match_seconds = run_.last_match_seconds();
    newest_scan_ = scan;
    newest_pose_ = outcome.map_from_base;
    remember_health(scan, outcome);
    const std::lock_guard<std::mutex> transform_lock(transform_mutex_);
    map_transform_ = map_transform(scan, outcome);
  }
  if (outcome.left_out) {
    ROS_WARN_STREAM_THROTTLE(10.0, kLeftOut);
  }
  publish_pose(scan, outcome);
  publish_match_info(scan, outcome, match_seconds);
}

void SlamNode::remember_health(const ReadyScan& scan, const ScanOutcome& outcome) {
  recent_.push_back({outcome.stamp, seconds_between(scan.stamp, ros::Time::now()),
                     run_.last_match_seconds(), outcome.match.score, outcome.match.status,
                     outcome.match.unconstrained_directions.size()});
  if (recent_.size() > kRecentScans) {
    recent_.pop_front();
  }
}

void SlamNode::jump(const TimeJump& jump) {
  if (jump.stopped) {
    ROS_ERROR_STREAM("time has jumped back by " << jump.seconds
                                                << " s; no more scans are used, as time_jump is "
                                                   "'stop'");
  } else {
    ROS_WARN_STREAM("time has jumped back by "
                    << jump.seconds << " s; starting a new map, as time_jump is 'reset'");
    start_from(initial_map_);
  }
}

/// A map and where the robot is in it, as well as one puts a robot on a mark: where it was when the
/// map was saved, or at the configured start in one that does not say.
MapStart SlamNode::read_initial_map(const std::string& path) const {
  constexpr double kPosition = 0.3;  // [m]
  constexpr double kHeading = 0.2;   // [rad]
  MapStart start = read_map_start(path, configuration_.setup().engine);
  if (start.key_scans.empty()) {
    start.map_from_base = {options_.start_x, options_.start_y, wrap_angle(options_.start_theta)};
  }
  start.covariance +=
      Eigen::Vector3d(kPosition * kPosition, kPosition * kPosition, kHeading * kHeading)
          .asDiagonal();
  return start;
}

/// Starts anew, with the map that it is given, or with none.
void SlamNode::start_from(std::optional<MapStart> map) {
  const std::lock_guard<std::mutex> lock(run_mutex_);
  if (map) {
    run_.start_from(std::move(*map));
  } else {
    run_.reset();
  }
  newest_scan_.reset();
  recent_.clear();
  ++resets_;
  const std::lock_guard<std::mutex> transform_lock(transform_mutex_);
  map_transform_.reset();
}

// --- messages out ---

void SlamNode::publish_pose(const ReadyScan& scan, const ScanOutcome& outcome) {
  geometry_msgs::PoseWithCovarianceStamped message;
  message.header.frame_id = options_.map_frame;
  message.header.stamp = scan.stamp;
  message.pose = to_pose_message(outcome.map_from_base, outcome.covariance);
  pose_publisher_.publish(message);
}

void SlamNode::publish_match_info(const ReadyScan& scan, const ScanOutcome& outcome,
                                  double match_seconds) {
  if (match_info_publisher_.getNumSubscribers() == 0) {
    return;
  }
  MatchInfo message;
  message.header.frame_id = options_.map_frame;
  message.header.stamp = scan.stamp;
  message.scan_frame = scan.frame;
  message.status = to_string(outcome.match.status);
  message.score = outcome.match.score;
  message.rival_share = outcome.match.rival_share;
  message.predicted = to_pose_2d(outcome.predicted_map_from_base);
  message.pose = to_pose_2d(outcome.map_from_base);
  for (const Eigen::Vector2d& direction : outcome.match.unconstrained_directions) {
    geometry_msgs::Vector3 vector;
    vector.x = direction.x();
    vector.y = direction.y();
    message.unconstrained_directions.push_back(vector);
  }
  message.candidates = outcome.match.candidates;
  message.proven =
      static_cast<std::uint8_t>(outcome.match.proof && outcome.match.proof->gap() == 0.0);
  message.gap = outcome.match.proof ? outcome.match.proof->gap() : 0.0;
  message.match_time = match_seconds;
  message.inserted = static_cast<std::uint8_t>(outcome.inserted);
  {
    const std::lock_guard<std::mutex> lock(run_mutex_);
    message.matcher = matcher_name_;
  }
  match_info_publisher_.publish(message);
}

geometry_msgs::TransformStamped SlamNode::map_transform(const ReadyScan& scan,
                                                        const ScanOutcome& outcome) const {
  geometry_msgs::TransformStamped transform;
  transform.header.frame_id = options_.map_frame;
  transform.header.stamp = scan.stamp;
  transform.child_frame_id = outcome.odom_from_base ? options_.odom_frame : options_.base_frame;
  transform.transform = to_transform_message(
      outcome.odom_from_base ? outcome.map_from_base * outcome.odom_from_base->inverse()
                             : outcome.map_from_base);
  return transform;
}

void SlamNode::publish_transform() {
  // Simulated time goes in steps: within one, tf would complain of repeated data.
  const ros::Time now = ros::Time::now();
  if (!publish_tf_ || now.isZero() || now == last_transform_time_) {
    return;
  }
  last_transform_time_ = now;
  std::optional<geometry_msgs::TransformStamped> transform;
  {
    const std::lock_guard<std::mutex> lock(transform_mutex_);
    transform = map_transform_;
  }
  if (transform) {
    transform->header.stamp = now + ros::Duration(transform_tolerance_);
    broadcaster_.sendTransform(*transform);
  }
}

MapRevision SlamNode::map_revision() {
  const std::lock_guard<std::mutex> lock(run_mutex_);
  return {resets_, run_.inserted(), run_.scans()};
}

MapSnapshot SlamNode::map_snapshot() {
  const std::lock_guard<std::mutex> lock(run_mutex_);
  return {{resets_, run_.inserted(), run_.scans()},
          newest_scan_ ? newest_scan_->stamp : ros::Time(),
          run_.map().occupancy,
          run_.path().poses(),
          run_.odometry_path().poses()};
}

}  // namespace matchbox_slam
