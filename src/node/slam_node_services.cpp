#include <filesystem>
#include <stdexcept>
#include <utility>

#include "io/map_picture.hpp"
#include "io/tum.hpp"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/map_file.hpp"
#include "matchbox_slam/io/saved_map.hpp"
#include "matching/hough/relocalise.hpp"
#include "node/slam_node.hpp"
#include "ros/message_conversion.hpp"

namespace matchbox_slam {

namespace {

// The best pose of a relocalisation counts as the only one from this ratio to the second best on.
constexpr double kUnique = 1.2;

// After so long without a scan, the log says so [s].
constexpr double kPatience = 5.0;

// How well a scan is placed among key scans: [m], [rad].
const Eigen::Vector2d kRelocalised(0.1, 0.05);

/// Why its best pose is not to be taken as the robot's, or nothing.
std::string doubt_about(const Relocalisation& found) {
  if (found.poses.empty()) {
    return "no pose was found";
  }
  const bool has_rival = found.ratio != 0.0 && found.ratio < kUnique;
  return has_rival ? "the second best fits nearly as well" : "";
}

}  // namespace

void SlamNode::start_services() {
  ros::NodeHandle node = node_;
  ros::NodeHandle private_node = private_node_;
  node.setCallbackQueue(&service_queue_);
  private_node.setCallbackQueue(&service_queue_);
  dynamic_map_service_ = node.advertiseService("dynamic_map", &SlamNode::answer_dynamic_map, this);
  save_map_service_ = private_node.advertiseService("save_map", &SlamNode::answer_save_map, this);
  load_map_service_ = private_node.advertiseService("load_map", &SlamNode::answer_load_map, this);
  reset_service_ = private_node.advertiseService("reset", &SlamNode::answer_reset, this);
  pause_service_ = private_node.advertiseService("pause", &SlamNode::answer_pause, this);
  relocalise_service_ =
      private_node.advertiseService("relocalise", &SlamNode::answer_relocalise, this);
  reconfigure_server_ = std::make_unique<ReconfigureServer>(
      private_node, configuration_.options(),
      [this](const Parameters& changes) { return reconfigure(changes); });
  diagnostic_updater_.setHardwareID("none");
  diagnostic_updater_.add("SLAM", this, &SlamNode::update_diagnostics);
  // By the wall clock, so that it goes on when simulated time stands still.
  diagnostic_timer_ = node.createWallTimer(
      ros::WallDuration(diagnostic_updater_.getPeriod()),
      [this](const ros::WallTimerEvent& /*event*/) { diagnostic_updater_.force_update(); });
  silence_timer_ =
      node.createWallTimer(ros::WallDuration(kPatience),
                           [this](const ros::WallTimerEvent& /*event*/) { warn_of_silence(); });
  service_spinner_ = std::make_unique<ros::AsyncSpinner>(1, &service_queue_);
}

bool SlamNode::answer_dynamic_map(nav_msgs::GetMap::Request& /*request*/,
                                  nav_msgs::GetMap::Response& response) {
  const MapSnapshot snapshot = map_snapshot();
  response.map = to_message(snapshot.occupancy, options_.map_frame, snapshot.stamp);
  return true;
}

bool SlamNode::answer_save_map(std_srvs::Trigger::Request& /*request*/,
                               std_srvs::Trigger::Response& response) {
  try {
    const MapSnapshot snapshot = map_snapshot();
    if (snapshot.revision.scans == 0) {
      throw std::runtime_error("no scan was mapped yet; nothing is saved, so that no map is lost");
    }
    const std::string path =
        std::filesystem::absolute(configuration_.setup().node.map_file).string();
    save_map_files(map_to_go_on_with(), snapshot, path);
    save_trajectory();
    response.success = 1;
    response.message = "map of " + std::to_string(snapshot.revision.scans) + " scans saved as " +
                       path + ".pgm, .yaml, .png and .slam";
  } catch (const std::exception& error) {
    response.success = 0;
    response.message = error.what();
  }
  return true;
}

bool SlamNode::answer_reset(std_srvs::Trigger::Request& /*request*/,
                            std_srvs::Trigger::Response& response) {
  {
    const std::lock_guard<std::mutex> lock(queue_mutex_);
    queue_.start_again();
  }
  start_from(initial_map_);
  response.success = 1;
  response.message = initial_map_
                         ? "map and trajectory are forgotten; it goes on with initial_map"
                         : "map and trajectory are forgotten; the next scan starts a new map";
  return true;
}

bool SlamNode::answer_load_map(LoadMap::Request& request, LoadMap::Response& response) {
  try {
    MapStart start = read_initial_map(request.path);
    const bool has_key_scans = !start.key_scans.empty();
    start_from(std::move(start));
    response.success = 1;
    response.message = "going on with '" + request.path +
                       "'; where the robot is in it may be told by initialpose" +
                       (has_key_scans ? ", or by ~relocalise with set_pose"
                                      : "; not by ~relocalise, since it has no key scans");
  } catch (const std::exception& error) {
    response.success = 0;
    response.message = error.what();
  }
  return true;
}

std::vector<OptionDescription> SlamNode::reconfigure(const Parameters& changes) {
  LiveConfiguration changed = configuration_.with(changes);
  {
    const std::lock_guard<std::mutex> lock(run_mutex_);
    run_.reconfigure(changed.setup());
    matcher_name_ = changed.setup().matcher_name;
  }
  configuration_ = std::move(changed);
  const SlamSetup& setup = configuration_.setup();
  publish_tf_ = setup.node.publish_tf;
  transform_tolerance_ = setup.node.transform_tolerance;
  map_publisher_->set_interval(setup.node.map_update_interval);
  const std::lock_guard<std::mutex> lock(queue_mutex_);
  queue_.set_max_lag(setup.run.max_lag);
  return configuration_.options();
}

bool SlamNode::answer_pause(std_srvs::SetBool::Request& request,
                            std_srvs::SetBool::Response& response) {
  const bool paused = request.data != 0;
  {
    const std::lock_guard<std::mutex> lock(queue_mutex_);
    queue_.set_paused(paused);
  }
  response.success = 1;
  response.message =
      paused ? "scans are skipped until this is called with false" : "scans are used again";
  return true;
}

bool SlamNode::answer_relocalise(Relocalise::Request& request, Relocalise::Response& response) {
  KeyScans key_scans;
  std::optional<ReadyScan> newest;
  Pose2 believed;
  {
    const std::lock_guard<std::mutex> lock(run_mutex_);
    key_scans = run_.key_scans();
    newest = newest_scan_;
    believed = newest_pose_;
  }
  const bool is_newest = request.scan.ranges.empty();
  if (key_scans.empty()) {
    response.message =
        "there are no key scans to find a scan among: they come as the map is made, or with a "
        ".slam file, not with an image; tell where the robot is by initialpose";
    return true;
  }
  if (!newest) {
    response.message =
        "no scan was used yet since the map was loaded or the node started, and one tells where "
        "the "
        "laser is on the robot; call again when there was one";
    return true;
  }
  if (const std::string defect = is_newest ? "" : find_defect(request.scan); !defect.empty()) {
    response.message = "the scan cannot be used: " + defect;
    return true;
  }
  const SlamSetup& setup = configuration_.setup();
  const LaserScan scan = is_newest ? newest->input.scan : to_laser_scan(request.scan);
  const Relocalisation found =
      relocalise(project_scan(scan, newest->input.base_from_laser, {}, setup.engine.scan),
                 key_scans, setup.hough);
  for (const RankedPose& pose : found.poses) {
    response.poses.push_back(to_pose_message(pose.map_from_base));
    response.scores.push_back(pose.score);
  }
  response.ratio = found.ratio;
  response.message = std::to_string(found.poses.size()) + " poses, from " +
                     std::to_string(key_scans.size()) + " key scans";
  if (request.set_pose != 0) {
    const std::string why_not = is_newest ? doubt_about(found) : "the scan is not the newest one";
    if (why_not.empty()) {
      correct_pose(found.poses.front().map_from_base, believed);
      response.pose_set = 1;
    }
    response.message += why_not.empty() ? "; the best is the robot's pose now"
                                        : "; the robot's pose stays, as " + why_not;
  }
  return true;
}

/// The robot was elsewhere than believed at an earlier scan; since then it has moved as it was seen
/// to.
void SlamNode::correct_pose(const Pose2& map_from_base_then, const Pose2& believed_then) {
  const Eigen::Matrix3d covariance =
      Eigen::Vector3d(kRelocalised.x() * kRelocalised.x(), kRelocalised.x() * kRelocalised.x(),
                      kRelocalised.y() * kRelocalised.y())
          .asDiagonal();
  const std::lock_guard<std::mutex> lock(run_mutex_);
  run_.set_pose(map_from_base_then * (believed_then.inverse() * newest_pose_), covariance);
}

MapStart SlamNode::map_to_go_on_with() {
  const std::lock_guard<std::mutex> lock(run_mutex_);
  return run_.snapshot();
}

void SlamNode::save_map_files(const MapStart& map, const MapSnapshot& snapshot,
                              const std::string& path) const {
  const Picture picture =
      draw_map(map.map.occupancy, Trajectory(snapshot.path), Trajectory(snapshot.odometry_path));
  std::vector<FileContents> files = map_files(path, make_map_image(map.map.occupancy));
  files.push_back({path + ".png", picture.to_png()});
  files.push_back({path + ".slam", to_saved_map(map)});
  replace_files(files);
}

void SlamNode::save_trajectory() {
  if (trajectory_file_.empty()) {
    return;
  }
  std::vector<StampedPose2> trajectory;
  {
    const std::lock_guard<std::mutex> lock(run_mutex_);
    trajectory = run_.trajectory();
  }
  write_tum(std::filesystem::absolute(trajectory_file_).string(),
            Trajectory(std::move(trajectory)));
}

void SlamNode::update_diagnostics(diagnostic_updater::DiagnosticStatusWrapper& status) {
  SlamHealth health;
  health.updates_map = configuration_.setup().engine.slam.update_map;
  {
    const std::lock_guard<std::mutex> lock(queue_mutex_);
    health.account = queue_.account();
    health.waiting = queue_.waiting() + held_scans_.size();
    health.last_skip = skip_warnings_.latest();
    health.stopped = queue_.stopped();
    health.estimated_clock_offset = untold_clock_offset_;
  }
  {
    const std::lock_guard<std::mutex> lock(run_mutex_);
    health.matcher = matcher_name_;
    health.recent = recent_;
    health.map_bytes = run_.map().occupancy.bytes() + run_.map().field.bytes();
  }
  diagnostics_.fill(health, status);
}

}  // namespace matchbox_slam
