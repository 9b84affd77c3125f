#pragma once

#include <cstddef>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "geometry/thinned_path.hpp"
#include "geometry/trajectory.hpp"
#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/sensor/scan_input.hpp"
#include "matchbox_slam/slam/slam_engine.hpp"
#include "run/laser_text.hpp"
#include "run/live_configuration.hpp"
#include "run/run_event.hpp"
#include "run/shown_map.hpp"
#include "run/timed_matcher.hpp"
#include "sensor/return_count.hpp"
#include "sensor/robot_beams.hpp"

namespace matchbox_slam {

/// Loops of a map, counted.
struct LoopCount {
  std::size_t found = 0;   ///< of LoopState::loops, refused ones, too
  std::size_t closed = 0;  ///< of these
  std::size_t tries = 0;
};

/// What a run keeps of its past: everything, or only what does not grow with time.
enum class RunRecords { kAll, kRecent };

/// The engine at work, and a record of what it did since its start or last reset. The node and
/// map_bag both run this, so that the same scans with the same events between them yield the same.
class SlamRun {
 public:
  explicit SlamRun(LiveConfiguration configuration, RunRecords records = RunRecords::kAll);

  /// Processes the next scan of the queue. None: the run is paused, and the scan is left out. The
  /// outcome's stamp is the run's; see clock_offset.
  std::optional<ScanOutcome> process(const ScanInput& input);

  /// After the last scan: closes the loop that a search under way may find.
  void finish() { correct_by(engine_->finish_loops()); }

  /// As of SlamEngine. No event: `events` does not repeat it.
  void expect_map(std::shared_ptr<const FoundMap> found) { engine_->expect_map(std::move(found)); }

  /// Takes effect for the next scan. Throws ConfigurationError or std::runtime_error when the event
  /// is not possible, telling why; then nothing has changed.
  void apply(const RunEvent& event);

  /// Before the first scan: goes on from there, as SlamEngine::start_from.
  void start_from(EngineState start) {
    engine_->start_from(std::move(start));
    brought_loops_ = all_loops();
  }

  /// Before the first scan, which is of this stamp [s]: goes on from a saved map. As if nothing had
  /// been between, where that scan is of the same drive. Else the robot may be anywhere, and is
  /// searched for; an image holds nothing to find it by. Returns whether it is the same drive.
  /// @param odom_from_base  at that scan, where odometry may have gone on meanwhile: then it is the
  ///                        same drive, too.
  bool take_up(EngineState saved, double stamp, double longest_pause,
               const std::optional<Pose2>& odom_from_base = {});

  /// Before the first scan: goes on from a saved map, in which somebody says where the robot is.
  /// Odometry and stamps of the drive before say nothing then.
  void take_up_at(EngineState saved, const SetPose& told);

  /// The next scan, of this stamp [s], is of another drive: where the robot is has to be found.
  void begin_drive(double stamp);

  /// A scan never came to be processed, as there was no time for it: an event of those that
  /// `events` lists.
  void note_left_out(double stamp, int laser);

  /// Time has jumped back: stamps begin anew. The map goes on. Where the robot is, odometry tells
  /// if it went on, or somebody who has told it since the last scan; else it is searched for.
  void step_back();

  /// The same, but map and poses are forgotten.
  void jump_back();

  [[nodiscard]] const SlamSetup& setup() const { return configuration_.setup(); }
  [[nodiscard]] const LiveConfiguration& configuration() const { return configuration_; }

  /// As SlamEngine::snapshot; its motion is by the clock of the newest scan.
  [[nodiscard]] EngineState snapshot() const;

  /// Time of the newest scan's match [s]; 0 when it was not matched.
  [[nodiscard]] double last_match_seconds() const { return last_match_seconds_; }

