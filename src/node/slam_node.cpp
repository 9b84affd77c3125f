#include "node/slam_node.hpp"

#include <fmt/core.h>

#include <filesystem>
#include <utility>
#include <variant>

#include "io/tum.hpp"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/saved_map.hpp"
#include "matching/rendered_map.hpp"
#include "node/ros_parameters.hpp"
#include "ros/message_conversion.hpp"
#include "ros/queue_settings.hpp"
#include "run/events_file.hpp"
#include "run/frames.hpp"
#include "run/shown_map.hpp"

namespace matchbox_slam {

namespace {

constexpr std::size_t kRecentScans = 200;

LiveConfiguration read_configuration(const ros::NodeHandle& private_node,
                                     const MatcherLoader& loader) {
  LiveConfiguration configuration =
      from_ros_parameters(private_node, [&](const Parameters& parameters) {
        LiveConfiguration read(parameters, loader);
        check_frames(read.setup().run);
        return read;
      });
  const SlamNodeOptions& options = configuration.setup().node;
  for (const std::string& file : {options.trajectory_file, options.events_file}) {
    if (!file.empty()) {
      require_writable_folder(std::filesystem::path(absolute_path(file)).parent_path().string());
    }
  }
  if (options.autosave_period > 0.0) {
    require_writable_folder(
        std::filesystem::path(absolute_path(options.map_file)).parent_path().string());
  }
  return configuration;
}

ScanQueueSettings node_queue_settings(const SlamSetup& setup) {
  return queue_settings(setup.run, setup.engine.scan, setup.timing,
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
  return fmt::format(
      "{}; resume is true, so it goes on with that map or not at all: move the file away to begin "
      "without it, mv {} {}.old{}",
      error.what(), path, path,
      std::filesystem::exists(changes) ? fmt::format(", and what has changed since, mv {} {}",
                                                     changes, path_of_changes(path + ".old"))
                                       : "");
}

RunDialog log_dialog() {
  return {[](const std::string& line) { ROS_INFO_STREAM(line); },
          [](const std::string& line) { ROS_WARN_STREAM(line); },
          [](double /*fraction*/, const std::string& /*text*/) {},
          [] { return ros::isShuttingDown(); }};
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
      log_(log_dialog()),
      session_([&] {
        LiveConfiguration configuration = read_configuration(private_node_, loader_);
        const RunRecords records = records_for(configuration.setup().node);
        return SlamSession(std::move(configuration), records, log_.dialog(),
                           "set in its configuration ");
      }()),
      worker_(session_.setup().engine.slam.update_map ? "mapping" : "localising",
              node_queue_settings(session_.setup()),
              [this](const ScanQueue::Item& item) {
                std::visit([this](const auto& one) { handle(one); }, item);
              }),
      options_(session_.setup().run),
      trajectory_file_(absolute_path(session_.setup().node.trajectory_file)),
      events_file_(absolute_path(session_.setup().node.events_file)),
      poses_(node_, session_.setup()),
      diagnostic_updater_(node_, private_node_, private_node_.getNamespace()) {
  const SlamSetup& setup = session_.setup();
  begin_map();
  log_.tell();
  map_publisher_ = std::make_unique<MapPublisher>(
      node_, options_.map_frame, setup.node.map_update_interval, [this] { return map_revision(); },
      [this] { return map_snapshot(); }, [this] { return path_snapshot(); });
  other_maps_ = std::make_unique<OtherMaps>([this] { return own_map(); },
                                            [this](std::shared_ptr<const FoundMap> found) {
                                              const std::lock_guard<std::mutex> lock(run_mutex_);
                                              session_.expect_map(std::move(found));
                                            },
                                            log_dialog());
  start_services();
  initial_pose_subscriber_ = node_.subscribe("initialpose", 10, &SlamNode::on_initial_pose, this,
                                             ros::TransportHints().tcpNoDelay());
  ROS_INFO_STREAM((setup.engine.slam.update_map ? "mapping with " : "localising with ")
                  << setup.matcher_name << ": scans from " << join(input_->topics()) << ", frames "
                  << options_.map_frame << ", "
                  << (options_.use_odometry ? options_.odom_frame + ", " : "")
                  << options_.base_frame
                  << (options_.odom_topic.empty() ? "" : ", odometry from " + options_.odom_topic)
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
  other_maps_->give_up();  // it may take a while to end; the map is saved meanwhile
  diagnostic_timer_.stop();
  poses_.stop();
  map_publisher_.reset();
  const bool saves_map = autosave_ != nullptr;
  autosave_.reset();
  log_failure([this] { finish_loops(); });
  log_failure([this] { save_records(); });
  if (!saves_map) {
    tell_unsaved();
  } else if (map_revision().scans > 0) {
    // Always, as a loop may have been closed since, which no scan tells.
    log_failure([this] { static_cast<void>(save_map_files()); });
  }
  other_maps_.reset();
}

/// Goes on with a saved map where there is one to go on with.
void SlamNode::begin_map() {
  const SlamSetup& setup = session_.setup();
  std::optional<LoadMapFile> initial;
  if (!setup.node.initial_map.empty()) {
    initial = read_load(setup.node.initial_map);
  }
  const std::string saved = absolute_path(setup.node.map_file) + ".slam";
  const bool goes_on = setup.node.resume && std::filesystem::exists(saved);
  if (goes_on) {
    try {
      session_.go_on_with({read_resumed(saved), saved, true});
      saver_.begin_from(saved, revision_of(run()));
    } catch (const ConfigurationError& error) {
      throw ConfigurationError(no_new_map(error, saved));
    } catch (const DamagedFile& error) {
      if (!setup.engine.slam.update_map) {
        throw FileError(no_new_map(error, saved));
      }
      set_map_aside(absolute_path(setup.node.map_file), error.what());
    } catch (const FileError& error) {
      throw FileError(no_new_map(error, saved));
    }
  }
  if (initial) {
    session_.begin_with(std::move(*initial));
  } else if (!goes_on && !setup.engine.slam.update_map) {
    ROS_WARN("there is no map to localise in: give initial_map, or call ~load_map");
  }
}

/// Of a map whose changes cannot be read the one before is not lost.
EngineState SlamNode::read_resumed(const std::string& file) {
  const EngineOptions& options = session_.setup().engine;
  try {
    return read_engine_state(file, options);
  } catch (const DamagedChanges& error) {
    const std::string folder = set_aside({path_of_changes(file)}, file + ".damaged");
    ROS_ERROR_STREAM(error.what() << "; it is in " << folder << " now");
    return read_engine_state(file, options);
  }
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
    throw FileError(
        fmt::format("{}; to begin a new map it has to be moved away: {}", why, error.what()));
  }
  ROS_ERROR_STREAM(why << "; a new map begins. That one and its images are in " << set_aside_
                       << " now; ~load_map goes on with an older copy, if there is one");
}

/// The map has begun with such beams; map_bag, which reads the recording twice, cuts them before.
void SlamNode::cut_no_returns(double from) {
  std::vector<RunEvent> events;
  {
    const LoggingLock lock(run_mutex_, log_);
    events = session_.cut_no_returns(from, true);
  }
  if (events.empty()) {
    return;
  }
  for (RunEvent& event : events) {
    worker_.post(std::move(event));
  }
  if (setup().node.resume && ros::master::check()) {  // without a master it would wait for one
    private_node_.setParam("scan/max_range", from);  // else it would be drawn again after a respawn
  }
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
  bool has_stepped_back = false;
  {
    const LoggingLock lock(run_mutex_, log_);
    const std::size_t clock_steps = run().clock_steps();
    outcome = session_.process(scan.input);
    if (outcome) {
      has_stepped_back = run().clock_steps() > clock_steps;
      match_seconds = run().last_match_seconds();
      matcher = session_.setup().matcher_name;
      likely = run().likely_poses();
      if (!outcome->is_of_secondary_laser) {
        newest_scan_ = scan;
        remember_health(scan, *outcome);
      }
      session_.advise();
    }
  }
  if (!outcome) {
    worker_.use_queue([&](ScanQueue& queue) { queue.leave_out(scan); });
    return;
  }
  if (has_stepped_back && outcome->state == TrackingState::kLost) {
    poses_.forget();  // odometry has begun anew, and what was sure was by the one before
  }
  poses_.publish(scan, *outcome, match_seconds, matcher);
  if (!outcome->is_of_secondary_laser) {
    poses_.publish_likely(scan, likely);
  }
}

void SlamNode::remember_health(const ReadyScan& scan, const ScanOutcome& outcome) {
  recent_.push_back({outcome.stamp, seconds_between(scan.stamp, ros::Time::now()),
                     run().last_match_seconds(), outcome.match.score, outcome.match.status,
                     outcome.match.unconstrained_directions.size(), outcome.certainty,
                     outcome.evidence.mean, outcome.state});
  if (recent_.size() > kRecentScans) {
    recent_.pop_front();
  }
}

void SlamNode::handle(const TimeJump& jump) {
  const LoggingLock lock(run_mutex_, log_);
  if (session_.jump_back(text_of(jump, run().scans()), jump.stopped)) {
    forget_map();
  }
  if (jump.stopped) {
    const std::string name = private_node_.getNamespace();
    log_.dialog().warn(
        fmt::format("no scan is used any more, and the map stays as it is: rosservice call "
                    "{}/save_map saves it, rosservice call {}/reset forgets it and begins anew; "
                    "with time_jump 'go_on' or 'reset' a node goes on by itself",
                    name, name));
  }
}

void SlamNode::handle(const RunEvent& event) {
  LoggingLock lock(run_mutex_, log_);
  session_.apply(event);
  if (gives_up_map(event)) {
    set_aside_.clear();
    forget_map();
  } else if (std::holds_alternative<Reconfigure>(event)) {
    const SlamSetup setup = session_.setup();
    lock.unlock();
    adopt_options(setup);
  }
}

void SlamNode::handle(const LeftOut& left_out) {
  const LoggingLock lock(run_mutex_, log_);
  session_.note_left_out(left_out.stamp, left_out.laser);
}

/// What is kept of it beside the run.
void SlamNode::forget_map() {
  newest_scan_.reset();
  recent_.clear();
  poses_.forget();
  other_maps_->clear();
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
  return session_.setup();
}

OwnMap SlamNode::own_map() {
  const std::lock_guard<std::mutex> lock(run_mutex_);
  const LoopState& loops = run().loop_state();
  return {run().key_scans(),
          {loops.edges, loops.nodes, loops.loops, 0.0, loops.tries},
          session_.setup().engine};
}

MapRevision SlamNode::map_revision() {
  const std::lock_guard<std::mutex> lock(run_mutex_);
  return revision_of(run());
}

/// What loops have moved is rendered while the mapping goes on.
MapSnapshot SlamNode::map_snapshot() {
  std::unique_lock<std::mutex> lock(run_mutex_);
  MapSnapshot snapshot;
  snapshot.revision = revision_of(run());
  snapshot.stamp = newest_scan_ ? newest_scan_->stamp : ros::Time();
  snapshot.graph = run().graph();
  if (!run().is_outdated()) {
    snapshot.occupancy = run().shown_map();
    return snapshot;
  }
  const PlacedScans keys = run().key_scans().all();
  const EngineOptions options = session_.setup().engine;
  lock.unlock();
  SlamMap map = rendered(keys, options.map, options.field, MapUse::kShown);
  snapshot.occupancy = shown_occupancy(map, keys, options.map);
  lock.lock();
  session_.take_rendered(std::move(map), keys);
  return snapshot;
}

PathSnapshot SlamNode::path_snapshot() {
  const std::lock_guard<std::mutex> lock(run_mutex_);
  PathSnapshot snapshot;
  snapshot.revision = revision_of(run());
  snapshot.stamp = newest_scan_ ? newest_scan_->stamp : ros::Time();
  snapshot.path = run().path().poses();
  snapshot.odometry_path = run().odometry_path().poses();
  for (std::vector<StampedPose2>* poses : {&snapshot.path, &snapshot.odometry_path}) {
    for (StampedPose2& pose : *poses) {
      pose.stamp = run().stamp_by_clock(pose.stamp);
    }
  }
  return snapshot;
}

/// Before anything is saved, so that a loop that is searched for is in all of it, or in none.
void SlamNode::finish_loops() {
  const LoggingLock lock(run_mutex_, log_);
  session_.finish();
}

void SlamNode::save_records() {
  std::vector<std::vector<StampedPose2>> trajectories;
  std::vector<TimedEvent> events;
  {
    const std::lock_guard<std::mutex> lock(run_mutex_);
    trajectories = run().by_clock(run().trajectory());
    events = run().events();
  }
  FileReplacement files;
  if (!trajectory_file_.empty()) {
    add_tum_parts(trajectory_file_, trajectories, "", files);
  }
  if (!events_file_.empty()) {
    files.add({events_file_, to_events_file(events)});
  }
  files.finish();
}

std::vector<OptionDescription> describe_node_options() {
  std::vector<OptionDescription> options = describe_options(RunOptions{});
  const std::vector<OptionDescription> own = describe_options(SlamNodeOptions{});
  options.insert(options.end(), own.begin(), own.end());
  return options;
}

}  // namespace matchbox_slam
