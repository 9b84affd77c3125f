#include "matchbox_slam/odometry/laser_odometry.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/geometry/pose_covariance.hpp"
#include "motion/motion_tracker.hpp"
#include "odometry/local_map_covariance.hpp"

namespace matchbox_slam {
namespace {

// The first pose is known by definition; but a covariance that cannot be inverted would stop
// filters.
constexpr double kOriginVariance = 1e-8;  // 0.1 mm, 0.1 mrad

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

}  // namespace

LaserOdometrySettings read_laser_odometry_settings(const Parameters& parameters) {
  const EngineOptions engine = read_engine_options(parameters);
  return {read_options<LaserOdometryOptions>(parameters.section("odometry"), "odometry"),
          engine.scan, engine.map, engine.field, engine.motion};
}

class LaserOdometry::Parts {
 public:
  Parts(const LaserOdometrySettings& settings, std::shared_ptr<const ScanMatcher> matcher,
        GuessSource guess, std::uint64_t seed);

  LaserOdometryOutcome process(const ScanInput& input);
  [[nodiscard]] const PlacedScans& key_scans() const { return reference_.key_scans; }
  [[nodiscard]] std::size_t bytes() const;

 private:
  struct Submap {
    SlamMap map;
    PlacedScans key_scans;
  };

  [[nodiscard]] MatchResult match(const PointScan& scan, const MotionPrediction& guess) const;
  [[nodiscard]] bool is_key_scan(const LaserOdometryOutcome& outcome) const;
  [[nodiscard]] Submap empty_map() const;
  void count_failures(MatchStatus status);
  void add_key_scan(const PointScan& scan, MeasuredScan measured, int laser,
                    const LaserOdometryOutcome& outcome);
  void set_velocity(const MotionEstimate& guess, LaserOdometryOutcome& outcome) const;
  void remember(const ScanInput& input, const MotionPrediction& guess,
                const LaserOdometryOutcome& outcome, bool starts_map);