  /// These as of SlamEngine.
  [[nodiscard]] const SlamMap& drawn_map() const { return engine_->drawn_map(); }
  /// As `shown_occupancy` of run/shown_map.hpp.
  [[nodiscard]] OccupancyGrid shown_map() const {
    return shown_occupancy(drawn_map(), key_scans().all(), setup().engine.map);
  }
  [[nodiscard]] bool is_outdated() const { return engine_->is_outdated(); }
  void take_rendered(SlamMap map, const PlacedScans& keys) {
    engine_->take_rendered(std::move(map), keys);
  }
  [[nodiscard]] std::size_t map_bytes() const { return engine_->map_bytes(); }
  [[nodiscard]] const KeyScans& key_scans() const { return engine_->key_scans(); }
  [[nodiscard]] PoseGraph graph() const { return engine_->graph(); }
  [[nodiscard]] const LoopState& loop_state() const { return engine_->loop_state(); }
  [[nodiscard]] const LoopCount& brought_loops() const { return brought_loops_; }
  /// Those that were found since the run began or went on with a map.
  [[nodiscard]] LoopCount new_loops() const;

  [[nodiscard]] const std::map<int, SecondaryLaser>& secondary_lasers() const {
    return engine_->secondary_lasers().all();
  }
  [[nodiscard]] std::string scan_topic(int laser) const;

  /// Lasers that came into use with the newest scan, or contradict the first one now.
  [[nodiscard]] const std::vector<int>& laser_news() const { return laser_news_; }

  /// Sectors in which beams of any laser end on the robot itself, as RobotBeams finds them.
  [[nodiscard]] std::vector<double> robot_beams() const;

  /// Returns of a scan of the laser that has most, as ReturnCount tells them; none: too few scans.
  [[nodiscard]] std::optional<std::size_t> returns() const;

  /// Whether scans are left out.
  [[nodiscard]] bool is_paused() const { return paused_; }

  /// Scans that were processed.
  [[nodiscard]] std::size_t scans() const { return scans_; }

  /// Of the base in the map, and raw in the odometry frame; for drawing.
  [[nodiscard]] const ThinnedPath& path() const { return path_; }
  [[nodiscard]] const ThinnedPath& odometry_path() const { return odometry_path_; }

  /// [s] that stamps of the run are ahead of the newest scan's clock. Where that has stepped back,
  /// those of the run go on: all that is kept of its past has them.
  [[nodiscard]] double clock_offset() const { return clocks_.back().offset; }

  /// Times that it has stepped back and the map went on, since the last reset.
  [[nodiscard]] std::size_t clock_steps() const { return clocks_.size() - 1; }
  /// A stamp of the run by the clock that the robot had then.
  [[nodiscard]] double stamp_by_clock(double stamp) const {
    return stamp - clocks_[clock_at(stamp)].offset;
  }
  /// Poses of the run likewise: a part for each clock, oldest first, which may be empty.
  [[nodiscard]] std::vector<std::vector<StampedPose2>> by_clock(
      const std::vector<StampedPose2>& poses) const;

  /// Poses of the base in the map, one a stamp, or the latest ones. Those of a lost robot are put
  /// right when it is found, and those of all when a loop is closed.
  [[nodiscard]] const std::vector<StampedPose2>& trajectory() const { return trajectory_; }
  /// The same as they were told when each scan came.
  [[nodiscard]] const std::vector<StampedPose2>& live_trajectory() const {
    return live_trajectory_;
  }
  /// Whether a pose of the trajectory, by its stamp [s], is in the map: not of a lost robot that
  /// was never found, which is in a frame of its own.
  [[nodiscard]] bool is_in_map(double stamp) const;
  /// Those of the poses that are, by their stamps: others, drawn over it, would seem to be, too.
  [[nodiscard]] std::vector<StampedPose2> in_map(const std::vector<StampedPose2>& poses) const;
  /// Raw odometry at the same stamps, or the latest ones; empty when there is none.
  [[nodiscard]] const std::vector<StampedPose2>& odometry() const { return odometry_; }

  /// Seconds that each match took, or the latest ones; scans that were not matched have no entry.
  [[nodiscard]] const std::vector<float>& match_seconds() const { return match_seconds_; }
  /// Seconds that each scan took from projection to insertion, or the latest ones, by the state
  /// after it: with second looks, and searches for a lost robot.
  [[nodiscard]] const std::map<TrackingState, std::vector<float>>& scan_seconds() const {
    return scan_seconds_;
  }

