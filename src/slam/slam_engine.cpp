#include "matchbox_slam/slam/slam_engine.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

#include "matchbox_slam/common/random.hpp"

namespace matchbox_slam {
namespace {

template <typename Options>
void append_section(const std::string& section, const Options& options,
                    std::vector<OptionDescription>& rows) {
  for (OptionDescription& row : describe_options(options)) {
    row.name = section + "/" + row.name;
    rows.push_back(std::move(row));
  }
}

}  // namespace

EngineOptions read_engine_options(const Parameters& parameters) {
  EngineOptions options;
  options.slam = read_options<SlamOptions>(parameters.section("slam"), "slam");
  options.scan = read_options<ProjectionOptions>(parameters.section("scan"), "scan");
  options.map = read_options<MapOptions>(parameters.section("map"), "map");
  options.field = read_options<LikelihoodFieldOptions>(parameters.section("field"), "field");
  options.motion = read_options<MotionPriorOptions>(parameters.section("motion"), "motion");
  const double after_first_hit = 0.5 + 0.5 * options.map.quality;
  if (options.map.occupied_threshold > after_first_hit) {
    throw ConfigurationError(
        "map/occupied_threshold: " + to_string(options.map.occupied_threshold) +
        " is not allowed with a map/quality of " + to_string(options.map.quality) +
        ", since no first hit would reach it; allowed: at most " + to_string(after_first_hit));
  }
  return options;
}

std::vector<OptionDescription> describe_engine_options(const EngineOptions& options) {
  std::vector<OptionDescription> rows;
  append_section("slam", options.slam, rows);
  append_section("scan", options.scan, rows);
  append_section("map", options.map, rows);
  append_section("field", options.field, rows);
  append_section("motion", options.motion, rows);
  return rows;
}

SlamEngine::SlamEngine(const EngineOptions& options, std::shared_ptr<const ScanMatcher> matcher,
                       std::uint64_t seed, const Pose2& start)
    : options_(options),
      matcher_(std::move(matcher)),
      seed_(seed),
      start_(start),
      map_(options.map, options.field) {}

ScanOutcome SlamEngine::process(const ScanInput& input) {
  if (last_ && !(input.scan.stamp > last_->stamp)) {
    throw std::invalid_argument("scan at " + std::to_string(input.scan.stamp) +
                                " s is not later than the one before, at " +
                                std::to_string(last_->stamp) + " s; process scans in order");
  }
  if (input.odometry && !(input.odometry->odom_from_base.is_finite() &&
                          input.odometry->odom_from_base_last_beam.is_finite())) {
    throw std::invalid_argument("the odometry of the scan at " + std::to_string(input.scan.stamp) +
                                " s is no number; leave it out to go on without odometry");
  }
  if (!input.base_from_laser.matrix().allFinite()) {
    throw std::invalid_argument("the laser's pose for the scan at " +
                                std::to_string(input.scan.stamp) + " s is no number");
  }
  const PointScan scan =
      project_scan(input.scan, input.base_from_laser, motion_during_scan(input), options_.scan);

  // Predict.
  const MotionEstimate motion = predict_motion(input);
  const Pose2 predicted = last_ ? last_->map_from_base * motion.previous_from_current : start_;
  const Eigen::Matrix3d prior =
      last_ ? compose_covariance(last_->map_from_base, last_->covariance,
                                 motion.previous_from_current, motion.covariance)
            : Eigen::Matrix3d::Zero();

  // Match.
  const MatchProblem problem{scan,       predicted,  prior,
                             map_.field, key_scans_, mix_seed(seed_, scan_count_)};
  ScanOutcome outcome;
  if (map_.field.empty()) {
    outcome.match = rejected(problem, MatchStatus::kRejectedNoReference);
  } else if (scan.points.size() < static_cast<std::size_t>(options_.slam.min_points)) {
    outcome.match = rejected(problem, MatchStatus::kRejectedTooFewPoints);
  } else {
    outcome.match = matcher_->match(problem);
  }

  // Decide: a rejected match carries the prediction, which stands then.
  outcome.stamp = input.scan.stamp;
  outcome.map_from_base = outcome.match.map_from_base;
  outcome.covariance = outcome.match.covariance;
  outcome.predicted_map_from_base = predicted;

  // Insert, but only what was matched, except for the scan that starts the map.
  const bool starts_map = map_.field.empty();
  if (starts_map || (outcome.match.accepted() && is_worth_inserting(outcome.match))) {
    outcome.inserted = has_room(scan, outcome.map_from_base, options_.map, map_);
    outcome.left_out = !outcome.inserted;
    if (outcome.inserted) {
      insert(scan, outcome.map_from_base);
    }
  }

  State state;
  state.stamp = input.scan.stamp;
  state.map_from_base = outcome.map_from_base;
  state.covariance = outcome.covariance;
  if (input.odometry) {
    state.odom_from_base = input.odometry->odom_from_base;
    outcome.odom_from_base = input.odometry->odom_from_base;
  }
  if (last_) {
    state.motion = last_->map_from_base.inverse() * outcome.map_from_base;
    state.interval = input.scan.stamp - last_->stamp;
  }
  last_ = state;
  ++scan_count_;
  return outcome;
}

void SlamEngine::set_pose(const Pose2& map_from_base, const Eigen::Matrix3d& covariance) {
  if (!last_) {
    start_ = map_from_base;
    return;
  }
  last_->map_from_base = map_from_base;
  last_->covariance = covariance;
  last_->motion = {};
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

bool SlamEngine::is_worth_inserting(const MatchResult& match) const {
  const Pose2 moved = key_scans_.back()->map_from_base.inverse() * match.map_from_base;
  return moved.translation().norm() >= options_.slam.insert_distance ||
         std::abs(moved.theta) >= options_.slam.insert_angle ||
         match.score < options_.slam.insert_overlap;
}

void SlamEngine::insert(const PointScan& scan, const Pose2& map_from_base) {
  insert_scan(scan, map_from_base, options_.map, map_);
  key_scans_.push_back(std::make_shared<const KeyScan>(KeyScan{scan, map_from_base}));
  while (key_scans_.size() > static_cast<std::size_t>(options_.slam.key_scans)) {
    key_scans_.pop_front();
  }
}

}  // namespace matchbox_slam
