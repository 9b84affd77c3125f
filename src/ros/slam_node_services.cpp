#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <utility>

#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/map_file.hpp"
#include "matchbox_slam/io/map_picture.hpp"
#include "matchbox_slam/io/tum.hpp"
#include "matchbox_slam/matching/relocalise.hpp"
#include "matchbox_slam/ros/message_conversion.hpp"
#include "matchbox_slam/ros/slam_node.hpp"

namespace matchbox_slam {

void SlamNode::start_services() {
  ros::NodeHandle node = node_;
  ros::NodeHandle private_node = private_node_;
  node.setCallbackQueue(&service_queue_);
  private_node.setCallbackQueue(&service_queue_);
  dynamic_map_service_ = node.advertiseService("dynamic_map", &SlamNode::answer_dynamic_map, this);
  save_map_service_ = private_node.advertiseService("save_map", &SlamNode::answer_save_map, this);
  reset_service_ = private_node.advertiseService("reset", &SlamNode::answer_reset, this);
  pause_service_ = private_node.advertiseService("pause", &SlamNode::answer_pause, this);
  relocalise_service_ =
      private_node.advertiseService("relocalise", &SlamNode::answer_relocalise, this);
  diagnostic_updater_.setHardwareID("none");
  diagnostic_updater_.add("SLAM", this, &SlamNode::update_diagnostics);
  // By the wall clock, so that it goes on when simulated time stands still.
  diagnostic_timer_ = node.createWallTimer(
      ros::WallDuration(diagnostic_updater_.getPeriod()),
      [this](const ros::WallTimerEvent& /*event*/) { diagnostic_updater_.force_update(); });
  service_spinner_ = std::make_unique<ros::AsyncSpinner>(1, &service_queue_);
  service_spinner_->start();
}

bool SlamNode::answer_dynamic_map(nav_msgs::GetMap::Request& /*request*/,
                                  nav_msgs::GetMap::Response& response) {
  const MapSnapshot snapshot = map_snapshot();
  response.map = to_message(snapshot.occupancy, setup_.run.map_frame, snapshot.stamp);
  return true;
}

bool SlamNode::answer_save_map(std_srvs::Trigger::Request& /*request*/,
                               std_srvs::Trigger::Response& response) {
  try {
    const MapSnapshot snapshot = map_snapshot();
    if (snapshot.revision.scans == 0) {
      throw std::runtime_error("no scan was mapped yet; nothing is saved, so that no map is lost");
    }
    save_map_files(snapshot);
    save_trajectory(snapshot);
    response.success = 1;
    response.message = "map of " + std::to_string(snapshot.revision.scans) + " scans saved as " +
                       std::filesystem::absolute(setup_.node.map_file).string() +
                       ".pgm, .yaml and .png";
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
  forget_map();
  response.success = 1;
  response.message = "map and trajectory are forgotten; the next scan starts a new map";
  return true;
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
  std::optional<Eigen::Isometry3d> base_from_laser;
  {
    const std::lock_guard<std::mutex> lock(run_mutex_);
    key_scans = run_.key_scans();
    base_from_laser = base_from_laser_;
  }
  if (key_scans.empty() || !base_from_laser) {
    response.message = "no scan was mapped yet";
    return true;
  }
  if (const std::string defect = find_defect(request.scan); !defect.empty()) {
    response.message = "the scan cannot be used: " + defect;
    return true;
  }
  const Relocalisation found = relocalise(
      project_scan(to_laser_scan(request.scan), *base_from_laser, {}, setup_.engine.scan),
      key_scans, setup_.hough);
  for (const RankedPose& pose : found.poses) {
    geometry_msgs::Pose message;
    message.position.x = pose.map_from_base.x;
    message.position.y = pose.map_from_base.y;
    message.orientation.z = std::sin(0.5 * pose.map_from_base.theta);
    message.orientation.w = std::cos(0.5 * pose.map_from_base.theta);
    response.poses.push_back(message);
    response.scores.push_back(pose.score);
  }
  response.ratio = found.ratio;
  response.message = std::to_string(found.poses.size()) + " poses, from " +
                     std::to_string(key_scans.size()) + " key scans";
  return true;
}

void SlamNode::save_map_files(const MapSnapshot& snapshot) const {
  const std::string base_path = std::filesystem::absolute(setup_.node.map_file).string();
  std::vector<FileContents> files = map_files(base_path, make_map_image(snapshot.occupancy));
  files.push_back(
      {base_path + ".png", encode_png(draw_map(snapshot.occupancy, Trajectory(snapshot.trajectory),
                                               Trajectory(snapshot.odometry)))});
  replace_files(files);
}

void SlamNode::save_trajectory(const MapSnapshot& snapshot) const {
  if (!setup_.node.trajectory_file.empty()) {
    write_tum(std::filesystem::absolute(setup_.node.trajectory_file).string(),
              Trajectory(snapshot.trajectory));
  }
}

}  // namespace matchbox_slam
