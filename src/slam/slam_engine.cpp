#include "matchbox_slam/slam/slam_engine.hpp"

#include <cmath>
#include <string>
#include <utility>

#include "matchbox_slam/common/random.hpp"

namespace matchbox_slam {
namespace {

/// Throws ConfigurationError when the map was not made with these options.
void check_map(const SlamMap& map, const EngineOptions& options) {
  const auto require = [](const std::string& name, double wanted, double made) {
    if (wanted != made) {
      throw ConfigurationError(name + ": " + to_string(wanted) +
                               " is not allowed with a map that was made with " + to_string(made) +
                               "; allowed: the same, or a new map");
    }
  };
  require("map/resolution", options.map.resolution, map.field.geometry().resolution());
  require("field/sigma", options.field.sigma, map.field.options().sigma);
  require("field/reach", options.field.reach, map.field.options().reach);
}

}  // namespace

void MapStart::begin_anew(const Pose2& map_from_base, const Eigen::Matrix3d& covariance) {
  MotionState at_rest;  // made first: the arguments may be the present motion's own
  at_rest.fixed_from_base = map_from_base;
  at_rest.covariance = covariance;
  motion = at_rest;
  last_inserted.clear();
}

SlamEngine::SlamEngine(const EngineOptions& options, std::shared_ptr<const ScanMatcher> matcher,
                       std::uint64_t seed, const Pose2& start)
    : options_(options),
      matcher_(std::move(matcher)),
      seed_(seed),
      tracker_(options.motion),
      map_(options.map, options.field) {
  tracker_.set_pose(start, Eigen::Matrix3d::Zero());
}

ScanOutcome SlamEngine::process(const ScanInput& input) {
  const MotionPrediction predicted = tracker_.predict(input);
  MeasuredScan measured{input.scan, input.base_from_laser, predicted.during_scan, options_.scan};
  PointScan scan = project_scan(measured);

  // A rejected match carries the prediction, which stands then.
  ScanOutcome outcome;
  outcome.match = match(scan, predicted);
  const MatchedMotion matched = tracker_.after_match(input, predicted, outcome.match);
  outcome.stamp = input.scan.stamp;
  outcome.map_from_base = matched.fixed_from_base;
  outcome.covariance = outcome.match.covariance;
  outcome.predicted_map_from_base = predicted.fixed_from_base;
  if (input.odometry) {
    outcome.odom_from_base = input.odometry->odom_from_base;
  }

  if (is_to_be_inserted(outcome, input.laser)) {
    if (matched.during_scan != predicted.during_scan) {
      measured.motion = matched.during_scan;
      scan = project_scan(measured);
    }
    outcome.inserted = has_room(scan, outcome.map_from_base, options_.map, map_);
    outcome.left_out = !outcome.inserted;
    if (outcome.inserted) {
      insert(scan, std::move(measured), outcome.map_from_base, input.laser);
    }
  }
  tracker_.remember(input, predicted, outcome.map_from_base, outcome.covariance,
                    outcome.match.accepted() || outcome.inserted);
  ++scan_count_;
  return outcome;
}

MatchResult SlamEngine::match(const PointScan& scan, const MotionPrediction& predicted) const {
  const PlacedScans recent =
      key_scans_.newest(static_cast<std::size_t>(options_.slam.recent_scans));
  const MatchProblem problem{scan,   predicted.fixed_from_base,   predicted.covariance, map_.field,
                             recent, mix_seed(seed_, scan_count_)};
  if (map_.field.empty()) {
    return rejected(problem, MatchStatus::kRejectedNoReference);
  }
  if (scan.points.size() < static_cast<std::size_t>(options_.slam.min_points)) {
    return rejected(problem, MatchStatus::kRejectedTooFewPoints);
  }
  return matcher_->match(problem);
}

void SlamEngine::set_options(const EngineOptions& options) {
  check_map(map_, options);
  options_ = options;
  tracker_.set_options(options.motion);
}

void SlamEngine::start_from(MapStart start) {
  check_map(start.map, options_);
  map_ = std::move(start.map);
  key_scans_ = std::move(start.key_scans);
  tracker_.set_state(start.motion);
  last_inserted_ = std::move(start.last_inserted);
  scan_count_ = start.scan_count;
}

MapStart SlamEngine::snapshot() const {
  return {map_, key_scans_, tracker_.state(), last_inserted_, scan_count_};
}

/// Only what was matched goes into the map, except for what starts it. A further laser's first scan
/// may show what no other has seen yet: then it goes where the others have just put the base.
bool SlamEngine::is_to_be_inserted(const ScanOutcome& outcome, int laser) const {
  const MatchResult& match = outcome.match;
  if (!options_.slam.update_map) {
    return false;
  }
  if (match.accepted()) {
    return is_worth_inserting(outcome, laser);
  }
  return map_.field.empty() ||
         (match.status == MatchStatus::kRejectedLowScore && tracker_.state().matched &&
          !last_inserted_.empty() && last_inserted_.count(laser) == 0);
}

bool SlamEngine::is_worth_inserting(const ScanOutcome& outcome, int laser) const {
  const auto before = last_inserted_.find(laser);
  if (before == last_inserted_.end()) {
    return true;
  }
  const Pose2 moved = before->second.inverse() * outcome.map_from_base;
  return moved.translation().norm() >= options_.slam.insert_distance ||
         std::abs(moved.theta) >= options_.slam.insert_angle ||
         outcome.match.score < options_.slam.insert_overlap;
}

void SlamEngine::insert(const PointScan& scan, MeasuredScan measured, const Pose2& map_from_base,
                        int laser) {
  insert_scan(scan, map_from_base, options_.map, map_);
  last_inserted_[laser] = map_from_base;
  key_scans_.add(std::move(measured), laser, map_from_base);
}

}  // namespace matchbox_slam
