#include "tools/bag_mapper.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>

#include "io/g2o.hpp"
#include "io/hough_picture.hpp"
#include "io/map_changes.hpp"
#include "io/map_picture.hpp"
#include "io/tum.hpp"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/saved_map.hpp"
#include "ros/matcher_loader.hpp"
#include "run/events_file.hpp"
#include "run/map_saver.hpp"
#include "run/slam_session.hpp"
#include "run/start_map.hpp"
#include "tools/drive_record.hpp"
#include "tools/fit_record.hpp"
#include "tools/map_movie.hpp"
#include "tools/movie_file.hpp"
#include "tools/out_folder.hpp"
#include "tools/pose_text.hpp"
#include "tools/report_page.hpp"
#include "tools/run_report.hpp"
#include "tools/scan_table.hpp"

namespace matchbox_slam {
namespace {

std::string text_of_loops(const SlamRun& run) {
  const std::size_t closed = run.new_loops().closed;
  return fmt::format("{} {} closed", closed, closed == 1 ? "loop" : "loops");
}

/// Before the first scan: somebody says where the robot is, as well as one puts it on a mark.
TimedEvent given_pose(const std::string& text) {
  const std::optional<Pose2> pose = parse_pose(text, 3);
  if (!pose) {
    throw ConfigurationError(fmt::format(
        "--pose: '{}' is not allowed; allowed: X,Y,THETA in metres and radians, such as 1.5,-2,0.1",
        text));
  }
  return {{0, -std::numeric_limits<double>::infinity(), 0},
          SetPose{*pose, initial_pose_covariance()}};
}

std::vector<TimedEvent> events_of(const MapBagRequest& request,
                                  const LiveConfiguration& configuration) {
  std::vector<TimedEvent> events;
  if (!request.events.empty()) {
    events = read_events_file(request.events, configuration);
  }
  if (request.pose) {
    events.insert(events.begin(), given_pose(*request.pose));
  }
  return events;
}

std::optional<MovieFile> movie_file_of(const MapBagRequest& request) {
  return request.movie ? std::make_optional<MovieFile>(*request.movie) : std::nullopt;
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
        movie_file_(movie_file_of(request)),
        dialog_(telling_loops(dialog)),
        started_(resource_usage()),
        parameters_(gather_parameters(request, request.matcher)),
        configuration_(parameters_, loader_, SetupOf::kProgram),
        scans_(request.recording, dialog_) {
    if (!request.overwrite && std::filesystem::path(request.map).stem() == "map") {
      require_other_folder(request.map, request.out);
    }
    std::vector<TimedEvent> events = events_of(request, configuration_);
    require_map(request, events, configuration_.setup());
    scans_.schedule(std::move(events));
    if (!map_file_.empty()) {
      saved_ = read_engine_state(map_file_, configuration_.setup().engine);
    }
    require_writable_folders(request);
    out_lock_.emplace(request.out);
    if (movie_file_) {
      movie_file_->require_writable();
    }
  }

  void map();
  void write();

 private:
  [[nodiscard]] RunDialog telling_loops(RunDialog dialog) const;
  [[nodiscard]] const SlamRun& run() const { return session_->run(); }
  void begin_session();
  void add_map_and_trajectories();
  void add_images(const OccupancyGrid& shown);
  void write_files();
  void remove_leftovers() const;
  [[nodiscard]] std::vector<FileContents> hough_pictures() const;
  void tell(const RunFacts& facts);
  void tell_rest() const;
  void handle(const ReadyScan& scan);
  void handle(const TimeJump& jump);
  void handle(const RunEvent& event);
  void handle(const LeftOut& left_out);
  void begin_scan_table();
  void forget_map();
  void begin_drive_if_new(double stamp);

  const std::string& out_;
  std::optional<FolderLock> out_lock_;
  const std::string& map_file_;
  const std::string& debug_;
  const std::optional<MovieFile> movie_file_;
  const RunDialog dialog_;
  ResourceUsage started_;
  MatcherLoader loader_;
  Parameters parameters_;
  LiveConfiguration configuration_;  ///< that the session starts with
  BagScans scans_;
  std::optional<EngineState> saved_;  ///< until the session goes on with it
  std::optional<SlamSession> session_;
  std::vector<std::shared_ptr<const KeyScan>> first_key_scans_;  ///< of the map
  std::optional<FileReplacement> files_;                         ///< that the run writes
  std::optional<ScanTable> scan_table_;                          ///< into one of them
  FitRecord fit_;
  DriveRecord drive_;
  MapMovie movie_;
  PagePicture picture_;  ///< of the map, once it is drawn
};

/// The same, which says of the progress how many loops were closed, too.
RunDialog BagMapping::telling_loops(RunDialog dialog) const {
  dialog.show_progress = [this, show = std::move(dialog.show_progress)](double fraction,
                                                                        const std::string& text) {
    show(fraction, session_ ? fmt::format("{}, {}", text, text_of_loops(run())) : text);
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
  begin_session();
  begin_scan_table();
  while (const std::optional<ScanQueue::Item> item = scans_.next()) {
    std::visit([this](const auto& one) { handle(one); }, *item);
  }
}

void BagMapping::begin_session() {
  session_.emplace(LiveConfiguration(parameters_, loader_), RunRecords::kAll, dialog_,
                   "give --set ");
  if (const std::optional<double> from = scans_.facts().no_return_from) {
    for (const RunEvent& event : session_->cut_no_returns(*from, false)) {
      session_->apply(event);
    }
  }
  if (saved_) {
    session_->go_on_with({*std::exchange(saved_, std::nullopt), map_file_});
  }
}

/// The robot may have been carried, and its odometry may have begun anew.
void BagMapping::begin_drive_if_new(double stamp) {
  const std::vector<StampedPose2>& told = run().live_trajectory();
  if (told.empty() || run().key_scans().empty()) {
    return;
  }
  const double newest = told.back().stamp - run().clock_offset();
  if (stamp == newest || is_same_drive(stamp, newest) || !scans_.begins_bag(newest, stamp)) {
    return;
  }
  session_->begin_drive(stamp);
}

void BagMapping::handle(const ReadyScan& scan) {
  const double stamp = scan.input.scan.stamp;
  begin_drive_if_new(stamp);
  std::optional<ScanOutcome> outcome = session_->process(scan.input);
  if (!outcome) {
    scans_.leave_out(scan);
    return;
  }
  fit_.add(*outcome);
  drive_.add(*outcome, stamp);
  if (movie_file_) {
    movie_.add(*outcome, run());
  }
  outcome->stamp = stamp;  // not the run's, which goes on where the clock steps back
  scan_table_->add(*outcome);
  if (outcome->inserted && outcome->state == TrackingState::kTracking && !debug_.empty() &&
      first_key_scans_.size() <= kMostHoughPictures) {
    first_key_scans_.push_back(run().key_scans().all().back().scan);
  }
}

void BagMapping::handle(const RunEvent& event) {
  session_->apply(event);
  if (gives_up_map(event)) {
    forget_map();
  } else if (std::holds_alternative<Reconfigure>(event)) {
    scans_.set_limits(run().setup().run.max_lag, run().setup().engine.scan.max_tilt);
  }
}

void BagMapping::handle(const LeftOut& left_out) {
  session_->note_left_out(left_out.stamp, left_out.laser);
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
  drive_ = {};
  movie_ = {};
  scans_.discard_delivered();
}

void BagMapping::handle(const TimeJump& jump) {
  if (session_->jump_back(text_of(jump, run().scans()), jump.stopped)) {
    forget_map();
  }
}

void BagMapping::add_map_and_trajectories() {
  const auto comment = [this](const std::string& of_continued) {
    return map_file_.empty() ? "" : of_continued + map_file_;
  };
  const std::string of_this_drive =
      comment("Of this drive alone, in the frame of the map that it went on with: ");
  const auto add_poses = [this](const std::string& name, const std::vector<StampedPose2>& poses,
                                const std::string& of) {
    add_tum_parts(out_ + name, run().by_clock(poses), of, *files_);
  };
  add_poses("/trajectory.tum", run().trajectory(), of_this_drive);
  add_poses("/trajectory_live.tum", run().live_trajectory(), of_this_drive);
  add_poses("/odometry.tum", run().odometry(), "");
  add_tum_parts(out_ + "/key_scans.tum", {key_scan_trajectory(run().key_scans()).poses()},
                comment("Of the whole map, the one that it went on with, too: "), *files_);
  files_->add(out_ + "/graph.g2o",
              [this](const ByteSink& sink) { write_g2o(run().graph(), sink); });
  add_images(run().shown_map());
  files_->add(out_ + "/map.slam",
              [this](const ByteSink& sink) { write_saved_map(run().snapshot(), sink); });
}

void BagMapping::add_images(const OccupancyGrid& shown) {
  const Trajectory trajectory(run().in_map(run().trajectory()));
  const Picture picture =
      draw_map(shown, trajectory, Trajectory(run().in_map(run().odometry())), run().graph());
  picture_ = {picture.to_png(), picture.width(), picture.height(),
              frame_of_picture(shown, trajectory)};
  matchbox_slam::add_images(out_ + "/map", shown, picture_.png, map_format(run().setup().run),
                            *files_);
}

/// What the Hough matcher sees of each of the first key scans and its predecessor.
std::vector<FileContents> BagMapping::hough_pictures() const {
  std::vector<FileContents> pictures;
  for (std::size_t i = 1; i < first_key_scans_.size(); ++i) {
    pictures.push_back(hough_picture_file(debug_, i - 1, *first_key_scans_[i - 1]->points(),
                                          *first_key_scans_[i]->points(),
                                          run().setup().hough.alignment));
  }
  return pictures;
}

void BagMapping::tell(const RunFacts& facts) {
  const ScanAccount& account = scans_.account();
  const std::string lost =
      fit_.lost() > 0 ? fmt::format(", the robot lost at {} of these", fit_.lost()) : "";
  dialog_.inform(
      fmt::format("{} of {} scans used{}, {} matched, {}, in {}, {} of bag; results in {}",
                  account.delivered, account.received, lost, fit_.matched(), text_of_loops(run()),
                  seconds_text(facts.used.wall_seconds), seconds_text(facts.bag.seconds), out_));
  for (const auto& [number, laser] : run().secondary_lasers()) {
    (laser.is_used ? dialog_.inform : dialog_.warn)(text_of(laser, run().scan_topic(number)));
  }
  if (run().disconnected_components() > 0) {
    dialog_.warn(fmt::format(
        "maps of a lost robot that were found nowhere in the map: {}; map.slam alone holds them",
        run().disconnected_components()));
    const std::size_t all = run().trajectory().size();
    const std::size_t apart = all - run().in_map(run().trajectory()).size();
    if (apart > 0) {
      dialog_.warn(fmt::format(
          "{} of {} poses are in such maps, each in a frame of its own that has nothing to do with "
          "the map's: map.png leaves them out, trajectory.tum has them; scans.csv says lost for "
          "each. Two drives that never meet are better mapped one by one",
          apart, all));
    }
  }
  if (const std::size_t steps = run().clock_steps(); steps > 0) {
    dialog_.warn(
        fmt::format("the clock has stepped back: poses of before the first step are in "
                    "{}/trajectory.1.tum{}, those since the last one in trajectory.tum; likewise "
                    "the other .tum files but key_scans.tum",
                    out_, steps > 1 ? ", the next in trajectory.2.tum and so on" : ""));
  }
  if (!map_file_.empty() && fit_.is_mostly_lost()) {
    dialog_.warn(fmt::format(
        "the robot was hardly ever found in {}: is it of this building? --pose says where in it "
        "the recording begins",
        map_file_));
  }
  const bool is_by_tf = run().setup().run.laser_pose.empty();
  for (const std::string& warning : fit_.warnings(is_by_tf ? "in tf" : "by --laser-pose")) {
    dialog_.warn(warning);
  }
  session_->advise();
  if (scans_.events_left() > 0) {
    dialog_.warn(
        fmt::format("{} events have no scan after them and took no effect", scans_.events_left()));
  }
  if (facts.bag.interrupted) {
    tell_rest();
  }
}

void BagMapping::tell_rest() const {
  const BagPeriod rest = scans_.rest();
  if (rest.duration <= 0.0) {
    dialog_.warn("interrupted at the end of what was asked for; nothing is left of it");
    return;
  }
  const std::string duration =
      std::isfinite(rest.duration) ? fmt::format(" --duration {:.3f}", rest.duration) : "";
  dialog_.warn(fmt::format(
      "interrupted: the results cover the bag up to there; for the rest of it give the same "
      "options "
      "but another --out, no --pose and no --events, and --start {:.3f}{} --map {}/map.slam",
      rest.start, duration, out_));
}

/// Of an earlier run into the folder: what this one has none of would be taken for its own.
void BagMapping::remove_leftovers() const {
  const bool is_png = map_format(run().setup().run) == MapFormat::kPng;
  std::error_code ignored;
  for (const std::string& name :
       {path_of_changes("map.slam"), std::string(is_png ? "map.pgm" : "map.occupancy.png")}) {
    std::filesystem::remove(fmt::format("{}/{}", out_, name), ignored);
  }
  for (const char* name : {"trajectory", "trajectory_live", "odometry"}) {
    for (std::size_t part = run().clock_steps() + 1;
         std::filesystem::remove(fmt::format("{}/{}.{}.tum", out_, name, part), ignored); ++part) {
    }
  }
}

void BagMapping::write_files() {
  if (!movie_file_) {
    files_->finish();
    return;
  }
  const std::vector<MovieFrame>& frames = movie_.finish(run());
  movie_file_->add(frames, run().setup().engine.map.resolution, *files_);
  files_->finish();
  movie_file_->remove_older(frames);
}

void BagMapping::write() {
  if (run().trajectory().empty()) {
    scans_.throw_nothing_used();
  }
  session_->finish();
  scan_table_->finish();
  add_map_and_trajectories();
  const ResourceUsage now = resource_usage();
  const RunFacts facts{scans_.facts(),
                       run().resets(),
                       {now.wall_seconds - started_.wall_seconds,
                        now.cpu_seconds - started_.cpu_seconds, now.peak_memory}};
  const std::string report = to_json(facts, scans_.account(), run());
  files_->add({out_ + "/report.json", report});
  files_->add({out_ + "/report.html", report_page(report, drive_.points(run()), picture_)});
  write_files();
  remove_leftovers();
  replace_files(hough_pictures());
  tell(facts);
  if (!facts.bag.damage.empty()) {
    throw BagError(fmt::format("{}; the results cover the part before, {} scans in {}",
                               facts.bag.damage, scans_.account().delivered,
                               seconds_text(facts.bag.seconds)));
  }
}

}  // namespace

void map_bag(const MapBagRequest& request, const RunDialog& dialog) {
  const EmptyFolderRemoval removal(request.out);
  BagMapping mapping(request, dialog);
  mapping.map();
  mapping.write();
}

}  // namespace matchbox_slam
