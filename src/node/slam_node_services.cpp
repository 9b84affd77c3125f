// What the SLAM node answers when it is asked.

#include <fmt/core.h>

#include <algorithm>
#include <iostream>
#include <stdexcept>
#include <string>
#include <utility>

#include "matchbox_slam/io/file.hpp"
#include "node/slam_node.hpp"
#include "ros/message_conversion.hpp"
#include "run/mergeable_map.hpp"
#include "run/start_map.hpp"

namespace matchbox_slam {

namespace {

// The best pose of a relocalisation counts as the only one from this ratio to the second best on: a
// guess, half and double were not tried.
constexpr double kMinUniqueRatio = 1.2;

/// Why its best pose is not to be taken as the robot's, or nothing.
std::string doubt_about(const Relocalisation& found) {
  if (found.poses.empty()) {
    return "no pose was found";
  }
  const bool has_rival = found.ratio != 0.0 && found.ratio < kMinUniqueRatio;
  return has_rival ? "the second best fits nearly as well" : "";
}

/// Answers with what the work says of its success, or why it failed.
template <typename Response, typename Work>
bool answer(Response& response, const Work& work) {
  try {
    response.message = work();
    response.success = 1;
  } catch (const std::exception& error) {
    response.success = 0;
    response.message = error.what();
  }
  return true;
}

}  // namespace

void SlamNode::start_services() {
  ros::NodeHandle prompt = node_;
  ros::NodeHandle prompt_private = private_node_;
  ros::NodeHandle patient = node_;
  ros::NodeHandle patient_private = private_node_;
  prompt.setCallbackQueue(&prompt_queue_);
  prompt_private.setCallbackQueue(&prompt_queue_);
  patient.setCallbackQueue(&patient_queue_);
  patient_private.setCallbackQueue(&patient_queue_);
  services_ = {
      prompt.advertiseService("dynamic_map", &SlamNode::answer_dynamic_map, this),
      patient.advertiseService("global_localization", &SlamNode::answer_global_localization, this),
      patient_private.advertiseService("save_map", &SlamNode::answer_save_map, this),
      prompt_private.advertiseService("load_map", &SlamNode::answer_load_map, this),
      patient_private.advertiseService("merge_map", &SlamNode::answer_merge_map, this),
      prompt_private.advertiseService("reset", &SlamNode::answer_reset, this),
      patient_private.advertiseService("pause", &SlamNode::answer_pause, this),
      patient_private.advertiseService("relocalise", &SlamNode::answer_relocalise, this),
      patient_private.advertiseService("set_pose_at_stamp", &SlamNode::answer_set_pose_at_stamp,
                                       this)};
  reconfigure_server_ = std::make_unique<ReconfigureServer>(
      patient_private, run().configuration().options(),
      [this](const Parameters& changes) { return reconfigure(changes); });
  diagnostic_updater_.setHardwareID("none");
  diagnostic_updater_.add("SLAM", this, &SlamNode::update_diagnostics);
  // By the wall clock, so that it goes on when simulated time stands still.
  diagnostic_timer_ = prompt.createWallTimer(
      ros::WallDuration(diagnostic_updater_.getPeriod()),
      [this](const ros::WallTimerEvent& /*event*/) { diagnostic_updater_.force_update(); });
  input_ = std::make_unique<SlamInput>(node_, prompt, session_.setup(), worker_,
                                       [this](double from) { cut_no_returns(from); });
  for (ros::CallbackQueue* queue : {&prompt_queue_, &patient_queue_}) {
    spinners_.push_back(std::make_unique<ros::AsyncSpinner>(1, queue));
  }
}

bool SlamNode::answer_dynamic_map(nav_msgs::GetMap::Request& /*request*/,
                                  nav_msgs::GetMap::Response& response) {
  const MapSnapshot snapshot = map_snapshot();
  response.map = to_message(snapshot.occupancy, options_.map_frame, snapshot.stamp);
  return true;
}

/// As amcl's: its answer has no room for a reason.
bool SlamNode::answer_global_localization(std_srvs::Empty::Request& /*request*/,
                                          std_srvs::Empty::Response& /*response*/) {
  try {
    worker_.carry_out(BeAnywhere{});
  } catch (const std::exception& error) {
    ROS_ERROR_STREAM("global_localization is refused: " << error.what());
    return false;
  }
  return true;
}

bool SlamNode::answer_save_map(std_srvs::Trigger::Request& /*request*/,
                               std_srvs::Trigger::Response& response) {
  return answer(response, [&] {
    require_used_scan();
    finish_loops();
    std::string saved = save_map_files();
    if (autosave_) {
      autosave_->postpone();
    }
    save_records();
    return saved;
  });
}

bool SlamNode::answer_reset(std_srvs::Trigger::Request& /*request*/,
                            std_srvs::Trigger::Response& response) {
  worker_.use_queue([](ScanQueue& queue) { queue.start_again(); });
  const std::vector<RunEvent> beginning = [this] {
    const std::lock_guard<std::mutex> lock(run_mutex_);
    return session_.beginning();
  }();
  for (const RunEvent& event : beginning) {
    worker_.carry_out(event);
  }
  response.success = 1;
  response.message = std::holds_alternative<LoadMapFile>(beginning.front())
                         ? "map and trajectory are forgotten; it goes on with initial_map"
                         : "map and trajectory are forgotten; the next scan starts a new map";
  return true;
}

LoadMapFile SlamNode::read_load(const std::string& path) {
  const std::string whole_path = absolute_path(path);
  EngineState map = read_start_map(whole_path, setup());
  return {whole_path, std::make_shared<const EngineState>(std::move(map))};
}

bool SlamNode::answer_load_map(LoadMap::Request& request, LoadMap::Response& response) {
  return answer(response, [&] {
    LoadMapFile load = read_load(request.path);
    const bool has_key_scans = !load.map->key_scans.empty();
    worker_.carry_out(std::move(load));
    return fmt::format("going on with '{}'; where the robot is in it may be told by initialpose{}",
                       request.path,
                       has_key_scans ? ", or by ~relocalise with set_pose"
                                     : "; not by ~relocalise, since it has no key scans");
  });
}

std::vector<OptionDescription> SlamNode::reconfigure(const Parameters& changes) {
  if (!changes.empty()) {
    worker_.carry_out(Reconfigure{changes});
  }
  const std::lock_guard<std::mutex> lock(run_mutex_);
  return run().configuration().options();
}

/// What cannot come in by key scans and loops is refused at once, rather than searched for ever.
void SlamNode::require_mergeable(const EngineState& map) {
  const std::lock_guard<std::mutex> lock(run_mutex_);
  const EngineOptions& options = session_.setup().engine;
  if (!options.slam.update_map || !options.slam.loop_closing) {
    throw std::runtime_error(
        fmt::format("slam/{} is false, so the map stays as it is; set it to true",
                    options.slam.update_map ? "loop_closing" : "update_map"));
  }
  if (run().loop_state().nodes != run().key_scans().size()) {
    throw std::runtime_error(
        "the map that this node went on with is an image, which cannot be merged; begin one with "
        "~reset, or go on with a .slam file of key scans");
  }
  const std::size_t lasers = input_->topics().size();
  const int last = last_laser(map);
  if (last >= 0 && static_cast<std::size_t>(last) >= lasers) {
    throw std::runtime_error(
        fmt::format("it was made with laser number {}, and this robot has {}, counted from 0; "
                    "merge both with the program merge_maps",
                    last, lasers));
  }
}

bool SlamNode::answer_merge_map(MergeMap::Request& request, MergeMap::Response& response) {
  return answer(response, [&] {
    const std::string path = absolute_path(request.path);
    EngineState map = read_mergeable_map(path, setup().engine);
    require_mergeable(map);
    const std::size_t key_scans = map.key_scans.size();
    other_maps_->add(path, std::move(map));
    return fmt::format(
        "the {} key scans of '{}' become part of this map where the robot comes to what they saw; "
        "the log tells when",
        key_scans, path);
  });
}

bool SlamNode::answer_pause(std_srvs::SetBool::Request& request,
                            std_srvs::SetBool::Response& response) {
  const bool paused = request.data != 0;
  worker_.carry_out(Pause{paused});
  response.success = 1;
  response.message =
      paused ? "scans are skipped until this is called with false" : "scans are used again";
  return true;
}

bool SlamNode::answer_relocalise(Relocalise::Request& request, Relocalise::Response& response) {
  PlacedScans key_scans;
  std::optional<ReadyScan> newest;
  {
    const std::lock_guard<std::mutex> lock(run_mutex_);
    key_scans = run().key_scans().all();
    newest = newest_scan_;
  }
  const bool is_newest = request.scan.ranges.empty();
  if (key_scans.empty()) {
    response.message =
        "there are no key scans to find a scan among: they come as the map is made, with "
        "a .slam file, or with an image that has free ground; tell where the robot is by "
        "initialpose";
    return true;
  }
  if (!newest) {
    response.message =
        "no scan was used yet since the map was loaded or the node started, and one tells where "
        "the laser is on the robot; call again when there was one";
    return true;
  }
  if (const std::string defect = is_newest ? "" : find_defect(request.scan); !defect.empty()) {
    response.message = "the scan cannot be used: " + defect;
    return true;
  }
  const SlamSetup options = setup();
  const LaserScan scan = is_newest ? newest->input.scan : to_laser_scan(request.scan);
  const Relocalisation found =
      relocalise(project_scan(scan, newest->input.base_from_laser, {}, options.engine.scan),
                 key_scans, options.hough, [this] { return worker_.is_ending(); });
  if (found.interrupted) {
    response.message = "the node is ending";
    return true;
  }
  response.stamp = is_newest ? newest->stamp : request.scan.header.stamp;
  for (const RankedPose& pose : found.poses) {
    response.poses.push_back(to_pose_message(pose.map_from_base));
    response.scores.push_back(pose.score);
  }
  response.ratio = found.ratio;
  response.message =
      fmt::format("{} poses, from {} key scans", found.poses.size(), key_scans.size());
  if (request.set_pose != 0) {
    const std::string why_not = is_newest ? try_to_correct_pose(found, newest->input.scan.stamp)
                                          : "the scan is not the newest one";
    response.pose_set = static_cast<std::uint8_t>(why_not.empty());
    response.message += why_not.empty() ? "; the best is the robot's pose now"
                                        : "; the robot's pose stays, as " + why_not;
  }
  return true;
}

bool SlamNode::answer_set_pose_at_stamp(SetPoseAtStamp::Request& request,
                                        SetPoseAtStamp::Response& response) {
  return answer(response, [&] {
    geometry_msgs::PoseWithCovariance place;
    place.pose = request.pose;
    if (const std::string defect = find_defect(place); !defect.empty()) {
      throw std::runtime_error("the pose cannot be used: " + defect);
    }
    worker_.carry_out(CorrectPose{request.stamp.toSec(), to_pose2(request.pose)});
    return std::string("it goes on from there");
  });
}

/// Returns why the best pose is not the robot's now; empty: it is.
std::string SlamNode::try_to_correct_pose(const Relocalisation& found, double stamp) {
  if (std::string doubt = doubt_about(found); !doubt.empty()) {
    return doubt;
  }
  try {
    worker_.carry_out(CorrectPose{stamp, found.poses.front().map_from_base});
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

MapToSave SlamNode::read_map_to_save() {
  static_cast<void>(map_snapshot());  // rendered while the mapping goes on
  const std::lock_guard<std::mutex> lock(run_mutex_);
  return map_to_save(run());
}

/// Throws std::runtime_error, which says why, where scans have come and none could be used.
void SlamNode::require_used_scan() {
  const QueueHealth queue = worker_.health();
  if (map_revision().scans == 0 && queue.account.delivered == 0 && !queue.last_skip.empty()) {
    throw std::runtime_error(fmt::format(
        "no scan was mapped yet, nothing is saved: of {} that came {} were skipped; the last: {}",
        queue.account.received, queue.account.skipped_total(), queue.last_skip));
  }
}

/// Returns what was saved, for people.
std::string SlamNode::save_map_files() {
  const std::lock_guard<std::mutex> saving(save_mutex_);
  const MapToSave now = read_map_to_save();
  const std::string where = saver_.save(now);
  return fmt::format("map of {} scans saved as {}", now.revision.scans, where);
}

/// In a thread of its own. Trajectory and events are not written: for these the mapping would wait
/// for a search for a loop.
void SlamNode::autosave() {
  if (is_saved()) {
    return;
  }
  const std::lock_guard<std::mutex> saving(save_mutex_);
  saver_.save_changes(read_map_to_save());
}

bool SlamNode::is_saved() {
  const MapRevision now = map_revision();
  const std::lock_guard<std::mutex> saving(save_mutex_);
  return saver_.is_saved(now);
}

std::size_t SlamNode::unsaved_scans() {
  const MapRevision now = map_revision();
  const std::lock_guard<std::mutex> saving(save_mutex_);
  return saver_.unsaved_scans(now);
}

/// At the end.
void SlamNode::tell_unsaved() {
  if (is_saved() || !setup().engine.slam.update_map) {
    return;
  }
  const std::string text = fmt::format(
      "of the map of {} scans {} are not saved. Before the end, rosservice call {}/save_map saves "
      "it; with autosave_period, or slam.launch respawn:=true, it is saved by itself",
      run().scans(), unsaved_scans(), private_node_.getNamespace());
  if (ros::ok()) {
    ROS_WARN_STREAM(text);
  } else {  // a nodelet outlives its manager's ROS, and with that the log
    std::cerr << "[ WARN] " << text << std::endl;
  }
}

void SlamNode::update_diagnostics(diagnostic_updater::DiagnosticStatusWrapper& status) {
  const QueueHealth queue = worker_.health();
  SlamHealth health;
  health.account = queue.account;
  health.waiting = queue.waiting + input_->held_scans();
  health.last_skip = queue.last_skip;
  health.stopped = queue.stopped;
  health.estimated_clock_offset = input_->untold_clock_offset();
  health.rivals = input_->rivals();
  health.unsaved = autosave_ ? autosave_->failure() : "";
  {
    const std::lock_guard<std::mutex> lock(run_mutex_);
    health.updates_map = session_.setup().engine.slam.update_map;
    health.paused = run().is_paused();
    health.matcher = session_.setup().matcher_name;
    health.recent = recent_;
    health.left_out = run().left_out();
    health.key_scans = run().key_scans().size();
    health.loops_closed = run().new_loops().closed;
    health.disconnected_components = run().disconnected_components();
    for (const auto& [number, laser] : run().secondary_lasers()) {
      health.secondary_lasers.push_back(text_of(laser, run().scan_topic(number)));
    }
    health.few_returns = session_.few_returns();
    health.robot_beams = session_.robot_beams();
    health.components_given_up = run().components_given_up();
    health.map_bytes = run().map_bytes();
    health.set_aside = set_aside_;
  }
  diagnostics_.fill(health, status);
}

}  // namespace matchbox_slam
