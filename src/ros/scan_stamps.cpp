#include "ros/scan_stamps.hpp"

#include <algorithm>

#include "ros/message_conversion.hpp"

namespace matchbox_slam {
namespace {

// A stamp that is this much farther ahead of the time of arrival than the one before [s] is wrong,
// or tells of another clock. Believed at once, it would make all that follow seem older than it.
constexpr double kLeap = 60.0;  // a guess: half and double were not tried

// Scans in a row, each later than the one before, that tell a clock that was set back from a stamp
// that is wrong.
constexpr int kScansOfATimeJump = 3;  // a guess: half and double were not tried

// For so long after a time jump slow lasers send scans from before it [s].
constexpr double kStraggleTime = 2.0;  // a guess: half and double were not tried

}  // namespace

bool ScanStamps::is_straggler(const ros::Time& stamp, const ros::Time& now) const {
  return straggling_ && now.toSec() < straggling_->last_arrival &&
         stamp.toSec() > straggling_->least_stamp;
}

bool ScanStamps::is_set_back(const ros::Time& stamp, int laser, const ros::Time* used) {
  Laser& of = by_laser_.at(static_cast<std::size_t>(laser));
  if (used == nullptr || !of.newest || seconds_between(stamp, *used) <= kTimeJump ||
      seconds_between(stamp, *of.newest) <= kTimeJump) {
    of.old_in_a_row = 0;
    return false;
  }
  of.old_in_a_row = of.old_in_a_row > 0 && stamp > of.last_old ? of.old_in_a_row + 1 : 1;
  of.last_old = stamp;
  return of.old_in_a_row >= kScansOfATimeJump;
}

bool ScanStamps::leaps_ahead(const ros::Time& stamp, const ros::Time& now) {
  const double lead = seconds_between(now, stamp);
  const bool leaps = lead_ && !now.isZero() && lead > *lead_ + kLeap;
  leaps_in_a_row_ = leaps ? leaps_in_a_row_ + 1 : 0;
  if (leaps && leaps_in_a_row_ < kScansOfATimeJump) {
    return true;
  }
  lead_ = now.isZero() ? lead_ : lead;
  return false;
}

void ScanStamps::note(const ros::Time& stamp, int laser) {
  first_ = first_.value_or(stamp);
  Laser& of = by_laser_.at(static_cast<std::size_t>(laser));
  of.newest = std::max(of.newest.value_or(stamp), stamp);
}

bool ScanStamps::is_next(const ros::Time& stamp) const {
  return std::all_of(by_laser_.begin(), by_laser_.end(), [&](const Laser& laser) {
    // Those not heard of count as just before the first scan.
    const ros::Time newest = laser.newest.value_or(first_.value_or(stamp) - ros::Duration(0, 1));
    return newest >= stamp || seconds_between(newest, stamp) > kPatienceWithLasers;
  });
}

void ScanStamps::jump_back(double seconds, const ros::Time& now) {
  std::optional<ros::Time> newest;
  for (const Laser& laser : by_laser_) {
    newest = std::max(newest, laser.newest);
  }
  *this = ScanStamps(static_cast<int>(lasers_));
  if (newest) {
    straggling_ = Straggling{newest->toSec() - 0.25 * seconds,
                             now.toSec() + std::min(kStraggleTime, 0.5 * seconds)};
  }
}

}  // namespace matchbox_slam
