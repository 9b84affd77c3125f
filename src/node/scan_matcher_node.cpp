#include "node/scan_matcher_node.hpp"

#include <fmt/core.h>
#include <nav_msgs/Odometry.h>

#include "node/ros_parameters.hpp"
#include "node/scan_subscription.hpp"
#include "node/subscribe.hpp"
#include "ros/message_conversion.hpp"
#include "ros/odometry_message.hpp"
#include "ros/queue_settings.hpp"

namespace matchbox_slam {

namespace {

constexpr double kWarningInterval = 10.0;  // s

/// Which link is in tf besides; it need not be that of the messages.
std::string text_of_tf(const ScanMatcherSetup& setup) {
  if (!setup.node.publish_tf) {
    return "";
  }
  return setup.tf_child() == setup.node.base_frame
             ? " and in tf"
             : fmt::format(", {} -> {} in tf", setup.node.odom_frame, setup.tf_child());
}

}  // namespace

std::string find_rival_link(const tf2_msgs::TFMessage& message, const std::string& child,
                            const std::string& own_parent, bool from_others) {
  for (const geometry_msgs::TransformStamped& link : message.transforms) {
    const std::string parent = without_leading_slash(link.header.frame_id);
    if (without_leading_slash(link.child_frame_id) == child &&
        (parent != own_parent || from_others)) {
      return fmt::format("{} -> {}", parent, child);
    }
  }
  return {};
}

ScanMatcherNode::ScanMatcherNode(const ros::NodeHandle& node, const ros::NodeHandle& private_node)
    : node_(node),
      private_node_(private_node),
      setup_(from_ros_parameters(private_node_,
                                 [&](const Parameters& parameters) {
                                   return make_scan_matcher_setup(parameters, loader_);
                                 })),
      matcher_(std::make_shared<TimedMatcher>(setup_.matcher)),
      worker_("matching", queue_settings(setup_),
              [this](const ScanQueue::Item& item) { handle(item); }),
      odometry_publisher_(node_.advertise<nav_msgs::Odometry>("scan_odom", 50)),
      diagnostic_updater_(node_, private_node_, private_node_.getNamespace()) {
  start_anew();
  subscribe();
  start_diagnostics();
  ROS_INFO_STREAM("laser odometry with "
                  << setup_.matcher_name << ": scans from " << scan_subscriber_.getTopic()
                  << ", guess by " << setup_.node.guess << ", " << setup_.node.odom_frame << " -> "
                  << setup_.node.base_frame << " on " << odometry_publisher_.getTopic()
                  << text_of_tf(setup_));
  worker_.start();
}

ScanMatcherNode::~ScanMatcherNode() {
  scan_subscriber_.shutdown();
  imu_subscriber_.shutdown();
  transform_subscriber_.shutdown();
  static_transform_subscriber_.shutdown();
  diagnostic_spinner_->stop();
  diagnostic_timer_.stop();
  silence_watch_->stop();
  worker_.stop();
}

// --- messages in ---

void ScanMatcherNode::subscribe() {
  const auto subscribe_to_transforms = [&](const std::string& topic, bool is_static) {
    return subscribe_to_events<tf2_msgs::TFMessage>(
        node_, topic, kTransformMessages,
        [this, is_static](const auto& event) { on_transforms(event, is_static); });
  };
  static_transform_subscriber_ = subscribe_to_transforms("/tf_static", true);
  transform_subscriber_ = subscribe_to_transforms("/tf", false);
  scan_subscriber_ =
      subscribe_to_scans(node_, "scan", setup_.cloud, [this](const ScanArrival& scan) {
        is_heard_ = true;
        worker_.use_queue([&](ScanQueue& queue) { queue.add_scan(scan.message, scan.time); });
      });
  if (setup_.guess == GuessSource::kHeading) {
    imu_subscriber_ = subscribe_to_imu(node_, "imu", worker_);
  }
}

void ScanMatcherNode::on_transforms(const ros::MessageEvent<const tf2_msgs::TFMessage>& event,
                                    bool is_static) {
  worker_.use_queue([&](ScanQueue& queue) {
    queue.add_transforms(*event.getConstMessage(), is_static, event.getReceiptTime());
  });
  look_for_rival(event);
}

void ScanMatcherNode::look_for_rival(const ros::MessageEvent<const tf2_msgs::TFMessage>& event) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!setup_.node.publish_tf || !tf_conflict_.empty()) {
    return;
  }
  // What we publish comes back to us.
  const std::string& publisher = event.getPublisherName();
  const std::string link =
      find_rival_link(*event.getConstMessage(), setup_.tf_child(), setup_.node.odom_frame,
                      publisher != ros::this_node::getName());
  if (!link.empty()) {
    tf_conflict_ = fmt::format(
        "no tf is published any more, since {} publishes {} and a frame has one parent; set "
        "publish_tf to false, or, if that is odometry, give it as guess_frame with guess "
        "'odometry'",
        publisher, link);
    ROS_ERROR_STREAM(tf_conflict_);
  }
}

