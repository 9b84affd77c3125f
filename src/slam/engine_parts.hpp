#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "lasers/scan_bundle.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"
#include "matchbox_slam/slam/slam_engine.hpp"
#include "motion/motion_tracker.hpp"
#include "slam/common_ground.hpp"
#include "slam/mapping.hpp"
#include "slam/pose_hypotheses.hpp"
#include "slam/relocalizer.hpp"

namespace matchbox_slam {

/// Tells those who do the work of each other: MotionTracker predicts, the matcher matches,
/// PoseHypotheses says whether it may be elsewhere, Mapping takes scans in and closes loops,
/// Relocalizer looks for a lost robot, SecondaryLasers knows the other lasers. What it answers to
/// is described in SlamEngine.
class SlamEngine::Parts {
 public:
  Parts(const EngineOptions& options, std::shared_ptr<const ScanMatcher> matcher,
        std::uint64_t seed, const Pose2& start);

  ScanOutcome process(const ScanInput& input);
  [[nodiscard]] TrackingState state() const;
  [[nodiscard]] std::vector<WeightedPose> likely_poses() const;
  void set_options(const EngineOptions& options);
  void set_pose(const Pose2& map_from_base, const Eigen::Matrix3d& covariance);
  bool begin_component(double stamp);
  void start_from(EngineState start);
  std::optional<MapCorrection> finish_loops();
  [[nodiscard]] EngineState snapshot();

 private:
  friend class SlamEngine;
  using Verdict = PoseHypotheses::Verdict;

  ScanOutcome take_secondary(const ScanInput& input, const MotionPrediction& predicted);
  void collect_scans(const ScanInput& input, const MotionPrediction& predicted,
                     bool with_secondary_lasers);
  [[nodiscard]] MatchResult match(const MotionPrediction& predicted);
  Verdict weigh(MotionPrediction& predicted, const std::optional<MotionPrediction>& steady,
                double seconds, ScanOutcome& outcome);
  void search_anew_if_lost();
  void follow(const PoseHypotheses::Outcome& overtaken, MotionPrediction& predicted,
              ScanOutcome& outcome);
  void draw(const ScanInput& input, const Pose2& during_scan, ScanOutcome& outcome);
  [[nodiscard]] bool is_component_unmatched(const ScanOutcome& outcome,
                                            const MotionPrediction& predicted) const;
  Mapping::BegunComponent be_lost(double stamp);
  void remember(const ScanInput& input, const MotionPrediction& predicted,
                const ScanOutcome& outcome);
  void close_loops(ScanOutcome& outcome);
  void search_for_map(ScanOutcome& outcome);
  void join(const PlaceHypothesis& found);
  void believe();
  [[nodiscard]] const EngineOptions& options() const { return mapping_.options(); }
  [[nodiscard]] const PlacedScans& active_key_scans() const {
    return mapping_.components().active().key_scans.all();
  }

  std::shared_ptr<const ScanMatcher> matcher_;
  std::uint64_t seed_;
  std::uint64_t scan_count_ = 0;
  MotionTracker tracker_;
  SecondaryLasers secondary_lasers_;
  PoseHypotheses hypotheses_;
  Relocalizer relocalizer_;
  Mapping mapping_;
  // Of the scan at hand; kept for their memory.
  ScanProjector projector_;
  ScanBundle bundle_;
  CommonGroundMatch common_ground_;
  PlacedScans recent_;
};

}  // namespace matchbox_slam
