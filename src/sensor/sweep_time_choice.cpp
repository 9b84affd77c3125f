#include "sensor/sweep_time_choice.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "common/number_text.hpp"
#include "matchbox_slam/common/parameters.hpp"
#include "matchbox_slam/geometry/angles.hpp"

namespace matchbox_slam {
namespace {

// A laser that sees so much turns all round.
constexpr double kMinFullTurn = degrees_to_radians(330.0);
constexpr std::size_t kMostGaps = 9;
constexpr double kSlowestScan = 0.5;    // s: rarer scans are not all that the laser took
constexpr double kFastestSweep = 0.02;  // s: a laser that turns all round takes longer
// What a sweep that can be lasts, of the time from scan to scan.
constexpr double kMinSweepShare = 0.5;
constexpr double kMaxSweepShare = 1.1;

constexpr double kMotionTime = 0.2;  // s at most, over which odometry tells how fast the robot is
constexpr std::size_t kMostTurningScans = 30;  // of the turning robot that are asked
constexpr double kLikelyTolerance = 0.25;  // of the period: so near to what is likely, it is that

// What scans tell is off by more than their noise (measured: twice, and 0.02 s), and now and then
// all wrong, so that none counts for more than so much.
constexpr double kNoiseFactor = 2.0;
constexpr double kLeastSweepDeviation = 0.02;  // s
constexpr double kMaxToldLogOdds = 3.0;
constexpr double kDecisiveLogOdds = 2.0;
// Log odds, before any scan, against a sweep that is neither sent nor lasts from scan to scan, as
// where scans were left out. With half of it, and half or one and a half times what one scan
// counts for, much the same (benchmark/reports/current/RECORDINGS.md).
constexpr double kPriorLogOdds = 3.0;
constexpr double kSameSweep = 1e-3;  // s

double beams_of(const LaserScan& scan) { return static_cast<double>(scan.ranges.size()); }

/// [s]
double deviation_of(const ToldSweepTime& told) {
  return std::hypot(kNoiseFactor * told.deviation, kLeastSweepDeviation);
}

}  // namespace

void SweepTimeChoice::note_stamp(double stamp) {
  if (last_stamp_ && stamp > *last_stamp_) {
    gaps_.push_back(stamp - *last_stamp_);
    if (gaps_.size() > kMostGaps) {
      gaps_.pop_front();
    }
  }
  last_stamp_ = stamp;
}

/// [s] from scan to scan, the median of the latest.
std::optional<double> SweepTimeChoice::period() const {
  if (gaps_.empty()) {
    return std::nullopt;
  }
  std::vector<double> gaps(gaps_.begin(), gaps_.end());
  const auto middle = gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2);
  std::nth_element(gaps.begin(), middle, gaps.end());
  return *middle;
}

bool SweepTimeChoice::may_be_looked_at(const LaserScan& scan) const {
  return !setting_.as_sent && !setting_.seconds && scan.ranges.size() > 1 &&
         std::abs(scan.angle_increment) * beams_of(scan) >= kMinFullTurn;
}

/// Where most scans are left out, the time between them says nothing of a sweep.
bool SweepTimeChoice::can_be(const LaserScan& as_sent, double sent_scan_time) const {
  const double sweep = as_sent.time_increment * beams_of(as_sent);
  if (period() && *period() > kSlowestScan && sweep >= kFastestSweep && sweep <= kSlowestScan) {
    return true;
  }
  const auto fits = [&](double period) {
    return sweep >= kMinSweepShare * period && sweep <= kMaxSweepShare * period;
  };
  return (sent_scan_time > 0.0 && fits(sent_scan_time)) || (period() && fits(*period()));
}

double SweepTimeChoice::time_increment(const LaserScan& as_sent, double sent_scan_time) {
  if (setting_.seconds) {
    is_believed_ = true;
    return as_sent.ranges.size() > 1 ? *setting_.seconds / (beams_of(as_sent) - 1.0) : 0.0;
  }
  is_believed_ = !may_be_looked_at(as_sent);
  if (is_believed_) {
    return as_sent.time_increment;
  }
  note_stamp(as_sent.stamp);
  if (settled_) {
    return *settled_ / (beams_of(as_sent) - 1.0);
  }
  const std::optional<double> from_scan_to_scan = period();
  is_doubtful_ = from_scan_to_scan && !can_be(as_sent, sent_scan_time);
  // All beams at once is what a camera or a simulator may do; a sweep that is shorter than any
  // laser turns is not.
  if (!is_doubtful_ || as_sent.time_increment == 0.0 || *from_scan_to_scan > kSlowestScan) {
    return as_sent.time_increment;
  }
  if (!std::exchange(has_told_, true)) {
    news_ = "the times that scans tell cannot be: " + std::to_string(as_sent.ranges.size()) +
            " beams " + to_string(as_sent.time_increment) + " s apart make a sweep of " +
            fixed_text(as_sent.time_increment * beams_of(as_sent), 3) +
            " s, and scans of the whole turn come every " + fixed_text(*from_scan_to_scan, 3) +
            " s; taken as the sweep until scans tell otherwise; scan/sweep_time sets it";
  }
  return *from_scan_to_scan / beams_of(as_sent);
}