// --- matching ---

void ScanMatcherNode::handle(const ScanQueue::Item& item) {
  if (const auto* scan = std::get_if<ReadyScan>(&item)) {
    match_scan(*scan);
  } else if (const auto* jump = std::get_if<TimeJump>(&item)) {
    ROS_WARN_STREAM("time has jumped back by " << jump->seconds
                                               << " s; the odometry starts anew, at its origin");
    start_anew();
  }
}

void ScanMatcherNode::match_scan(const ReadyScan& scan) {
  const LaserOdometryOutcome outcome = odometry_->process(scan.input);
  bool with_tf = setup_.node.publish_tf;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    matches_.add(outcome, matcher_->take_seconds());
    with_tf = with_tf && tf_conflict_.empty();
  }
  warn_of_failure(outcome);
  publish(scan, outcome, with_tf);
}

void ScanMatcherNode::warn_of_failure(const LaserOdometryOutcome& outcome) const {
  if (outcome.restarted) {
    ROS_WARN_STREAM(setup_.odometry.odometry.lost_after
                    << " scans in a row did not fit; a new local map starts where the guess is");
  } else if (!outcome.match.accepted() &&
             outcome.match.status != MatchStatus::kRejectedNoReference) {
    ROS_WARN_STREAM_THROTTLE(kWarningInterval, "a scan was not matched ("
                                                   << to_string(outcome.match.status)
                                                   << "); the guess stands");
  }
}

void ScanMatcherNode::start_anew() {
  odometry_ = std::make_unique<LaserOdometry>(setup_.odometry, matcher_, setup_.guess,
                                              static_cast<std::uint64_t>(setup_.node.seed));
}

// --- messages out ---

void ScanMatcherNode::publish(const ReadyScan& scan, const LaserOdometryOutcome& outcome,
                              bool with_tf) {
  odometry_publisher_.publish(
      to_message(outcome, scan.stamp, setup_.node.odom_frame, setup_.node.base_frame));
  if (!with_tf) {
    return;
  }
  geometry_msgs::TransformStamped transform;
  transform.header.frame_id = setup_.node.odom_frame;
  transform.header.stamp = scan.stamp;
  transform.child_frame_id = setup_.tf_child();
  // Above the odometry that gives the guess, since its link to the base is its own.
  const Pose2 odom_from_child =
      setup_.guess == GuessSource::kOdometry
          ? outcome.odom_from_base * scan.input.odometry->odom_from_base.inverse()
          : outcome.odom_from_base;
  transform.transform = to_transform_message(odom_from_child);
  broadcaster_.sendTransform(transform);
}

void ScanMatcherNode::start_diagnostics() {
  ros::NodeHandle node = node_;
  node.setCallbackQueue(&diagnostic_queue_);
  diagnostic_updater_.setHardwareID("none");
  diagnostic_updater_.add("Laser odometry", this, &ScanMatcherNode::update_diagnostics);
  // By the wall clock, so that it goes on when simulated time stands still.
  diagnostic_timer_ = node.createWallTimer(
      ros::WallDuration(diagnostic_updater_.getPeriod()),
      [this](const ros::WallTimerEvent& /*event*/) { diagnostic_updater_.force_update(); });
  silence_watch_ = std::make_unique<SilenceWatch>(node, [this] {
    return is_heard_ ? std::vector<std::string>{}
                     : std::vector<std::string>{scan_subscriber_.getTopic()};
  });
  diagnostic_spinner_ = std::make_unique<ros::AsyncSpinner>(1, &diagnostic_queue_);
  diagnostic_spinner_->start();
}

void ScanMatcherNode::update_diagnostics(diagnostic_updater::DiagnosticStatusWrapper& status) {
  ScanMatcherHealth health;
  health.matcher = setup_.matcher_name;
  const QueueHealth queue = worker_.health();
  health.account = queue.account;
  health.waiting = queue.waiting;
  health.last_skip = queue.last_skip;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    health.matches = matches_;
    health.tf_conflict = tf_conflict_;
  }
  diagnostics_.fill(health, status);
}

}  // namespace matchbox_slam
