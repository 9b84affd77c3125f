#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/map/scan_inserter.hpp"
#include "matchbox_slam/matching/scan_matcher.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"
#include "matchbox_slam/sensor/scan_input.hpp"
#include "matchbox_slam/slam/engine_options.hpp"
#include "matchbox_slam/slam/further_lasers.hpp"
#include "matchbox_slam/slam/key_scans.hpp"
#include "matchbox_slam/slam/loop_closing.hpp"
#include "matchbox_slam/slam/map_drawing.hpp"
#include "matchbox_slam/slam/map_parts.hpp"
#include "matchbox_slam/slam/map_start.hpp"
#include "matchbox_slam/slam/motion_tracker.hpp"
#include "matchbox_slam/slam/near_map.hpp"
#include "matchbox_slam/slam/recovery.hpp"
#include "matchbox_slam/slam/scan_outcome.hpp"
#include "matchbox_slam/slam/tracking_state.hpp"

namespace matchbox_slam {

class SeenScans;

/// The SLAM loop: predict, match, decide, insert. Single-threaded; the same scans, options and seed
/// yield the same bits.
class SlamEngine {
 public:
  /// @param matcher  configured; shared, since it has no state.
  /// @param seed     of the run; each scan gets its own from this and its number.
  /// @param start    pose of the base in the map at the first scan.
  SlamEngine(const EngineOptions& options, std::shared_ptr<const ScanMatcher> matcher,
             std::uint64_t seed, const Pose2& start = {});
  SlamEngine(SlamEngine&& other) noexcept;
  SlamEngine& operator=(SlamEngine&& other) noexcept;
  ~SlamEngine();

  /// Processes the next scan. Scans come in order of their stamps; those of different lasers may
  /// have the same one.
  /// Throws std::invalid_argument when a stamp is not later than the one before, or odometry or the
  /// laser's pose is no number; then nothing has changed.
  ScanOutcome process(const ScanInput& input);

  /// The map so far, without what a lost robot maps apart; copy it for a snapshot.
  /// Renders anew what loops have moved.
  [[nodiscard]] const SlamMap& map() { return drawing_.whole(parts_.map(), options_); }
  /// Whether map() would render it, which takes 2 ms a key scan, so that others may do it beside.
  [[nodiscard]] bool is_outdated() const { return drawing_.is_outdated(); }
  /// Takes what another thread has `rendered` from key scans as they were. Left alone where they
  /// have moved since.
  void take_rendered(SlamMap map, const PlacedScans& keys) {
    drawing_.take_rendered(std::move(map), keys, parts_.map());
  }
  /// Of the map as it is, rendered or not.
  [[nodiscard]] std::size_t map_bytes() const;
  [[nodiscard]] const KeyScans& key_scans() const { return parts_.map().key_scans; }

  /// Maps that the robot made while it was lost, and that were not joined.
  [[nodiscard]] std::size_t parts_apart() const { return parts_.all().size() - 1; }
  [[nodiscard]] TrackingState state() const;
  [[nodiscard]] const LoopCloser& loops() const { return loops_; }
  [[nodiscard]] const FurtherLasers& further_lasers() const { return further_lasers_; }
  [[nodiscard]] const EngineOptions& options() const { return options_; }

  /// Matches from the next scan on are made by this matcher; map and pose stay.
  void set_matcher(std::shared_ptr<const ScanMatcher> matcher) { matcher_ = std::move(matcher); }

  /// These take effect from the next scan on; map and pose stay. Throws ConfigurationError for
  /// another resolution or likelihood field, which the map was made with.
  void set_options(const EngineOptions& options);

  /// Says where the base was at the newest scan, or will be at the first one; the map stays. A lost
  /// robot is found by it.
  /// @param covariance  over (x, y, theta) in the map frame.
  void set_pose(const Pose2& map_from_base, const Eigen::Matrix3d& covariance);

  /// From the scan of this stamp [s] on the robot may be anywhere, as at the begin of another
  /// drive. What it sees is mapped apart until it is found. Returns whether another map apart had
  /// to be given up for that.
  bool map_apart(double stamp);

  /// Goes on from there. Throws ConfigurationError when that map was made with another resolution
  /// or likelihood field.
  void start_from(MapStart start);

  /// Where a drive ends: waits for a search for a loop that is under way, and closes what it finds.
  std::optional<MapCorrection> finish_loops();

  /// What it takes to go on from here.
  [[nodiscard]] MapStart snapshot();

 private:
  [[nodiscard]] const SlamMap& matched_map() const;
  [[nodiscard]] bool closes_loops() const { return options_.slam.loop_closing && is_of_key_scans_; }
  [[nodiscard]] NearRequest near_request() const;
  void see(const ScanInput& input, const MotionPrediction& predicted, bool with_further_lasers);
  ScanOutcome take_aside(const ScanInput& input, const MotionPrediction& predicted);
  [[nodiscard]] WeighedMatch match_likeliest(const std::optional<MotionPrediction>& steady,
                                             MotionPrediction& predicted);
  [[nodiscard]] WeighedMatch match(const PointScan& scan, const MotionPrediction& predicted);
  void insert_or_hold(const SeenScans& seen, int laser, ScanOutcome& outcome);
  void insert_or_hold(const PointScan& scan, const MeasuredScan& measured, int laser,
                      ScanOutcome& outcome);
  [[nodiscard]] bool insert(const PointScan& scan, const PlacedScan& placed,
                            const Eigen::Matrix3d& covariance, bool is_continued, MapPart& part);
  void believe();
  void weigh_doubt(const WeighedMatch& match, const ScanOutcome& outcome, double way);
  [[nodiscard]] bool has_pending() const;
  [[nodiscard]] std::size_t insert_pending();
  void search_for_map(const PointScan& scan, ScanOutcome& outcome);
  void join(const PlaceHypothesis& found);
  void match_whole_map() { drawing_.match_whole(parts_.map(), options_); }
  void close_loops(ScanOutcome& outcome);
  void move_map(const MapCorrection& correction);
  void find_places_to_search();

  EngineOptions options_;
  std::shared_ptr<const ScanMatcher> matcher_;
  std::uint64_t seed_;
  std::uint64_t scan_count_ = 0;
  MotionTracker tracker_;
  FurtherLasers further_lasers_;
  MapParts parts_;
  TrackingDoubt doubt_;
  double usual_score_ = 0.0;
  std::vector<WaitingScan> held_;
  PlaceSearch search_;
  std::vector<SearchedPlace> places_;  ///< follows from the parts
  LoopCloser loops_;                   ///< in the map, not in the parts apart
  MapDrawing drawing_;                 ///< of the map
  bool is_continued_ = false;          ///< see MapStart
  bool is_of_key_scans_ = true;        ///< see MapStart
  // Of the scan at hand; kept for their memory.
  ScanProjector projector_;
  std::unique_ptr<SeenScans> seen_;
  PlacedScans recent_;
};

}  // namespace matchbox_slam
