#include "matchbox_slam/slam/slam_engine.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

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

SlamEngine::SlamEngine(const EngineOptions& options, std::shared_ptr<const ScanMatcher> matcher,
                       std::uint64_t seed, const Pose2& start)
    : options_(options),
      matcher_(std::move(matcher)),
      seed_(seed),
      start_(start),
      map_(options.map, options.field) {}

void SlamEngine::check_input(const ScanInput& input) const {
  const std::string stamp = std::to_string(input.scan.stamp);
  const bool is_later = !last_ || input.scan.stamp > last_->stamp ||
                        (input.scan.stamp == last_->stamp && input.laser != last_->laser);
  if (!is_later) {
    throw std::invalid_argument("scan at " + stamp + " s is not later than the one before, at " +
                                std::to_string(last_->stamp) + " s; process scans in order");
  }
  if (input.odometry && !(input.odometry->odom_from_base.is_finite() &&
                          input.odometry->odom_from_base_last_beam.is_finite())) {
    throw std::invalid_argument("the odometry of the scan at " + stamp +
                                " s is no number; leave it out to go on without odometry");
  }
  if (!input.base_from_laser.matrix().allFinite()) {
    throw std::invalid_argument("the laser's pose for the scan at " + stamp + " s is no number");
  }
}

ScanOutcome SlamEngine::process(const ScanInput& input) {
  check_input(input);
  PointScan scan =
      project_scan(input.scan, input.base_from_laser, motion_during_scan(input), options_.scan);

  // Predict.
  const MotionEstimate motion = predict_motion(input);
  const Pose2 predicted = last_ ? last_->map_from_base * motion.previous_from_current : start_;
  const Eigen::Matrix3d prior =
      last_ ? compose_covariance(last_->map_from_base, last_->covariance,
                                 motion.previous_from_current, motion.covariance)
            : start_covariance_;

  ScanOutcome outcome;
  outcome.match = match(scan, predicted, prior);

  // Decide: a rejected match carries the prediction, which stands then.
  outcome.stamp = input.scan.stamp;
  outcome.map_from_base = outcome.match.map_from_base;
  const double sweep = outcome.match.accepted() ? predicted_sweep(input) : 0.0;
  if (sweep > 0.0) {
    outcome.map_from_base = without_overshoot(predicted, outcome.match.map_from_base, sweep);
  }
  outcome.covariance = outcome.match.covariance;
  outcome.predicted_map_from_base = predicted;
  if (input.odometry) {
    outcome.odom_from_base = input.odometry->odom_from_base;
  }

  if (is_to_be_inserted(outcome, input.laser)) {
    if (sweep > 0.0) {  // by the motion as it is known now
      const Pose2 moved = last_->fix->map_from_base.inverse() * outcome.map_from_base;
      scan = project_scan(input.scan, input.base_from_laser, interpolate(Pose2{}, moved, sweep),
                          options_.scan);
    }
    outcome.inserted = has_room(scan, outcome.map_from_base, options_.map, map_);
    outcome.left_out = !outcome.inserted;
    if (outcome.inserted) {
      insert(scan, outcome.map_from_base, input.laser);
    }
  }
  remember(input, outcome);
  return outcome;
}

MatchResult SlamEngine::match(const PointScan& scan, const Pose2& predicted,
                              const Eigen::Matrix3d& prior) const {
  const MatchProblem problem{scan,       predicted,  prior,
                             map_.field, key_scans_, mix_seed(seed_, scan_count_)};
  if (map_.field.empty()) {
    return rejected(problem, MatchStatus::kRejectedNoReference);
  }
  if (scan.points.size() < static_cast<std::size_t>(options_.slam.min_points)) {
    return rejected(problem, MatchStatus::kRejectedTooFewPoints);
  }
  return matcher_->match(problem);
}

void SlamEngine::remember(const ScanInput& input, const ScanOutcome& outcome) {
  State state;
  state.stamp = input.scan.stamp;
  state.map_from_base = outcome.map_from_base;
  state.covariance = outcome.covariance;
  state.odom_from_base = outcome.odom_from_base;
  state.laser = input.laser;
  state.matched = outcome.match.accepted() || outcome.inserted;
  if (last_) {
    state.motion = last_->motion;
    state.interval = last_->interval;
    state.fix = last_->fix;
  }
  if (state.matched) {
    // From fix to fix: what a wrong prediction was corrected by is no motion.
    if (state.fix && state.stamp > state.fix->stamp) {
      state.motion = state.fix->map_from_base.inverse() * outcome.map_from_base;
      state.interval = state.stamp - state.fix->stamp;
    }
    state.fix = Fix{state.stamp, outcome.map_from_base};
  }
  last_ = state;
  ++scan_count_;
}

void SlamEngine::set_options(const EngineOptions& options) {
  check_map(map_, options);
  options_ = options;
}

void SlamEngine::start_from(MapStart start) {
  check_map(start.map, options_);
  map_ = std::move(start.map);
  key_scans_ = std::move(start.key_scans);
  start_ = start.map_from_base;
  start_covariance_ = start.covariance;
  last_.reset();
  last_inserted_.clear();
}

MapStart SlamEngine::snapshot() const {
  return {map_, key_scans_, last_ ? last_->map_from_base : start_,
          last_ ? last_->covariance : start_covariance_};
}

void SlamEngine::set_pose(const Pose2& map_from_base, const Eigen::Matrix3d& covariance) {
  if (!last_) {
    start_ = map_from_base;
    start_covariance_ = covariance;
    return;
  }
  last_->map_from_base = map_from_base;
  last_->covariance = covariance;
  last_->motion = {};
  last_->fix.reset();
}

MotionEstimate SlamEngine::predict_motion(const ScanInput& input) const {
  if (!last_) {
    return {};
  }
  if (input.odometry && last_->odom_from_base) {
    return motion_from_odometry(*last_->odom_from_base, input.odometry->odom_from_base,
                                options_.motion);
  }
  return motion_at_constant_velocity(last_->motion, last_->interval,
                                     input.scan.stamp - last_->stamp, options_.motion);
}

Pose2 SlamEngine::motion_during_scan(const ScanInput& input) const {
  if (input.odometry) {
    return input.odometry->odom_from_base.inverse() * input.odometry->odom_from_base_last_beam;
  }
  if (last_ && last_->interval > 0.0) {
    return interpolate(Pose2{}, last_->motion, input.scan.duration() / last_->interval);
  }
  return {};
}

/// Duration of the scan over the time since the last match, where the motion in that time was
/// predicted from earlier matches; else 0.
double SlamEngine::predicted_sweep(const ScanInput& input) const {
  const bool is_predicted = last_ && last_->fix && !input.odometry;
  const double passed = is_predicted ? input.scan.stamp - last_->fix->stamp : 0.0;
  return passed > 0.0 ? std::max(0.0, input.scan.duration() / passed) : 0.0;
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
         (match.status == MatchStatus::kRejectedLowScore && last_ && last_->matched &&
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

void SlamEngine::insert(const PointScan& scan, const Pose2& map_from_base, int laser) {
  insert_scan(scan, map_from_base, options_.map, map_);
  last_inserted_[laser] = map_from_base;
  key_scans_.push_back(std::make_shared<const KeyScan>(KeyScan{scan, map_from_base}));
  while (key_scans_.size() > static_cast<std::size_t>(options_.slam.key_scans)) {
    key_scans_.pop_front();
  }
}

}  // namespace matchbox_slam