void SweepTimeChoice::note_pose(
    double stamp, const Pose2& odom_from_base,
    const std::function<std::optional<Pose2>(double stamp)>& odom_from_base_at) {
  const double gap = last_ ? stamp - last_->scan.stamp : 0.0;
  if (is_final_ || !is_doubtful_ || gap <= 0.0) {
    return;
  }
  const double time = std::min(gap, kMotionTime);
  const std::optional<Pose2> then =
      gap > kMotionTime ? odom_from_base_at(last_->scan.stamp + time) : odom_from_base;
  if (then) {
    const Pose2 motion = last_->odom_from_base.inverse() * *then;
    last_->velocity = motion.translation() / time;
    last_->turn_rate = motion.theta / time;
    const double beams = beams_of(last_->scan);
    const double whole = *period() * (beams - 1.0) / beams;
    if (const std::optional<ToldSweepTime> told = estimator_.add(*last_)) {
      told_.push_back(*told);
      decide(whole);
    }
  }
  last_.reset();
}

void SweepTimeChoice::add(const LaserScan& scan, double sent_increment,
                          const Eigen::Isometry3d& base_from_laser, const Pose2& odom_from_base) {
  last_.reset();
  if (may_be_looked_at(scan) && !is_final_) {
    last_ = MovingScan{scan, base_from_laser, odom_from_base, Eigen::Vector2d::Zero(), 0.0};
    sent_ = sent_increment * (beams_of(scan) - 1.0);
  }
}

/// Of a sweep against the one that is sent.
double SweepTimeChoice::log_likelihood_ratio(double sweep) const {
  double of_turning = 0.0;
  double of_driving = 0.0;
  for (const ToldSweepTime& told : told_) {
    const auto misfit = [&told](double one) {  // of Gauss
      const double off = (told.seconds - one) / deviation_of(told);
      return std::min(0.5 * off * off, kMaxToldLogOdds);
    };
    (told.is_turning ? of_turning : of_driving) += misfit(sent_) - misfit(sweep);
  }
  // Driving straight on may look like no sweep whatever there is, never like a sweep that is not.
  return of_turning + std::max(0.0, of_driving);
}

/// [s], the mean of what agrees with the likeliest that was told, each by how well it tells.
double SweepTimeChoice::likeliest() const {
  constexpr double kMaxDeviations = 2.0;  // a guess
  const ToldSweepTime& best = *std::max_element(
      told_.begin(), told_.end(), [this](const ToldSweepTime& a, const ToldSweepTime& b) {
        return log_likelihood_ratio(a.seconds) < log_likelihood_ratio(b.seconds);
      });
  double sum = 0.0;
  double weights = 0.0;
  for (const ToldSweepTime& told : told_) {
    if (std::abs(told.seconds - best.seconds) <= kMaxDeviations * deviation_of(told)) {
      const double weight = 1.0 / (deviation_of(told) * deviation_of(told));
      sum += weight * told.seconds;
      weights += weight;
    }
  }
  return std::max(0.0, sum / weights);
}

/// What is sent and the whole time from scan to scan are likely, and the likelier is taken until
/// others say otherwise. It takes more to believe anything else.
void SweepTimeChoice::decide(double whole) {
  const double told = likeliest();
  const double near = kLikelyTolerance * std::min(*period(), kMotionTime);
  const auto is_likely = [&](double sweep) {
    return std::min(std::abs(sweep - sent_), std::abs(sweep - whole)) < near;
  };
  const double for_whole = log_likelihood_ratio(whole);
  const double for_likely = std::max(0.0, for_whole);
  const double for_told =
      is_likely(told) ? -kPriorLogOdds : log_likelihood_ratio(told) - kPriorLogOdds;
  is_final_ = estimator_.turning_scans() >= kMostTurningScans;
  const bool is_taken_back = settled_ && !is_likely(*settled_) && for_likely >= for_told;
  if (!is_likely(told) && (is_final_ || for_told - for_likely >= kDecisiveLogOdds)) {
    settle(told, told, "");
  } else if (is_final_ || is_taken_back ||
             (std::abs(for_whole) >= kDecisiveLogOdds && for_likely >= for_told)) {
    const bool is_whole =
        is_final_ ? std::abs(told - whole) < std::abs(told - sent_) : for_whole > 0;
    settle(is_whole ? whole : sent_, told, is_whole ? ", as from scan to scan" : ", as they tell");
  }
  if (is_final_) {
    estimator_ = {};
    told_.clear();
  }
}

/// People are told again only of what changes by more than one scan may be off.
/// @param which  of the likely ones it is, for people.
void SweepTimeChoice::settle(double sweep, double told, const std::string& which) {
  settled_ = sweep;
  finding_scans_ = told_.size();
  finding_ = "scans of the moving robot show a sweep of " + fixed_text(told, 3) +
             " s from the first beam to the last, and messages tell " + fixed_text(sent_, 3) +
             " s; taken is " + fixed_text(sweep, 3) + " s" + which +
             "; scan/sweep_time sets it, as_sent for what messages tell";
  if (known_ ? std::abs(sweep - *known_) <= kLeastSweepDeviation
             : !has_told_ && std::abs(sweep - sent_) <= kSameSweep) {
    return;
  }
  known_ = sweep;
  has_told_ = true;
  news_ = finding_;
}

bool SweepTimeChoice::is_open() const {
  return is_undecided() || (!is_believed_ && !is_final_ && gaps_.size() < kMostGaps);
}

std::optional<ShownSweep> SweepTimeChoice::shown() const {
  if (!settled_) {
    return std::nullopt;
  }
  return ShownSweep{*settled_, finding_scans_,
                    std::abs(*settled_ - sent_) > kSameSweep ? finding_ : ""};
}

std::string SweepTimeChoice::take_news() { return std::exchange(news_, {}); }

}  // namespace matchbox_slam
