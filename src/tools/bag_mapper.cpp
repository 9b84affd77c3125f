#include "tools/bag_mapper.hpp"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>

#include "common/number_text.hpp"
#include "io/g2o.hpp"
#include "io/hough_picture.hpp"
#include "io/map_picture.hpp"
#include "io/tum.hpp"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/map_file.hpp"
#include "matchbox_slam/io/saved_map.hpp"
#include "ros/matcher_loader.hpp"
#include "run/events_file.hpp"
#include "run/slam_run.hpp"
#include "run/start_map.hpp"
#include "tools/fit_record.hpp"
#include "tools/pose_text.hpp"
#include "tools/run_report.hpp"
#include "tools/scan_table.hpp"

namespace matchbox_slam {
namespace {

std::string text_of_loops(const SlamRun& run) {
  const std::size_t closed = run.new_loops().closed;
  return std::to_string(closed) + (closed == 1 ? " loop closed" : " loops closed");
}

/// Before the first scan: somebody says where the robot is, as well as one puts it on a mark.
TimedEvent told_pose(const std::string& text) {
  const std::optional<Pose2> pose = parse_pose(text, 3);
  if (!pose) {
    throw ConfigurationError("--pose: '" + text +
                             "' is not allowed; allowed: X,Y,THETA in metres and radians, such as "
                             "1.5,-2,0.1");
  }
  return {{0, -std::numeric_limits<double>::infinity(), 0}, SetPose{*pose, covariance_on_mark()}};
}

std::vector<TimedEvent> events_of(const MapBagRequest& request,
                                  const LiveConfiguration& configuration) {
  std::vector<TimedEvent> events;
  if (!request.events.empty()) {
    events = read_events_file(request.events, configuration);
  }
  if (request.pose) {
    events.insert(events.begin(), told_pose(*request.pose));
  }
  return events;
}

/// The map that is gone on with may be the only one of the days that it took.
void require_other_folder(const MapBagRequest& request) {
  const std::filesystem::path map = request.map;
  std::error_code unknown;  // of what is not there nothing is lost
  if (request.map.empty() || request.overwrite || map.stem() != "map" ||
      !std::filesystem::equivalent(std::filesystem::absolute(map).parent_path(), request.out,
                                   unknown)) {
    return;
  }
  throw ConfigurationError("--out: '" + request.out + "' is the folder of " + request.map +
                           ", which would be written over; give another --out, or --overwrite");
}

/// Where scans are not inserted there has to be a map to find the robot in.
void require_map(const MapBagRequest& request, const std::vector<TimedEvent>& events,
                 const SlamSetup& setup) {
  const bool may_come = std::any_of(events.begin(), events.end(), [](const TimedEvent& event) {
    return std::holds_alternative<LoadMapFile>(event.event) ||
           std::holds_alternative<Reconfigure>(event.event);
  });
  if (!setup.engine.slam.update_map && request.map.empty() && !may_come) {
    throw ConfigurationError(
        "slam/update_map: false needs a map to find the robot in; give one with --map");
  }
}

/// One run over one bag.
class BagMapping {
 public:
  BagMapping(const MapBagRequest& request, const RunDialog& dialog)
      : out_(request.out),
        map_file_(request.map),
        debug_(request.debug),
        dialog_(telling_loops(dialog)),
        started_(resource_usage()),
        parameters_(gather_parameters(request, request.matcher)),
        configuration_(parameters_, loader_, SetupOf::kProgram),
        scans_(request.recording, dialog_) {
    require_other_folder(request);
    std::vector<TimedEvent> events = events_of(request, configuration_);
    require_map(request, events, configuration_.setup());
    scans_.schedule(std::move(events));
    if (!map_file_.empty()) {
      saved_ = read_engine_state(map_file_, configuration_.setup().engine);
    }
    require_writable_folders(request);
  }

  void map();
  void write();

 private:
  [[nodiscard]] RunDialog telling_loops(RunDialog dialog) const;
  void add_map_and_trajectories();
  [[nodiscard]] Trajectory in_map(const std::vector<StampedPose2>& poses) const;
  [[nodiscard]] std::vector<FileContents> hough_pictures() const;
  void tell(const RunFacts& facts) const;
  void handle(const ReadyScan& scan);
  void handle(const TimeJump& jump);
  void handle(const RunEvent& event);
  void handle(const LeftOut& left_out);
  void begin_scan_table();
  void forget_map();
  void cut_no_returns();
  void go_on_with_saved_map(double stamp);
  void begin_drive_if_new(double stamp);

