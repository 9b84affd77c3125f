#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/graph/pose_graph.hpp"
#include "matchbox_slam/lasers/secondary_lasers.hpp"
#include "matchbox_slam/map/scan_inserter.hpp"
#include "matchbox_slam/matching/scan_matcher.hpp"
#include "matchbox_slam/sensor/scan_input.hpp"
#include "matchbox_slam/slam/engine_options.hpp"
#include "matchbox_slam/slam/engine_state.hpp"
#include "matchbox_slam/slam/key_scans.hpp"
#include "matchbox_slam/slam/loops.hpp"
#include "matchbox_slam/slam/scan_outcome.hpp"

namespace matchbox_slam {

struct FoundMap;

/// Where the robot may be, and the share of what is known that speaks for it.
struct WeightedPose {
  Pose2 map_from_base;
  double weight = 0.0;
};

/// The SLAM loop: predict, match, decide, insert. Single-threaded; the same scans, options and seed
/// yield the same bits. One that was moved from may only be assigned to or destroyed.
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

  /// The map so far, without disconnected components; copy it for a snapshot.
  /// Renders anew what loops have moved.
  [[nodiscard]] const SlamMap& map();
  /// The same to be looked at alone: its field may lack likelihoods, which take time and memory.
  [[nodiscard]] const SlamMap& drawn_map();
  /// Whether map() would render it, which takes 2 ms a key scan, so that others may do it beside.
  [[nodiscard]] bool is_outdated() const;
  /// Takes what another thread has rendered from key scans as they were. Left alone where they
  /// have moved since.
  void take_rendered(SlamMap map, const PlacedScans& keys);
  /// Of the map as it is, rendered or not.
  [[nodiscard]] std::size_t map_bytes() const;
  [[nodiscard]] const KeyScans& key_scans() const;
  /// Of the key scans, as it is now: how they are joined.
  [[nodiscard]] PoseGraph graph() const;
  /// The same without poses, with the loops that were tried.
  [[nodiscard]] const LoopState& loop_state() const;

  /// Components that the robot made while it was lost, and that were not joined to the map.
  [[nodiscard]] std::size_t disconnected_components() const;
  [[nodiscard]] TrackingState state() const;
  /// Where in the map the robot may be, at the newest scan: the leading hypothesis first, then
  /// those that compete with it, by their odds; of a lost robot the places that scans confirm, by
  /// how many do. What weights lack of 1 speaks for somewhere else.
  [[nodiscard]] std::vector<WeightedPose> likely_poses() const;
  [[nodiscard]] const MotionState& motion() const;
  [[nodiscard]] const SecondaryLasers& secondary_lasers() const;
  [[nodiscard]] const EngineOptions& options() const;

  /// Matches from the next scan on are made by this matcher; map and pose stay.
  void set_matcher(std::shared_ptr<const ScanMatcher> matcher);

  /// These take effect from the next scan on; map and pose stay. Throws ConfigurationError for
  /// another resolution or likelihood field, which the map was made with.
  void set_options(const EngineOptions& options);

  /// Says where the base was at the newest scan, or will be at the first one; the map stays. A lost
  /// robot is found by it.
  /// @param covariance  over (x, y, theta) in the map frame.
  void set_pose(const Pose2& map_from_base, const Eigen::Matrix3d& covariance);

  /// Begins a component: from the scan of this stamp [s] on the robot may be anywhere, as at the
  /// begin of another drive. What it sees goes into the component until it is found. Returns
  /// whether another component had to be given up for that.
  bool begin_component(double stamp);

  /// Goes on from there. Throws ConfigurationError when that map was made with another resolution
  /// or likelihood field.
  void start_from(EngineState start);

  /// Another robot's map, which was found to meet this one's as it was a while ago, becomes part of
  /// it with one of the next key scans; what it holds tells then. It is not where this map's key
  /// scans have moved since, or are no more.
  void expect_map(std::shared_ptr<const FoundMap> found);

  /// Where a drive ends: waits for a search for a loop that is under way, and closes what it finds.
  std::optional<MapCorrection> finish_loops();

  /// What it takes to go on from here. Where scans are matched against what lies near alone, the
  /// map's field is not rendered.
  [[nodiscard]] EngineState snapshot();

 private:
  class Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace matchbox_slam
