#include "matchbox_slam/ros/slam_node.hpp"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/ros/message_conversion.hpp"
#include "matchbox_slam/ros/ros_parameters.hpp"

namespace matchbox_slam {

namespace {

// Generous, since a message lost here is lost uncounted.
constexpr std::uint32_t kScanMessages = 1000;
constexpr std::uint32_t kTransformMessages = 10000;

constexpr double kWarningInterval = 10.0;  // s

SlamSetup read_setup(const ros::NodeHandle& private_node, const MatcherLoader& loader) {
  SlamSetup setup = make_slam_setup(read_ros_parameters(private_node), loader);
  check_frames(setup.run);
  if (!fixed_scan_time_offset(setup.run)) {
    throw ConfigurationError(
        "scan_time_offset: auto is not allowed in the node; allowed: a number of seconds (map_bag "
        "estimates it for a bag)");
  }
  if (!setup.node.trajectory_file.empty()) {
    const std::filesystem::path folder =
        std::filesystem::absolute(setup.node.trajectory_file).parent_path();
    require_writable_folder(folder.string());
  }
  return setup;
}

}  // namespace

SlamNode::SlamNode(const ros::NodeHandle& node, const ros::NodeHandle& private_node)
    : node_(node),
      private_node_(private_node),
      setup_(read_setup(private_node_, loader_)),
      queue_(queue_settings(setup_.run, *fixed_scan_time_offset(setup_.run))),
      run_(setup_),
      diagnostic_updater_(node_, private_node_, private_node_.getNamespace()),
      pose_publisher_(node_.advertise<geometry_msgs::PoseWithCovarianceStamped>("pose", 10)) {
  map_publisher_ = std::make_unique<MapPublisher>(
      node_, setup_.run.map_frame, setup_.node.map_update_interval,
      [this] { return map_revision(); }, [this] { return map_snapshot(); });
  start_services();
  if (setup_.node.publish_tf) {
    transform_timer_ =
        node_.createTimer(ros::Duration(setup_.node.transform_publish_period),
                          [this](const ros::TimerEvent& /*event*/) { publish_transform(); });
  }
  const ros::TransportHints hints = ros::TransportHints().tcpNoDelay();
  static_transform_subscriber_ = node_.subscribe<tf2_msgs::TFMessage>(
      "/tf_static", kTransformMessages,
      [this](const ros::MessageEvent<const tf2_msgs::TFMessage>& event) {
        on_transforms(event, true);
      },
      ros::VoidConstPtr(), hints);
  transform_subscriber_ = node_.subscribe<tf2_msgs::TFMessage>(
      "/tf", kTransformMessages,
      [this](const ros::MessageEvent<const tf2_msgs::TFMessage>& event) {
        on_transforms(event, false);
      },
      ros::VoidConstPtr(), hints);
  scan_subscriber_ = node_.subscribe<sensor_msgs::LaserScan>(
      "scan", kScanMessages,
      [this](const ros::MessageEvent<const sensor_msgs::LaserScan>& event) { on_scan(event); },
      ros::VoidConstPtr(), hints);
  initial_pose_subscriber_ =
      node_.subscribe("initialpose", 10, &SlamNode::on_initial_pose, this, hints);
  ROS_INFO_STREAM("mapping with " << setup_.matcher_name << ": scans from "
                                  << scan_subscriber_.getTopic() << ", frames "
                                  << setup_.run.map_frame << ", "
                                  << (setup_.run.use_odometry ? setup_.run.odom_frame + ", " : "")
                                  << setup_.run.base_frame);
  mapping_thread_ = std::thread([this] { run_mapping(); });
}

SlamNode::~SlamNode() {
  initial_pose_subscriber_.shutdown();
  scan_subscriber_.shutdown();
  transform_subscriber_.shutdown();
  static_transform_subscriber_.shutdown();
  service_spinner_->stop();
  diagnostic_timer_.stop();
  transform_timer_.stop();
  map_publisher_.reset();
  {
    const std::lock_guard<std::mutex> lock(queue_mutex_);
    stop_ = true;
  }
  queue_changed_.notify_all();
  mapping_thread_.join();
  try {
    save_trajectory(map_snapshot());
  } catch (const std::exception& error) {
    ROS_ERROR_STREAM(error.what());
  }
}

// --- messages in ---

void SlamNode::on_scan(const ros::MessageEvent<const sensor_msgs::LaserScan>& event) {
  {
    const std::lock_guard<std::mutex> lock(queue_mutex_);
    queue_.add_scan(*event.getConstMessage(), event.getReceiptTime());
    warn_of_skipped();
  }
  queue_changed_.notify_one();
}

void SlamNode::on_transforms(const ros::MessageEvent<const tf2_msgs::TFMessage>& event,
                             bool is_static) {
  {
    const std::lock_guard<std::mutex> lock(queue_mutex_);
    queue_.add_transforms(*event.getConstMessage(), is_static, event.getReceiptTime());
    warn_of_map_link(event);
    warn_of_skipped();
  }
  queue_changed_.notify_one();
}

void SlamNode::on_initial_pose(const geometry_msgs::PoseWithCovarianceStamped& message) {
  const std::string frame = without_leading_slash(message.header.frame_id);
  if (frame != setup_.run.map_frame) {
    ROS_WARN_STREAM("initialpose in frame '" << frame << "' is ignored; it has to be in '"
                                             << setup_.run.map_frame << "'");
    return;
  }
  if (const std::string defect = find_defect(message.pose); !defect.empty()) {
    ROS_WARN_STREAM("initialpose is ignored: " << defect);
    return;
  }
  const std::lock_guard<std::mutex> lock(run_mutex_);
  run_.set_pose(to_pose2(message.pose.pose), plane_covariance(message.pose));
}

void SlamNode::warn_of_map_link(const ros::MessageEvent<const tf2_msgs::TFMessage>& event) {
  // What we publish comes back to us; within a process roscpp does not name the publisher.
  const std::string& publisher = event.getPublisherName();
  if (told_of_map_link_ || publisher == ros::this_node::getName() ||
      publisher == "unknown_publisher") {
    return;
  }
  const std::string link = find_map_link(*event.getConstMessage(), setup_.run.map_frame);
  if (!link.empty()) {
    ROS_WARN_STREAM("tf that touches the map frame is ignored: "
                    << link << ", published by " << publisher
                    << "; if that is another localiser, set publish_tf to false or stop it");
    told_of_map_link_ = true;
  }
}

void SlamNode::warn_of_skipped() {
  for (const SkippedScan& skipped : queue_.take_skipped()) {
    last_skip_ = skipped.text;
    const ros::WallTime now = ros::WallTime::now();
    const auto last = last_warning_.find(skipped.reason);
    if (last != last_warning_.end() && (now - last->second).toSec() < kWarningInterval) {
      continue;
    }
    last_warning_[skipped.reason] = now;
    ROS_WARN_STREAM(skipped.text << " (" << queue_.account().skipped_total() << " of "
                                 << queue_.account().received << " scans skipped so far)");
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
      ROS_ERROR_STREAM_THROTTLE(kWarningInterval, "mapping: " << error.what());
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
  {
    const std::lock_guard<std::mutex> lock(run_mutex_);
    outcome = run_.process(scan.input);
    last_stamp_ = scan.stamp;
    base_from_laser_ = scan.input.base_from_laser;
    const std::lock_guard<std::mutex> transform_lock(transform_mutex_);
    map_transform_ = map_transform(scan, outcome);
  }
  if (outcome.left_out) {
    ROS_WARN_STREAM_THROTTLE(kWarningInterval, kLeftOut);
  }
  publish_pose(scan, outcome);
}

void SlamNode::jump(const TimeJump& jump) {
  if (jump.stopped) {
    ROS_ERROR_STREAM("time has jumped back by " << jump.seconds
                                                << " s; no more scans are used, as time_jump is "
                                                   "'stop'");
  } else {
    ROS_WARN_STREAM("time has jumped back by "
                    << jump.seconds << " s; starting a new map, as time_jump is 'reset'");
    forget_map();
  }
}

void SlamNode::forget_map() {
  const std::lock_guard<std::mutex> lock(run_mutex_);
  run_.reset();
  ++resets_;
  const std::lock_guard<std::mutex> transform_lock(transform_mutex_);
  map_transform_.reset();
}

// --- messages out ---

void SlamNode::publish_pose(const ReadyScan& scan, const ScanOutcome& outcome) {
  geometry_msgs::PoseWithCovarianceStamped message;
  message.header.frame_id = setup_.run.map_frame;
  message.header.stamp = scan.stamp;
  message.pose = to_pose_message(outcome.map_from_base, outcome.covariance);
  pose_publisher_.publish(message);
}

geometry_msgs::TransformStamped SlamNode::map_transform(const ReadyScan& scan,
                                                        const ScanOutcome& outcome) const {
  geometry_msgs::TransformStamped transform;
  transform.header.frame_id = setup_.run.map_frame;
  transform.header.stamp = scan.stamp;
  transform.child_frame_id = outcome.odom_from_base ? setup_.run.odom_frame : setup_.run.base_frame;
  transform.transform = to_transform_message(
      outcome.odom_from_base ? outcome.map_from_base * outcome.odom_from_base->inverse()
                             : outcome.map_from_base);
  return transform;
}

void SlamNode::publish_transform() {
  // Simulated time goes in steps: within one, tf would complain of repeated data.
  const ros::Time now = ros::Time::now();
  if (now.isZero() || now == last_transform_time_) {
    return;
  }
  last_transform_time_ = now;
  std::optional<geometry_msgs::TransformStamped> transform;
  {
    const std::lock_guard<std::mutex> lock(transform_mutex_);
    transform = map_transform_;
  }
  if (transform) {
    transform->header.stamp = now + ros::Duration(setup_.node.transform_tolerance);
    broadcaster_.sendTransform(*transform);
  }
}

MapRevision SlamNode::map_revision() {
  const std::lock_guard<std::mutex> lock(run_mutex_);
  return {resets_, run_.inserted(), run_.trajectory().size()};
}

MapSnapshot SlamNode::map_snapshot() {
  const std::lock_guard<std::mutex> lock(run_mutex_);
  return {{resets_, run_.inserted(), run_.trajectory().size()},
          last_stamp_,
          run_.map().occupancy,
          run_.trajectory(),
          run_.odometry()};
}

void SlamNode::update_diagnostics(diagnostic_updater::DiagnosticStatusWrapper& status) {
  SlamHealth health;
  health.matcher = setup_.matcher_name;
  {
    const std::lock_guard<std::mutex> lock(queue_mutex_);
    health.account = queue_.account();
    health.waiting = queue_.waiting();
    health.last_skip = last_skip_;
    health.stopped = queue_.stopped();
  }
  {
    const std::lock_guard<std::mutex> lock(run_mutex_);
    const std::vector<float>& all = run_.match_seconds();
    const std::size_t recent = std::min<std::size_t>(all.size(), 200);
    health.recent_match_seconds.assign(all.end() - static_cast<std::ptrdiff_t>(recent), all.end());
    health.map_bytes = run_.map().occupancy.bytes() + run_.map().field.bytes();
  }
  diagnostics_.fill(health, status);
}

}  // namespace matchbox_slam