  const std::string& out_;
  const std::string& map_file_;
  const std::string& debug_;
  const RunDialog dialog_;
  ResourceUsage started_;
  MatcherLoader loader_;
  Parameters parameters_;
  LiveConfiguration configuration_;  ///< that the run starts with
  BagScans scans_;
  std::optional<SlamRun> run_;
  std::optional<EngineState> saved_;  ///< until the first scan comes, or an event before it
  std::vector<std::shared_ptr<const KeyScan>> first_key_scans_;  ///< of the map
  std::optional<FileReplacement> files_;                         ///< that the run writes
  std::optional<ScanTable> scan_table_;                          ///< into one of them
  FitRecord fit_;
  bool told_of_left_out_ = false;
};

/// The same, which says of the progress how many loops were closed, too.
RunDialog BagMapping::telling_loops(RunDialog dialog) const {
  dialog.show_progress = [this, show = std::move(dialog.show_progress)](double fraction,
                                                                        const std::string& text) {
    show(fraction, run_ ? text + ", " + text_of_loops(*run_) : text);
  };
  return dialog;
}

void BagMapping::map() {
  const RunOptions found = scans_.prepare(parameters_, configuration_.setup().run);
  parameters_.set("base_frame", found.base_frame);
  parameters_.set("odom_frame", found.odom_frame);
  parameters_.set("use_odometry", found.use_odometry);
  parameters_.set("odom_topic", found.odom_topic);
  parameters_.set("imu_topic", found.imu_topic);
  parameters_.set("scan_topics", found.scan_topics);
  cut_no_returns();
  run_.emplace(LiveConfiguration(parameters_, loader_));
  begin_scan_table();
  while (const std::optional<ScanQueue::Item> item = scans_.next()) {
    std::visit([this](const auto& one) { handle(one); }, *item);
  }
}

/// A limit set by hand stays; with several lasers one of them alone is no reason to cut all.
void BagMapping::cut_no_returns() {
  const std::optional<double> from = scans_.facts().no_return_from;
  if (!from || parameters_.find("scan/max_range") != nullptr) {
    return;
  }
  const std::string found =
      "where they meet nothing, beams of a laser read its range_max plus noise";
  if (scans_.facts().scan_topics.size() > 1) {
    dialog_.warn(found +
                 ", which draws walls where none are; to cut them give --set scan/max_range=" +
                 fixed_text(*from, 3));
    return;
  }
  parameters_.set("scan/max_range", *from);
  dialog_.warn(found + "; scan/max_range is set to " + fixed_text(*from, 3) +
               " m, from which on they are no return");
}

/// Why a drive is another than that of a saved map.
std::string text_of_another_drive(double stamp, std::optional<double> saved) {
  std::string why;
  if (saved) {
    why = ", as its first scan is " + fixed_text(std::abs(stamp - *saved), 3) +
          (stamp > *saved ? " s newer" : " s older") + " than the last one of the map";
  }
  return "; this is another drive" + why + ": the robot is searched for in the map";
}

void BagMapping::go_on_with_saved_map(double stamp) {
  const std::optional<double> last = saved_->motion.stamp;
  const bool has_key_scans = !saved_->key_scans.empty();
  const bool same_drive = run_->take_up(std::move(*saved_), stamp, kLongestPause);
  saved_.reset();
  dialog_.inform("going on with " + map_file_ +
                 (same_drive ? ", whose drive goes on"
                  : has_key_scans
                      ? text_of_another_drive(stamp, last)
                      : "; the robot is taken to be where start_x, start_y and start_theta say"));
}

/// The robot may have been carried, and its odometry may have begun anew.
void BagMapping::begin_drive_if_new(double stamp) {
  const std::vector<StampedPose2>& told = run_->live_trajectory();
  if (told.empty() || run_->key_scans().empty()) {
    return;
  }
  const double newest = told.back().stamp - run_->clock_offset();
  if (stamp == newest || is_same_drive(stamp, newest) || !scans_.begins_bag(newest, stamp)) {
    return;
  }
  run_->begin_drive(stamp);
  dialog_.inform("another drive begins after " + std::to_string(told.size()) +
                 " scans: the robot is searched for in the map");
}

void BagMapping::handle(const ReadyScan& scan) {
  const double stamp = scan.input.scan.stamp;
  if (saved_) {
    go_on_with_saved_map(stamp);
  } else {
    begin_drive_if_new(stamp);
  }
  std::optional<ScanOutcome> outcome = run_->process(scan.input);
  if (!outcome) {
    scans_.leave_out(scan);
    return;
  }
  fit_.add(*outcome);
  outcome->stamp = stamp;  // not the run's, which goes on where the clock steps back
  scan_table_->add(*outcome);
  if (outcome->inserted && outcome->state == TrackingState::kTracking && !debug_.empty() &&
      first_key_scans_.size() <= kMostHoughPictures) {
    first_key_scans_.push_back(run_->key_scans().all().back().scan);
  }
  if (outcome->left_out > 0 && !told_of_left_out_) {
    dialog_.warn(kLeftOut);
    told_of_left_out_ = true;
  }
  if (outcome->gave_up_part) {
    dialog_.warn(kGaveUpPart);
  }
  for (const std::string& news : run_->laser_news()) {
    dialog_.inform(news);
  }
}

void BagMapping::handle(const RunEvent& event) {
  if (saved_) {
    if (const auto* told = std::get_if<SetPose>(&event)) {
      run_->take_up_told(std::move(*saved_), *told);
      saved_.reset();
      dialog_.inform("going on with " + map_file_ + "; where the robot is in it has been told");
      return;
    }
    go_on_with_saved_map(scans_.stamp_after_event());
  }
  run_->apply(event);
  if (gives_up_map(event)) {
    forget_map();
  } else if (std::holds_alternative<Reconfigure>(event)) {
    scans_.set_limits(run_->setup().run.max_lag, run_->setup().engine.scan.max_tilt);
  }
}

void BagMapping::handle(const LeftOut& left_out) {
  run_->note_left_out(left_out.stamp, left_out.laser);
}

void BagMapping::begin_scan_table() {
  scan_table_.reset();
  files_.emplace();
  scan_table_.emplace(files_->begin(out_ + "/scans.csv"));
}

/// What is kept of it beside the run.
void BagMapping::forget_map() {
  first_key_scans_.clear();
  begin_scan_table();
  fit_ = {};
  scans_.discard_delivered();
}

void BagMapping::handle(const TimeJump& jump) {
  const std::string jumped = text_of(jump, run_->trajectory().size());
  if (jump.stopped) {
    dialog_.warn(jumped + "stopping there, as time_jump is 'stop'");
    scans_.stop();
  } else if (run_->setup().run.time_jump == "go_on") {
    dialog_.warn(jumped + "the map goes on, as time_jump is 'go_on'");
    run_->step_back();
  } else {
    dialog_.warn(jumped + "starting a new map, as time_jump is 'reset'");
    run_->jump_back();
    forget_map();
  }
}

/// Maps apart have frames of their own: drawn over the map they would seem to be in it.
Trajectory BagMapping::in_map(const std::vector<StampedPose2>& poses) const {
  std::vector<StampedPose2> inside;
  std::copy_if(poses.begin(), poses.end(), std::back_inserter(inside),
               [this](const StampedPose2& pose) { return run_->is_in_map(pose.stamp); });
  return Trajectory(std::move(inside));
}

void BagMapping::add_map_and_trajectories() {
  const Trajectory trajectory(run_->trajectory());
  const Trajectory odometry(run_->odometry());
  const PoseGraph& graph = run_->graph();
  const auto add_tum = [&](const std::string& path, const Trajectory& poses,
                           const std::string& of_continued) {
    const std::string comment = map_file_.empty() ? "" : of_continued;
    files_->add(path, [&poses, comment](const ByteSink& sink) {
      if (!comment.empty()) {
        sink("# " + comment + "\n");
      }
      write_tum(poses, sink);
    });
  };
  const auto add_poses = [&](const std::string& name, const std::vector<StampedPose2>& poses,
                             const std::string& of_continued = "") {
    const std::vector<std::vector<StampedPose2>> parts = run_->by_clock(poses);
    for (std::size_t part = 0; part < parts.size(); ++part) {
      add_tum(path_of_part(out_ + name, part, parts.size()), Trajectory(parts[part]), of_continued);
    }
  };
  const std::string of_this_drive =
      "Of this drive alone, in the frame of the map that it went on with: " + map_file_;
  add_poses("/trajectory.tum", run_->trajectory(), of_this_drive);
  add_poses("/trajectory_live.tum", run_->live_trajectory(), of_this_drive);
  add_poses("/odometry.tum", run_->odometry());
  add_tum(out_ + "/key_scans.tum", key_scan_trajectory(run_->key_scans()),
          "Of the whole map, the one that it went on with, too: " + map_file_);
  files_->add(out_ + "/graph.g2o", [&graph](const ByteSink& sink) { write_g2o(graph, sink); });
  const OccupancyGrid shown = run_->shown_map();
  for (const FileContents& file :
       map_files(out_ + "/map", make_map_image(shown), map_format(run_->setup().run))) {
    files_->add(file);
  }
  files_->add(
      {out_ + "/map.png",
       draw_map(shown, in_map(run_->trajectory()), in_map(run_->odometry()), graph).to_png()});
  files_->add(out_ + "/map.slam",
              [this](const ByteSink& sink) { write_saved_map(run_->snapshot(), sink); });
}

/// What the Hough matcher sees of each of the first key scans and its predecessor.
std::vector<FileContents> BagMapping::hough_pictures() const {
  std::vector<FileContents> pictures;
  for (std::size_t i = 1; i < first_key_scans_.size(); ++i) {
    pictures.push_back(hough_picture_file(debug_, i - 1, *first_key_scans_[i - 1]->points(),
                                          *first_key_scans_[i]->points(),
                                          run_->setup().hough.alignment));
  }
  return pictures;
}

void BagMapping::tell(const RunFacts& facts) const {
  const ScanAccount& account = scans_.account();
  dialog_.inform(std::to_string(account.delivered) + " of " + std::to_string(account.received) +
                 " scans used, " + std::to_string(fit_.matched()) + " matched, " +
                 text_of_loops(*run_) + ", in " + seconds_text(facts.used.wall_seconds) + ", " +
                 seconds_text(facts.bag.seconds) + " of bag; results in " + out_);
  for (const auto& [number, laser] : run_->secondary_lasers()) {
    (laser.is_used ? dialog_.inform : dialog_.warn)(text_of(laser, run_->scan_topic(number)));
  }
  if (run_->parts_apart() > 0) {
    dialog_.warn("maps of a lost robot that were found nowhere in the map: " +
                 std::to_string(run_->parts_apart()) + "; map.slam alone holds them");
    const std::size_t all = run_->trajectory().size();
    const std::size_t apart = all - in_map(run_->trajectory()).size();
    if (apart > 0) {
      dialog_.warn(std::to_string(apart) + " of " + std::to_string(all) +
                   " poses are in such maps, each in a frame of its own that has nothing to do "
                   "with the map's: map.png leaves them out, trajectory.tum has them; scans.csv "
                   "says lost for each. Two drives that never meet are better mapped one by one");
    }
  }
  if (const std::size_t steps = run_->clock_steps(); steps > 0) {
    dialog_.warn("the clock has stepped back: poses of before the first step are in " + out_ +
                 "/trajectory.1.tum" +
                 (steps > 1 ? ", the next in trajectory.2.tum and so on" : "") +
                 ", those since the last one in trajectory.tum; likewise the other .tum files but "
                 "key_scans.tum");
  }
  for (const std::string& warning : fit_.warnings()) {
    dialog_.warn(warning);
  }
  if (const std::vector<double> sectors = run_->robot_beams(); !sectors.empty()) {
    dialog_.warn(
        text_of_robot_beams(sectors, run_->setup().engine.scan.masked_angles, "give --set "));
  }
  if (const std::string few = text_of_few_returns(run_->returns()); !few.empty()) {
    dialog_.warn(few);
  }
  if (scans_.events_left() > 0) {
    dialog_.warn(std::to_string(scans_.events_left()) +
                 " events have no scan after them and took no effect");
  }
  if (facts.bag.interrupted) {
    dialog_.warn(
        "interrupted: the results cover the bag up to there; for the rest of it give the same "
        "options but another --out, no --pose and no --events, and --start " +
        fixed_text(scans_.start_of_rest(), 3) + " --map " + out_ + "/map.slam");
  }
}

void BagMapping::write() {
  if (run_->trajectory().empty()) {
    scans_.throw_nothing_used();
  }
  run_->finish();
  scan_table_->finish();
  add_map_and_trajectories();
  const ResourceUsage now = resource_usage();
  const RunFacts facts{scans_.facts(),
                       run_->resets(),
                       {now.wall_seconds - started_.wall_seconds,
                        now.cpu_seconds - started_.cpu_seconds, now.peak_memory}};
  files_->add({out_ + "/report.json", to_json(facts, scans_.account(), *run_)});
  files_->finish();
  replace_files(hough_pictures());
  tell(facts);
  if (!facts.bag.damage.empty()) {
    throw BagError(facts.bag.damage + "; the results cover the part before");
  }
}

}  // namespace

void map_bag(const MapBagRequest& request, const RunDialog& dialog) {
  BagMapping mapping(request, dialog);
  mapping.map();
  mapping.write();
}

}  // namespace matchbox_slam
