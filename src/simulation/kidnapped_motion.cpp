#include "simulation/kidnapped_motion.hpp"

#include <algorithm>
#include <iterator>
#include <string>

#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/common/random.hpp"

namespace matchbox_slam {
namespace {

/// A time of the drive at which it is far enough from a place.
double draw_place(const RobotMotion& motion, const Pose2& world_from_taken, const Fault& fault,
                  Random& random) {
  constexpr int kMostTries = 1000;
  for (int i = 0; i < kMostTries; ++i) {
    const double time = random.uniform(0.0, motion.duration());
    const Pose2 there = motion.pose(time);
    if ((there.translation() - world_from_taken.translation()).norm() >= fault.amount) {
      return time;
    }
  }
  throw ConfigurationError("fault '" + to_string(fault) +
                           "': no place of the robot's way is so far from where it is taken up; "
                           "give a smaller amount or another time");
}

}  // namespace

KidnappedMotion::KidnappedMotion(const RobotMotion& motion, const std::vector<Fault>& faults,
                                 std::uint64_t seed)
    : motion_(motion) {
  std::vector<Fault> kidnaps;
  std::copy_if(faults.begin(), faults.end(), std::back_inserter(kidnaps),
               [](const Fault& fault) { return fault.kind == FaultKind::kKidnap; });
  std::stable_sort(kidnaps.begin(), kidnaps.end(),
                   [](const Fault& a, const Fault& b) { return a.time < b.time; });
  Random random(seed);
  Carried last{};  // as if it had been put down where the drive begins
  for (const Fault& fault : kidnaps) {
    const double begin = std::max(fault.time, last.end);
    const double route_from = last.route_to + (begin - last.end);
    const double route_to = draw_place(motion, motion.pose(route_from), fault, random);
    last = {begin, begin + fault.duration, route_from, route_to,
            last.wheels_from_world * motion.pose(route_from) * motion.pose(route_to).inverse()};
    carried_.push_back(last);
  }
}

const KidnappedMotion::Carried* KidnappedMotion::last_before(double since_start) const {
  const auto after =
      std::upper_bound(carried_.begin(), carried_.end(), since_start,
                       [](double time, const Carried& carried) { return time < carried.begin; });
  return after == carried_.begin() ? nullptr : &*(after - 1);
}

Pose2 KidnappedMotion::pose(double since_start) const {
  const Carried* carried = last_before(since_start);
  if (carried == nullptr) {
    return motion_.pose(since_start);
  }
  if (since_start >= carried->end) {
    return motion_.pose(carried->route_to + (since_start - carried->end));
  }
  return interpolate(motion_.pose(carried->route_from), motion_.pose(carried->route_to),
                     (since_start - carried->begin) / (carried->end - carried->begin));
}

Pose2 KidnappedMotion::pose_on_wheels(double since_start) const {
  const Carried* carried = last_before(since_start);
  if (carried == nullptr) {
    return motion_.pose(since_start);
  }
  const double put_down = std::max(since_start, carried->end);
  return carried->wheels_from_world * pose(put_down);
}

}  // namespace matchbox_slam
