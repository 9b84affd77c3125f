#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "matchbox_slam/matching/monte_carlo/monte_carlo_matcher.hpp"
#include "matchbox_slam/matching/odometry_only_matcher.hpp"
#include "matchbox_slam/slam/slam_engine.hpp"
#include "simulation/simulation_support.hpp"

namespace matchbox_slam {

inline std::shared_ptr<const ScanMatcher> monte_carlo() {
  return std::make_shared<MonteCarloMatcher>();
}

inline std::shared_ptr<const ScanMatcher> odometry_only() {
  return std::make_shared<OdometryOnlyMatcher>();
}

/// Finds nothing, ever.
class RejectingMatcher : public ScanMatcher {
 public:
  void configure(const Parameters& /*parameters*/) override {}
  [[nodiscard]] std::vector<OptionDescription> options() const override { return {}; }
  [[nodiscard]] MatchResult match(const MatchProblem& problem) const override {
    return rejected(problem, MatchStatus::kRejectedLowScore);
  }
};

inline std::vector<ScanOutcome> process(const SimulatedRun& run, SlamEngine& engine,
                                        bool with_odometry = true) {
  std::vector<ScanOutcome> outcomes;
  for (std::size_t i = 0; i < run.scans.size(); ++i) {
    outcomes.push_back(engine.process(scan_input(run, i, with_odometry)));
  }
  return outcomes;
}

/// The engine's map starts at the first pose of the robot.
inline SlamEngine make_engine(const SimulatedRun& run,
                              const std::shared_ptr<const ScanMatcher>& matcher = monte_carlo(),
                              const EngineOptions& options = {}) {
  return {options, matcher, 1, run.world_from_base.front()};
}

/// Root mean square of the distance from the truth [m].
inline double rms_error(const SimulatedRun& run, const std::vector<ScanOutcome>& outcomes) {
  double sum = 0.0;
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    sum += (outcomes[i].map_from_base.translation() - run.world_from_base[i].translation())
               .squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(outcomes.size()));
}

inline ScanOdometry at_rest_at(const Pose2& odom_from_base) {
  return {odom_from_base, odom_from_base};
}

inline LaserScan lost_scan(std::size_t beams, double stamp, float reading) {
  LaserScan scan;
  scan.stamp = stamp;
  scan.angle_min = -1.0;
  scan.angle_increment = 2.0 / 100.0;
  scan.range_min = 0.1;
  scan.range_max = 30.0;
  scan.ranges.assign(beams, reading);
  return scan;
}

}  // namespace matchbox_slam
