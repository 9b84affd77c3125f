#include "matchbox_slam/slam/laser_odometry.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "matchbox_slam/common/random.hpp"

namespace matchbox_slam {
namespace {

// The first pose is known by definition; but a covariance that cannot be inverted would stop
// filters.
constexpr double kOriginVariance = 1e-8;  // 0.1 mm, 0.1 mrad

void require_sound(const ScanInput& input, const std::optional<double>& last_stamp) {
  const std::string scan = "scan at " + std::to_string(input.scan.stamp) + " s";
  if (last_stamp && !(input.scan.stamp > *last_stamp)) {
    throw std::invalid_argument(scan + " is not later than the one before, at " +
                                std::to_string(*last_stamp) + " s; process scans in order");
  }
  if (input.odometry && !(input.odometry->odom_from_base.is_finite() &&
                          input.odometry->odom_from_base_last_beam.is_finite())) {
    throw std::invalid_argument("the odometry of the " + scan +
                                " is no number; leave it out to go on without odometry");
  }
  if (!input.base_from_laser.matrix().allFinite()) {
    throw std::invalid_argument("the laser's pose for the " + scan + " is no number");
  }
}

/// Covariance of `a_from_b` from those of two poses in one frame that are independent, first order.
Eigen::Matrix3d between_covariance(const Pose2& map_from_a, const Eigen::Matrix3d& covariance_a,
                                   const Pose2& map_from_b, const Eigen::Matrix3d& covariance_b) {
  const Pose2 a_from_b = map_from_a.inverse() * map_from_b;
  const double c = std::cos(map_from_a.theta);
  const double s = std::sin(map_from_a.theta);
  Eigen::Matrix3d by_b;
  by_b << c, s, 0.0, -s, c, 0.0, 0.0, 0.0, 1.0;
  Eigen::Matrix3d by_a = -by_b;
  by_a(0, 2) = a_from_b.y;
  by_a(1, 2) = -a_from_b.x;
  return by_a * covariance_a * by_a.transpose() + by_b * covariance_b * by_b.transpose();
}

/// The matrix that takes a motion to the constant velocity, in the moving frame, that makes it in
/// `interval` seconds: the logarithm of SE(2).
Eigen::Matrix3d velocity_from_motion(double theta, double interval) {
  const double half = 0.5 * theta;
  const double along = std::abs(half) < 1e-6 ? 1.0 : half / std::tan(half);
  Eigen::Matrix3d matrix;
  matrix << along, half, 0.0, -half, along, 0.0, 0.0, 0.0, 1.0;
  return matrix / interval;
}

double square(double value) { return value * value; }

/// Rounding leaves products that ought to be symmetric not quite so.
Eigen::Matrix3d symmetric(const Eigen::Matrix3d& matrix) {
  return 0.5 * (matrix + matrix.transpose());
}

}  // namespace

LaserOdometrySettings read_laser_odometry_settings(const Parameters& parameters) {
  const EngineOptions engine = read_engine_options(parameters);
  return {read_options<LaserOdometryOptions>(parameters.section("odometry"), "odometry"),
          engine.scan, engine.map, engine.field, engine.motion};
}

LaserOdometry::LaserOdometry(const LaserOdometrySettings& settings,
                             std::shared_ptr<const ScanMatcher> matcher, GuessSource guess,
                             std::uint64_t seed)
    : settings_(settings),
      matcher_(std::move(matcher)),
      guess_(guess),
      seed_(seed),
      reference_(empty_map()),
      next_(empty_map()),
      key_errors_(Pose2{}, kOriginVariance * Eigen::Matrix3d::Identity()) {}

LaserOdometryOutcome LaserOdometry::process(const ScanInput& input) {
  require_sound(input, last_ ? std::optional(last_->stamp) : std::nullopt);
  PointScan scan =
      project_scan(input.scan, input.base_from_laser, motion_during_scan(input), settings_.scan);

  // Guess.
  const MotionEstimate guess = guess_motion(input);
  LaserOdometryOutcome outcome;
  outcome.stamp = input.scan.stamp;
  outcome.guessed_odom_from_base =
      last_ ? last_->odom_from_base * guess.previous_from_current : Pose2{};
  const Eigen::Matrix3d prior =
      last_ ? compose_covariance(last_->odom_from_base, last_->local_covariance,
                                 guess.previous_from_current, guess.covariance)
            : Eigen::Matrix3d::Zero();

  // Match: a rejected one carries the guess, which stands then.
  outcome.match = match(scan, outcome.guessed_odom_from_base, prior);
  outcome.odom_from_base = outcome.match.map_from_base;
  const double sweep = outcome.match.accepted() ? predicted_sweep(input) : 0.0;
  if (sweep > 0.0) {
    const bool has_heading = guess_ == GuessSource::kHeading && input.odometry;
    outcome.odom_from_base =
        without_overshoot(outcome.guessed_odom_from_base, outcome.match.map_from_base, sweep);
    Pose2 motion =
        interpolate(Pose2{}, last_fix_->odom_from_base.inverse() * outcome.odom_from_base, sweep);
    if (has_heading) {  // the turn was measured, so that nothing went too far in it
      outcome.odom_from_base.theta = outcome.match.map_from_base.theta;
      motion.theta = wrap_angle(input.odometry->odom_from_base_last_beam.theta -
                                input.odometry->odom_from_base.theta);
    }
    scan = project_scan(input.scan, input.base_from_laser, motion, settings_.scan);
  }
  ++scan_count_;
  count_failures(outcome.match.status);

  key_errors_.follow(outcome.odom_from_base, prior, outcome.match.covariance);
  outcome.covariance = symmetric(key_errors_.covariance());
  set_velocity(guess, outcome);

  State now;
  now.stamp = outcome.stamp;
  now.odom_from_base = outcome.odom_from_base;
  now.local_covariance = outcome.match.covariance;
  if (input.odometry) {
    now.sensed_odom_from_base = input.odometry->odom_from_base;
  }
  set_motion(outcome, now);

  keep(scan, outcome, now);
  last_ = now;
  return outcome;
}

void LaserOdometry::keep(const PointScan& scan, LaserOdometryOutcome& outcome, State& now) {
  outcome.restarted = misfits_ >= settings_.odometry.lost_after;
  if (outcome.restarted) {
    reference_ = empty_map();
    next_ = empty_map();
    misfits_ = 0;
  }
  const bool starts_map =
      reference_.key_scans.empty() && outcome.match.status != MatchStatus::kRejectedTooFewPoints;
  if (starts_map || (outcome.match.accepted() && is_key_scan(outcome))) {
    if (starts_map) {
      key_errors_ = KeyErrors(outcome.odom_from_base, outcome.covariance);
    } else {
      key_errors_.add();
    }
    add_key_scan(scan, outcome.odom_from_base);
    key_errors_.keep_newest(reference_.key_scans.size());
    now.local_covariance.setZero();
    outcome.is_key_scan = true;
  }
  if (starts_map) {
    last_fix_ = Fix{outcome.stamp, outcome.odom_from_base, Eigen::Matrix3d::Zero()};
  } else if (outcome.match.accepted()) {
    last_fix_ = Fix{outcome.stamp, outcome.odom_from_base, outcome.match.covariance};
  }
}

MatchResult LaserOdometry::match(const PointScan& scan, const Pose2& guess,
                                 const Eigen::Matrix3d& prior) const {
  const MatchProblem problem{
      scan, guess, prior, reference_.map.field, reference_.key_scans, mix_seed(seed_, scan_count_)};
  if (scan.points.size() < static_cast<std::size_t>(settings_.odometry.min_points)) {
    return rejected(problem, MatchStatus::kRejectedTooFewPoints);
  }
  return reference_.key_scans.empty() ? rejected(problem, MatchStatus::kRejectedNoReference)
                                      : matcher_->match(problem);
}

void LaserOdometry::count_failures(MatchStatus status) {
  if (status == MatchStatus::kAccepted || status == MatchStatus::kRejectedNoReference) {
    scans_without_match_ = 0;
    misfits_ = 0;
    return;
  }
  ++scans_without_match_;
  // A laser that is covered for a while may well see the same place again afterwards.
  misfits_ += status == MatchStatus::kRejectedTooFewPoints ? 0 : 1;
}

MotionEstimate LaserOdometry::guess_motion(const ScanInput& input) const {
  if (!last_) {
    return {};
  }
  const bool is_sensed = input.odometry && last_->sensed_odom_from_base;
  if (guess_ == GuessSource::kOdometry && is_sensed) {
    return motion_from_odometry(*last_->sensed_odom_from_base, input.odometry->odom_from_base,
                                settings_.motion);
  }
  MotionEstimate guess = motion_at_constant_velocity(
      last_->motion, last_->interval, input.scan.stamp - last_->stamp, settings_.motion);
  if (guess_ == GuessSource::kHeading && is_sensed) {
    guess.previous_from_current.theta =
        wrap_angle(input.odometry->odom_from_base.theta - last_->sensed_odom_from_base->theta);
    guess.covariance(2, 2) = square(settings_.odometry.heading_floor);
  }
  return guess;
}

Pose2 LaserOdometry::motion_during_scan(const ScanInput& input) const {
  if (guess_ == GuessSource::kOdometry && input.odometry) {
    return input.odometry->odom_from_base.inverse() * input.odometry->odom_from_base_last_beam;
  }
  Pose2 motion;
  if (last_ && last_->interval > 0.0) {
    motion = interpolate(Pose2{}, last_->motion, input.scan.duration() / last_->interval);
  }
  if (guess_ == GuessSource::kHeading && input.odometry) {
    motion.theta = wrap_angle(input.odometry->odom_from_base_last_beam.theta -
                              input.odometry->odom_from_base.theta);
  }
  return motion;
}

/// As SlamEngine::predicted_sweep.
double LaserOdometry::predicted_sweep(const ScanInput& input) const {
  const bool is_measured = guess_ == GuessSource::kOdometry && input.odometry;
  const double passed = last_fix_ && !is_measured ? input.scan.stamp - last_fix_->stamp : 0.0;
  return passed > 0.0 ? std::max(0.0, input.scan.duration() / passed) : 0.0;
}

bool LaserOdometry::is_key_scan(const LaserOdometryOutcome& outcome) const {
  constexpr double kEnoughWithLittleOverlap = 1.0 / 3.0;
  const LaserOdometryOptions& options = settings_.odometry;
  double moved = std::numeric_limits<double>::infinity();  // from the nearest, 1: enough
  for (const auto& key : reference_.key_scans) {
    const Pose2 key_from_base = key->map_from_base.inverse() * outcome.odom_from_base;
    moved = std::min(moved, std::max(key_from_base.translation().norm() / options.key_distance,
                                     std::abs(key_from_base.theta) / options.key_angle));
  }
  return moved >= 1.0 ||
         (moved >= kEnoughWithLittleOverlap && outcome.match.score < options.key_overlap);
}

void LaserOdometry::add_key_scan(const PointScan& scan, const Pose2& odom_from_base) {
  const auto full = static_cast<std::size_t>(settings_.odometry.key_scans);
  const auto key = std::make_shared<const KeyScan>(scan, odom_from_base);
  const auto add = [&](LocalMap& local) {
    insert_scan(scan, odom_from_base, settings_.map, local.map);
    local.key_scans.push_back(key);
  };
  const bool overlaps = reference_.key_scans.size() >= full;
  add(reference_);
  if (overlaps) {
    add(next_);
  }
  if (next_.key_scans.size() >= full) {
    reference_ = std::exchange(next_, empty_map());
  }
}

void LaserOdometry::set_velocity(const MotionEstimate& guess, LaserOdometryOutcome& outcome) const {
  if (!last_) {
    outcome.velocity_covariance = kUnknownVariance * Eigen::Matrix3d::Identity();
    return;
  }
  MotionEstimate motion = guess;
  double interval = outcome.stamp - last_->stamp;
  if (outcome.match.accepted() && last_fix_) {
    // From fix to fix: what errors the guesses in between added up is no motion.
    motion.previous_from_current = last_fix_->odom_from_base.inverse() * outcome.odom_from_base;
    motion.covariance = between_covariance(last_fix_->odom_from_base, last_fix_->covariance,
                                           outcome.odom_from_base, outcome.match.covariance);
    interval = outcome.stamp - last_fix_->stamp;
  }
  const Pose2& moved = motion.previous_from_current;
  const Eigen::Matrix3d to_velocity = velocity_from_motion(moved.theta, interval);
  outcome.velocity = to_velocity * Eigen::Vector3d(moved.x, moved.y, moved.theta);
  outcome.velocity_covariance =
      symmetric(to_velocity * motion.covariance * to_velocity.transpose());
}

void LaserOdometry::set_motion(const LaserOdometryOutcome& outcome, State& now) const {
  if (outcome.match.accepted() && last_fix_) {
    now.motion = last_fix_->odom_from_base.inverse() * outcome.odom_from_base;
    now.interval = outcome.stamp - last_fix_->stamp;
  } else if (last_ && scans_without_match_ < settings_.odometry.lost_after) {
    now.motion = last_->motion;
    now.interval = last_->interval;
  }
}

LaserOdometry::LocalMap LaserOdometry::empty_map() const {
  return {SlamMap(settings_.map, settings_.field), {}};
}

std::size_t LaserOdometry::bytes() const {
  std::size_t bytes = 0;
  for (const LocalMap* local : {&reference_, &next_}) {
    bytes += local->map.occupancy.bytes() + local->map.field.bytes();
  }
  return bytes + key_errors_.bytes();
}

}  // namespace matchbox_slam
