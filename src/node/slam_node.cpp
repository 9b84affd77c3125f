#include "node/slam_node.hpp"

#include <filesystem>
#include <utility>
#include <variant>

#include "common/number_text.hpp"
#include "io/tum.hpp"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/saved_map.hpp"
#include "matching/rendered_map.hpp"
#include "ros/message_conversion.hpp"
#include "ros/queue_settings.hpp"
#include "ros/ros_parameters.hpp"
#include "run/events_file.hpp"
#include "run/frames.hpp"
#include "run/start_map.hpp"
#include "slam/shown_map.hpp"

namespace matchbox_slam {

namespace {

constexpr std::size_t kRecentScans = 200;

std::string absolute(const std::string& path) {
  return path.empty() ? path : std::filesystem::absolute(path).string();
}

LiveConfiguration read_configuration(const ros::NodeHandle& private_node,
                                     const MatcherLoader& loader) {
  const LiveConfiguration configuration =
      from_ros_parameters(private_node, [&](const Parameters& parameters) {
        LiveConfiguration read(parameters, loader);
        check_frames(read.setup().run);
        return read;
      });
  const SlamNodeOptions& options = configuration.setup().node;
  for (const std::string& file : {options.trajectory_file, options.events_file}) {
    if (!file.empty()) {
      require_writable_folder(std::filesystem::path(absolute(file)).parent_path().string());
    }
  }
  if (options.autosave_period > 0.0) {
    require_writable_folder(
        std::filesystem::path(absolute(options.map_file)).parent_path().string());
  }
  return configuration;
}

ScanQueueSettings node_queue_settings(const SlamSetup& setup) {
  return queue_settings(setup.run, setup.engine.scan.max_tilt, setup.timing,
                        fixed_scan_time_offset(setup.run).value_or(0.0));
}

template <typename Work>
void log_failure(const Work& work) {
  try {
    work();
  } catch (const std::exception& error) {
    ROS_ERROR_STREAM(error.what());
  }
}

/// Of a map that options do not fit, that this program may not read, or that is only to be
/// localised in, somebody has to say what becomes of it: a new one would be no answer.
std::string no_new_map(const std::exception& error, const std::string& path) {
  const std::string changes = path_of_changes(path);
  return std::string(error.what()) + "; resume is true, so it goes on with that map or not at " +
         "all: move the file away to begin without it, mv " + path + " " + path + ".old" +
         (std::filesystem::exists(changes)
              ? ", and what has changed since, mv " + changes + " " + path_of_changes(path + ".old")
              : "");
}

/// All is only kept where it is asked for: it grows as long as the node runs.
RunRecords records_for(const SlamNodeOptions& options) {
  return options.trajectory_file.empty() && options.events_file.empty() ? RunRecords::kRecent
                                                                        : RunRecords::kAll;
}

}  // namespace

SlamNode::SlamNode(const ros::NodeHandle& node, const ros::NodeHandle& private_node)
    : node_(node),
      private_node_(private_node),
      run_([&] {
        LiveConfiguration configuration = read_configuration(private_node_, loader_);
        const RunRecords records = records_for(configuration.setup().node);
        return SlamRun(std::move(configuration), records);
      }()),
      worker_("mapping", node_queue_settings(run_.setup()),
              [this](const ScanQueue::Item& item) {
                std::visit([this](const auto& one) { handle(one); }, item);
              }),
      options_(run_.setup().run),
      trajectory_file_(absolute(run_.setup().node.trajectory_file)),
      events_file_(absolute(run_.setup().node.events_file)),
      poses_(node_, run_.setup()),
      diagnostic_updater_(node_, private_node_, private_node_.getNamespace()) {
  const SlamSetup& setup = run_.setup();
  begin_map();
  map_publisher_ = std::make_unique<MapPublisher>(
      node_, options_.map_frame, setup.node.map_update_interval, [this] { return map_revision(); },
      [this] { return map_snapshot(); });
  start_services();
  initial_pose_subscriber_ = node_.subscribe("initialpose", 10, &SlamNode::on_initial_pose, this,
                                             ros::TransportHints().tcpNoDelay());
  ROS_INFO_STREAM("mapping with " << setup.matcher_name << ": scans from " << join(input_->topics())
                                  << ", frames " << options_.map_frame << ", "
                                  << (options_.use_odometry ? options_.odom_frame + ", " : "")
                                  << options_.base_frame
                                  << (options_.odom_topic.empty()
                                          ? ""
                                          : ", odometry from " + options_.odom_topic)
                                  << (options_.use_odometry || options_.imu_topic.empty()
                                          ? ""
                                          : ", turns from " + options_.imu_topic));
  if (setup.node.autosave_period > 0.0) {
    autosave_ = std::make_unique<Autosave>(setup.node.autosave_period, [this] { autosave(); });
  }
  worker_.start();
  for (const auto& spinner : spinners_) {
    spinner->start();
  }
}

SlamNode::~SlamNode() {
  initial_pose_subscriber_.shutdown();
  input_->stop();
  worker_.stop();  // first, so that no service waits for it
  for (const auto& spinner : spinners_) {
    spinner->stop();
  }
  diagnostic_timer_.stop();
  poses_.stop();
  map_publisher_.reset();
  const bool saves_map = autosave_ != nullptr;
  autosave_.reset();
  log_failure([this] { finish_loops(); });
  log_failure([this] { save_records(); });
  if (!saves_map) {
    tell_unsaved();
    return;
  }
  // Always, as a loop may have been closed since, which no scan tells.
  if (map_revision().scans > 0) {
    log_failure([this] { static_cast<void>(save_map_files()); });
  }
}

/// Goes on with a saved map where there is one to go on with.
void SlamNode::begin_map() {
  const SlamSetup& setup = run_.setup();
  if (!setup.node.initial_map.empty()) {
    initial_map_ = read_load(setup.node.initial_map);
  }
  const std::string saved = absolute(setup.node.map_file) + ".slam";
  if (setup.node.resume && std::filesystem::exists(saved)) {
    try {
      resumed_ = read_resumed(saved);
      run_.start_from(*resumed_);
      resumed_file_ = saved;
      has_resumed_ = true;
      saved_file_ = saved;
      saved_beginnings_ = {run_.resets(), run_.clock_steps()};
    } catch (const ConfigurationError& error) {
      throw ConfigurationError(no_new_map(error, saved));
    } catch (const DamagedFile& error) {
      if (!setup.engine.slam.update_map) {
        throw FileError(no_new_map(error, saved));
      }
      set_map_aside(absolute(setup.node.map_file), error.what());
    } catch (const FileError& error) {
      throw FileError(no_new_map(error, saved));
    }
  }
  if (!has_resumed_ && initial_map_) {
    run_.apply(*initial_map_);
    if (!setup.engine.slam.update_map && !is_start_told() && !run_.key_scans().empty()) {
      run_.apply(BeAnywhere{});
    }
  }
}

/// Of a map whose changes cannot be read the one before is not lost.
EngineState SlamNode::read_resumed(const std::string& file) {
  const EngineOptions& options = run_.setup().engine;
  try {
    return read_engine_state(file, options);
  } catch (const DamagedChanges& error) {
    const std::string folder = set_aside({path_of_changes(file)}, file + ".damaged");
    ROS_ERROR_STREAM(error.what() << "; it is in " << folder << " now");
    return read_engine_state(file, options);
  }
}

/// Whether somebody has said where in the map it begins.
bool SlamNode::is_start_told() const {
  return private_node_.hasParam("start_x") || private_node_.hasParam("start_y") ||
         private_node_.hasParam("start_theta");
}

/// A robot on its way cannot wait for somebody who moves a damaged file; nor may what is left of
/// the map be lost as the new one is saved. The .slam goes last: a node that dies meanwhile finds
/// it again.
void SlamNode::set_map_aside(const std::string& path, const std::string& why) {
  std::vector<std::string> files;
  for (const char* end : {".yaml", ".pgm", ".occupancy.png", ".png", ".slam.changes", ".slam"}) {
    files.push_back(path + end);
  }
  try {
    set_aside_ = set_aside(files, path + ".damaged");
  } catch (const FileError& error) {
    throw FileError(why + "; to begin a new map it has to be moved away: " + error.what());
  }
  ROS_ERROR_STREAM(why << "; a new map begins. That one and its images are in " << set_aside_
                       << " now; ~load_map goes on with an older copy, if there is one");
}

/// As map_bag does, which reads the recording twice; here the map has begun with them, and begins
/// anew unless it is one that was loaded. With several lasers one is no reason to cut all.
void SlamNode::cut_no_returns(double from) {
  const std::string found =
      "where they meet nothing, beams of a laser read its range_max plus noise";
  const std::string limit = fixed_text(from, 3);
  if (options_.scan_topics.size() > 1) {
    ROS_WARN_STREAM(found << ", which draws walls where none are; to cut them: rosrun "
                             "dynamic_reconfigure dynparam set "
                          << private_node_.getNamespace() << " scan/max_range " << limit
                          << ", then ~reset");
    return;
  }
  Parameters changes;
  changes.set("scan/max_range", from);
  worker_.post(Reconfigure{changes});
  if (setup().node.resume && ros::master::check()) {  // without a master it would wait for one
    private_node_.setParam("scan/max_range", from);  // else it would be drawn again after a respawn
  }
  const bool begins_anew = [&] {
    const std::lock_guard<std::mutex> lock(run_mutex_);
    return run_.resets() == 0 && !has_resumed_;
  }();
  if (begins_anew) {
    worker_.post(Reset{});
  }
  ROS_WARN_STREAM(found << "; scan/max_range is set to " << limit
                        << " m, from which on they are no return"
                        << (begins_anew ? ", and the map begins anew" : ""));
}

void SlamNode::on_initial_pose(const geometry_msgs::PoseWithCovarianceStamped& message) {
  const std::string frame = without_leading_slash(message.header.frame_id);
  if (frame != options_.map_frame) {
    ROS_WARN_STREAM("initialpose in frame '" << frame << "' is ignored; it has to be in '"
                                             << options_.map_frame << "'");
    return;
  }
  if (const std::string defect = find_defect(message.pose); !defect.empty()) {
    ROS_WARN_STREAM("initialpose is ignored: " << defect);
    return;
  }
  worker_.post(SetPose{to_pose2(message.pose.pose), plane_covariance(message.pose)});
}

// --- in the worker's thread ---

void SlamNode::handle(const ReadyScan& scan) {
  std::optional<ScanOutcome> outcome;
  std::vector<WeightedPose> likely;
  double match_seconds = 0.0;
  std::string matcher;
  std::vector<std::string> laser_news;
  {
    const std::lock_guard<std::mutex> lock(run_mutex_);
    if (resumed_) {
      take_up(scan.input);
    }
    outcome = run_.process(scan.input);
    if (outcome) {
      match_seconds = run_.last_match_seconds();
      matcher = run_.setup().matcher_name;
      likely = run_.likely_poses();
      if (!outcome->is_of_secondary_laser) {
        newest_scan_ = scan;
        remember_health(scan, *outcome);
      }
      laser_news = run_.laser_news();
      if (!told_of_few_returns_) {
        const std::string few = text_of_few_returns(run_.returns());
        if (!few.empty()) {
          told_of_few_returns_ = true;
          laser_news.push_back(few);
        }
      }
      if (const std::vector<double> sectors = run_.robot_beams();
          !sectors.empty() && !told_of_robot_beams_) {
        told_of_robot_beams_ = true;
        laser_news.push_back(text_of_robot_beams(sectors, run_.setup().engine.scan.masked_angles,
                                                 "set in its configuration "));
      }
    }
  }
  if (!outcome) {
    worker_.use_queue([&](ScanQueue& queue) { queue.leave_out(scan); });
    return;
  }
  if (outcome->left_out > 0) {
    ROS_WARN_STREAM_THROTTLE(10.0, kLeftOut);
  }
  if (outcome->gave_up_part) {
    ROS_WARN_STREAM(kGaveUpPart);
  }
  for (const std::string& news : laser_news) {
    ROS_WARN_STREAM(news);
  }
  if (std::exchange(has_stepped_back_, false) && outcome->state == TrackingState::kLost) {
    poses_.forget();  // odometry has begun anew, and what was sure was by the one before
  }
  poses_.publish(scan, *outcome, match_seconds, matcher);
  if (!outcome->is_of_secondary_laser) {
    poses_.publish_likely(scan, likely);
  }
}

/// Of another drive it is when the robot was switched off between, and its odometry begins anew.
void SlamNode::take_up(const ScanInput& input) {
  const double stamp = input.scan.stamp;
  const double longest_pause = kLongestPause + run_.setup().node.autosave_period;
  const double saved = resumed_->motion.stamp.value_or(0.0);
  const bool same_drive =
      run_.take_up(std::move(*resumed_), stamp, longest_pause, odometry_of(input));
  resumed_.reset();
  ROS_INFO_STREAM("going on with "
                  << resumed_file_ << " as of the scan of " << fixed_text(saved, 3) << " s: "
                  << (same_drive
                          ? "the drive goes on"
                          : "this is another drive, and the robot is searched for in the map")
                  << " with the scan of " << fixed_text(stamp, 3) << " s");
}

void SlamNode::remember_health(const ReadyScan& scan, const ScanOutcome& outcome) {
  recent_.push_back({outcome.stamp, seconds_between(scan.stamp, ros::Time::now()),
                     run_.last_match_seconds(), outcome.match.score, outcome.match.status,
                     outcome.match.unconstrained_directions.size(), outcome.certainty,
                     outcome.evidence.mean, outcome.state});
  if (recent_.size() > kRecentScans) {
    recent_.pop_front();
  }
}

void SlamNode::handle(const TimeJump& jump) {
  if (jump.stopped) {
    ROS_ERROR_STREAM("time has jumped back by " << jump.seconds
                                                << " s; no more scans are used, as time_jump is "
                                                   "'stop'");
    return;
  }
  const std::lock_guard<std::mutex> lock(run_mutex_);
  if (options_.time_jump == "go_on") {
    ROS_WARN_STREAM("time has jumped back by " << jump.seconds
                                               << " s; the map goes on, as time_jump is 'go_on'; "
                                                  "to begin a new one call ~reset");
    run_.step_back();
    has_stepped_back_ = true;
    return;
  }
  ROS_WARN_STREAM("time has jumped back by " << jump.seconds
                                             << " s; starting a new map, as time_jump is 'reset'");
  run_.jump_back();
  resumed_.reset();
  if (initial_map_) {
    run_.apply(*initial_map_);
  }
  forget_map();
}

void SlamNode::handle(const RunEvent& event) {
  std::unique_lock<std::mutex> lock(run_mutex_);
  if (const auto* told = std::get_if<SetPose>(&event); told != nullptr && resumed_) {
    run_.take_up_told(std::move(*resumed_), *told);
    resumed_.reset();
    return;
  }
  run_.apply(event);
  if (gives_up_map(event)) {
    resumed_.reset();
    set_aside_.clear();
    forget_map();
  } else if (std::holds_alternative<Reconfigure>(event)) {
    const SlamSetup setup = run_.setup();
    lock.unlock();
    adopt_options(setup);
  }
}

void SlamNode::handle(const LeftOut& left_out) {
  const std::lock_guard<std::mutex> lock(run_mutex_);
  run_.note_left_out(left_out.stamp, left_out.laser);
}

/// What is kept of it beside the run.
void SlamNode::forget_map() {
  newest_scan_.reset();
  recent_.clear();
  poses_.forget();
}

void SlamNode::adopt_options(const SlamSetup& setup) {
  poses_.set_options(setup.node);
  map_publisher_->set_interval(setup.node.map_update_interval);
  worker_.use_queue(
      [&](ScanQueue& queue) { queue.set_limits(setup.run.max_lag, setup.engine.scan.max_tilt); });
}

// --- from any thread ---

SlamSetup SlamNode::setup() {
  const std::lock_guard<std::mutex> lock(run_mutex_);
  return run_.setup();
}

MapRevision SlamNode::map_revision() {
  const std::lock_guard<std::mutex> lock(run_mutex_);
  return {run_.resets(), run_.key_scans().size(), run_.scans()};
}

/// What loops have moved is rendered while the mapping goes on.
MapSnapshot SlamNode::map_snapshot() {
  std::unique_lock<std::mutex> lock(run_mutex_);
  MapSnapshot snapshot;
  snapshot.revision = {run_.resets(), run_.key_scans().size(), run_.scans()};
  snapshot.stamp = newest_scan_ ? newest_scan_->stamp : ros::Time();
  snapshot.path = run_.path().poses();
  snapshot.odometry_path = run_.odometry_path().poses();
  for (std::vector<StampedPose2>* poses : {&snapshot.path, &snapshot.odometry_path}) {
    for (StampedPose2& pose : *poses) {
      pose.stamp = run_.stamp_by_clock(pose.stamp);
    }
  }
  snapshot.graph = run_.graph();
  if (!run_.is_outdated()) {
    snapshot.occupancy = run_.shown_map();
    return snapshot;
  }
  const PlacedScans keys = run_.key_scans().all();
  const EngineOptions options = run_.setup().engine;
  lock.unlock();
  SlamMap map = rendered(keys, options.map, options.field);
  snapshot.occupancy = shown_occupancy(map, keys, options.map);
  lock.lock();
  run_.take_rendered(std::move(map), keys);
  return snapshot;
}

/// Before anything is saved, so that a loop that is searched for is in all of it, or in none.
void SlamNode::finish_loops() {
  const std::lock_guard<std::mutex> lock(run_mutex_);
  run_.finish();
}

void SlamNode::save_records() {
  std::vector<std::vector<StampedPose2>> trajectories;
  std::vector<TimedEvent> events;
  {
    const std::lock_guard<std::mutex> lock(run_mutex_);
    trajectories = run_.by_clock(run_.trajectory());
    events = run_.events();
  }
  std::vector<FileContents> files;
  if (!trajectory_file_.empty()) {
    for (std::size_t part = 0; part < trajectories.size(); ++part) {
      files.push_back({path_of_part(trajectory_file_, part, trajectories.size()),
                       to_tum(Trajectory(std::move(trajectories[part])))});
    }
  }
  if (!events_file_.empty()) {
    files.push_back({events_file_, to_events_file(events)});
  }
  replace_files(files);
}

}  // namespace matchbox_slam