  [[nodiscard]] const std::map<std::string, std::size_t>& statuses() const { return statuses_; }
  /// Scans by how much their match was to be believed.
  [[nodiscard]] const std::map<Certainty, std::size_t>& certainties() const { return certainties_; }
  /// Scans by how sure it was where the robot is.
  [[nodiscard]] const std::map<TrackingState, std::size_t>& states() const { return states_; }
  /// These as of SlamEngine.
  [[nodiscard]] std::vector<WeightedPose> likely_poses() const { return engine_->likely_poses(); }
  [[nodiscard]] std::size_t disconnected_components() const {
    return engine_->disconnected_components();
  }
  /// Components that were given up for others; see kMostDisconnectedComponents.
  [[nodiscard]] std::size_t components_given_up() const { return components_given_up_; }
  /// Of each match, or of the latest ones; see MatchResult.
  [[nodiscard]] const std::vector<float>& evidences() const { return evidences_; }
  [[nodiscard]] std::size_t inserted() const { return inserted_; }
  /// Scans that the map had no room for.
  [[nodiscard]] std::size_t left_out() const { return left_out_; }

  /// Times that map and poses were forgotten.
  [[nodiscard]] std::size_t resets() const { return resets_; }

  /// Events since the start, resets or not, that a scan came after; empty where only recent things
  /// are kept.
  [[nodiscard]] std::vector<TimedEvent> events() const;

 private:
  void take_effect(const SetPose& event);
  void take_effect(const CorrectPose& event);
  void take_effect(const BeAnywhere& event);
  void take_effect(const Reset& event);
  void take_effect(const LoadMapFile& event);
  void take_effect(const Pause& event);
  void take_effect(const Reconfigure& event);
  void take_effect(const LeaveOut& event);
  [[nodiscard]] LoopCount all_loops() const;
  [[nodiscard]] std::unique_ptr<SlamEngine> make_engine() const;
  void start_with(std::unique_ptr<SlamEngine> engine);
  [[nodiscard]] bool goes_on(const MotionState& before, const ScanInput& input) const;
  [[nodiscard]] std::size_t clock_at(double stamp) const;
  void begin_clock(const ScanInput& input);
  ScanOutcome process_by_clock(const ScanInput& input);
  void note_scan(const ScanInput& input);
  void note_lasers();
  void record(const ScanOutcome& outcome);
  void note_disconnected(const ScanOutcome& outcome);
  void correct_by(const std::optional<MapCorrection>& correction);

  RunRecords records_;
  LiveConfiguration configuration_;
  std::shared_ptr<TimedMatcher> matcher_;
  std::unique_ptr<SlamEngine> engine_;
  bool paused_ = false;
  int time_jumps_ = 0;
  /// What the stamps of the run are ahead of the robot's by [s], since one of these.
  struct Clock {
    double since = -std::numeric_limits<double>::infinity();
    double offset = 0.0;
  };
  std::vector<Clock> clocks_{1};
  bool has_stepped_back_ = false;  ///< since the newest scan; as the next
  bool is_told_ = false;           ///< where the robot is
  bool is_anywhere_ = false;       ///< nobody knows where
  std::size_t resets_ = 0;
  std::vector<TimedEvent> events_;
  std::size_t timed_events_ = 0;  ///< of these, as many as a scan came after
  std::size_t scans_ = 0;
  ThinnedPath path_;
  ThinnedPath odometry_path_;
  std::vector<StampedPose2> trajectory_;
  std::vector<StampedPose2> live_trajectory_;
  /// Stamps [s] of the first scan and the last of each component that was not joined.
  std::vector<std::pair<double, double>> disconnected_;
  bool is_disconnected_ = false;  ///< with the newest scan
  std::optional<double> told_;    ///< stamp [s] of the newest scan when its pose was told last
  std::vector<StampedPose2> odometry_;
  std::vector<float> match_seconds_;
  std::map<TrackingState, std::vector<float>> scan_seconds_;
  std::map<std::string, std::size_t> statuses_;  ///< by their words
  std::map<Certainty, std::size_t> certainties_;
  std::map<TrackingState, std::size_t> states_;
  std::vector<float> evidences_;
  LoopCount brought_loops_;  ///< by the map that it went on with
  std::size_t inserted_ = 0;
  std::size_t left_out_ = 0;
  std::size_t components_given_up_ = 0;
  double last_match_seconds_ = 0.0;
  std::map<int, LaserUse> laser_uses_;
  std::map<int, RobotBeams> robot_beams_;  ///< by laser
  std::map<int, ReturnCount> returns_;     ///< likewise
  std::vector<int> laser_news_;
};

}  // namespace matchbox_slam