  LaserOdometrySettings settings_;
  std::shared_ptr<const ScanMatcher> matcher_;
  std::uint64_t seed_;
  std::uint64_t scan_count_ = 0;
  /// Its covariance is that in the local map, counted from the newest key scan on.
  MotionTracker tracker_;
  Eigen::Matrix3d fix_covariance_ = Eigen::Matrix3d::Zero();  ///< in the local map
  std::shared_ptr<KeyScanCache> cache_ = make_key_scan_cache();
  std::uint64_t key_scan_count_ = 0;
  Submap reference_;  ///< that scans are matched against
  Submap next_;       ///< that takes over when it is full
  LocalMapCovariance
      local_covariance_;         ///< of the reference's key scans, or of where the base was before
  int scans_without_match_ = 0;  ///< in a row
  int misfits_ = 0;              ///< those of them that had enough points
};

LaserOdometry::Parts::Parts(const LaserOdometrySettings& settings,
                            std::shared_ptr<const ScanMatcher> matcher, GuessSource guess,
                            std::uint64_t seed)
    : settings_(settings),
      matcher_(std::move(matcher)),
      seed_(seed),
      tracker_(settings.motion, guess, settings.odometry.heading_floor),
      reference_(empty_map()),
      next_(empty_map()),
      local_covariance_(Pose2{}, kOriginVariance * Eigen::Matrix3d::Identity()) {}

LaserOdometryOutcome LaserOdometry::Parts::process(const ScanInput& input) {
  const MotionPrediction guess = tracker_.predict(input);
  MeasuredScan measured{input.scan, input.base_from_laser, guess.during_scan, settings_.scan,
                        input.laser_motion};
  PointScan scan = project_scan(measured);

  // A rejected match carries the guess, which stands then.
  LaserOdometryOutcome outcome;
  outcome.match = match(scan, guess);
  const MatchedMotion matched = tracker_.after_match(input, guess, outcome.match);
  outcome.stamp = input.scan.stamp;
  outcome.odom_from_base = matched.fixed_from_base;
  outcome.guessed_odom_from_base = guess.fixed_from_base;
  local_covariance_.follow(outcome.odom_from_base, guess.covariance, outcome.match.covariance);
  outcome.covariance = symmetric(local_covariance_.covariance());
  set_velocity(guess.motion, outcome);
  ++scan_count_;
  count_failures(outcome.match.status);

  outcome.restarted = misfits_ >= settings_.odometry.lost_after;
  if (outcome.restarted) {
    reference_ = empty_map();
    next_ = empty_map();
    misfits_ = 0;
  }
  const bool starts_map =
      reference_.key_scans.empty() && outcome.match.status != MatchStatus::kRejectedTooFewPoints;
  outcome.is_key_scan = starts_map || (outcome.match.accepted() && is_key_scan(outcome));
  if (outcome.is_key_scan) {
    if (matched.during_scan != guess.during_scan) {
      measured.motion = matched.during_scan;
      scan = project_scan(measured);
    }
    add_key_scan(scan, std::move(measured), input.laser, outcome);
  }
  remember(input, guess, outcome, starts_map);
  return outcome;
}

void LaserOdometry::Parts::remember(const ScanInput& input, const MotionPrediction& guess,
                                    const LaserOdometryOutcome& outcome, bool starts_map) {
  const Eigen::Matrix3d nothing = Eigen::Matrix3d::Zero();
  const bool is_fix = starts_map || outcome.match.accepted();
  tracker_.remember(input, guess, outcome.odom_from_base,
                    outcome.is_key_scan ? nothing : outcome.match.covariance, is_fix);
  if (is_fix) {
    fix_covariance_ = starts_map ? nothing : outcome.match.covariance;
  }
  if (scans_without_match_ >= settings_.odometry.lost_after) {
    tracker_.forget_motion();
  }
}

MatchResult LaserOdometry::Parts::match(const PointScan& scan,
                                        const MotionPrediction& guess) const {
  const MatchProblem problem{scan,
                             guess.fixed_from_base,
                             guess.covariance,
                             reference_.map.field,
                             reference_.key_scans,
                             mix_seed(seed_, scan_count_)};
  if (scan.points.size() < static_cast<std::size_t>(settings_.odometry.min_points)) {
    return rejected(problem, MatchStatus::kRejectedTooFewPoints);
  }
  return reference_.key_scans.empty() ? rejected(problem, MatchStatus::kRejectedNoReference)
                                      : matcher_->match(problem);
}

void LaserOdometry::Parts::count_failures(MatchStatus status) {
  if (status == MatchStatus::kAccepted || status == MatchStatus::kRejectedNoReference) {
    scans_without_match_ = 0;
    misfits_ = 0;
    return;
  }
  ++scans_without_match_;
  // A laser that is covered for a while may well see the same place again afterwards.
  misfits_ += status == MatchStatus::kRejectedTooFewPoints ? 0 : 1;
}

bool LaserOdometry::Parts::is_key_scan(const LaserOdometryOutcome& outcome) const {
  constexpr double kEnoughWithLittleOverlap = 1.0 / 3.0;  // a guess: half and double were not tried
  const LaserOdometryOptions& options = settings_.odometry;
  double moved = std::numeric_limits<double>::infinity();  // from the nearest, 1: enough
  for (const PlacedScan& key : reference_.key_scans) {
    const Pose2 key_from_base = key.map_from_base.inverse() * outcome.odom_from_base;
    moved = std::min(moved, std::max(key_from_base.translation().norm() / options.key_distance,
                                     std::abs(key_from_base.theta) / options.key_angle));
  }
  return moved >= 1.0 ||
         (moved >= kEnoughWithLittleOverlap && outcome.match.score < options.key_overlap);
}

void LaserOdometry::Parts::add_key_scan(const PointScan& scan, MeasuredScan measured, int laser,
                                        const LaserOdometryOutcome& outcome) {
  if (reference_.key_scans.empty()) {
    local_covariance_ = LocalMapCovariance(outcome.odom_from_base, outcome.covariance);
  } else {
    local_covariance_.add();
  }
  const auto full = static_cast<std::size_t>(settings_.odometry.local_map_scans);
  const PlacedScan key{
      std::make_shared<const KeyScan>(std::move(measured), key_scan_count_++, laser, cache_),
      outcome.odom_from_base};
  const auto add = [&](Submap& local) {
    insert_scan(scan, outcome.odom_from_base, settings_.map, local.map);
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
  local_covariance_.keep_newest(reference_.key_scans.size());
}

void LaserOdometry::Parts::set_velocity(const MotionEstimate& guess,
                                        LaserOdometryOutcome& outcome) const {
  const MotionState& before = tracker_.state();
  if (!before.stamp || outcome.stamp == *before.stamp) {
    outcome.velocity_covariance = kUnknownVariance * Eigen::Matrix3d::Identity();
    return;
  }
  MotionEstimate motion = guess;
  motion.covariance += guess.floor;
  double interval = outcome.stamp - *before.stamp;
  if (outcome.match.accepted() && before.fix) {
    // From fix to fix: what errors the guesses in between added up is no motion.
    const Pose2& fix = before.fix->fixed_from_base;
    motion.previous_from_current = fix.inverse() * outcome.odom_from_base;
    motion.covariance =
        between_covariance(fix, fix_covariance_, outcome.odom_from_base, outcome.match.covariance);
    interval = outcome.stamp - before.fix->stamp;
  }
  const Pose2& moved = motion.previous_from_current;
  const Eigen::Matrix3d to_velocity = velocity_from_motion(moved.theta, interval);
  outcome.velocity = to_velocity * Eigen::Vector3d(moved.x, moved.y, moved.theta);
  outcome.velocity_covariance =
      symmetric(to_velocity * motion.covariance * to_velocity.transpose());
}

LaserOdometry::Parts::Submap LaserOdometry::Parts::empty_map() const {
  return {SlamMap(settings_.map, settings_.field), {}};
}

std::size_t LaserOdometry::Parts::bytes() const {
  std::size_t bytes = 0;
  for (const Submap* local : {&reference_, &next_}) {
    bytes += local->map.occupancy.bytes() + local->map.field.bytes();
  }
  return bytes + local_covariance_.bytes();
}

// --- what is seen of it ---

LaserOdometry::LaserOdometry(const LaserOdometrySettings& settings,
                             std::shared_ptr<const ScanMatcher> matcher, GuessSource guess,
                             std::uint64_t seed)
    : parts_(std::make_unique<Parts>(settings, std::move(matcher), guess, seed)) {}

LaserOdometry::LaserOdometry(LaserOdometry&& other) noexcept = default;
LaserOdometry& LaserOdometry::operator=(LaserOdometry&& other) noexcept = default;
LaserOdometry::~LaserOdometry() = default;

LaserOdometryOutcome LaserOdometry::process(const ScanInput& input) {
  return parts_->process(input);
}

const PlacedScans& LaserOdometry::key_scans() const { return parts_->key_scans(); }

std::size_t LaserOdometry::bytes() const { return parts_->bytes(); }

}  // namespace matchbox_slam
