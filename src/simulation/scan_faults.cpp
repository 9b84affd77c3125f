#include "simulation/scan_faults.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "matchbox_slam/common/random.hpp"

namespace matchbox_slam {
namespace {

/// Beams side by side from `first` on, around the scan's end to its beginning.
template <typename Change>
void for_beams(double first, double count, LaserScan& scan, const Change& change) {
  const auto beams = static_cast<double>(scan.ranges.size());
  for (double k = 0.0; k < count; k += 1.0) {
    const double beam = std::floor(std::fmod(first + k, beams));
    change(scan.ranges[static_cast<std::size_t>(beam)]);
  }
}

void cover(const Fault& fault, std::uint64_t seed, LaserScan& scan) {
  constexpr float kDistance = 0.05F;  // [m]
  const auto beams = static_cast<double>(scan.ranges.size());
  const double first = Random(seed).uniform(0.0, beams);
  for_beams(first, std::round(fault.amount * beams), scan, [](float& range) { range = kDistance; });
}

void add_people(double since_start, const Fault& fault, std::uint64_t seed, LaserScan& scan) {
  constexpr double kWidth = 0.05;  // share of the scan's beams that one person hides
  // Share of the scan's beams passed by one person in a second.
  constexpr double kMaxCrossingRate = 0.1;
  constexpr double kFarthest = 8.0;  // [m]; behind them a wall, or nothing
  const auto beams = static_cast<double>(scan.ranges.size());
  const auto people = static_cast<int>(std::ceil(fault.amount / kWidth));
  for (int i = 0; i < people; ++i) {
    Random random(mix_seed(seed, static_cast<std::uint64_t>(i)));
    // Spread evenly, so that they hide the share that is asked for.
    const double start = (i + random.uniform()) / people;
    const double wander = kMaxCrossingRate * random.uniform(-1.0, 1.0) * (since_start - fault.time);
    const double share = random.uniform(0.2, 0.9);
    const double place = start + wander - std::floor(start + wander);
    for_beams(place * beams, std::round(fault.amount / people * beams), scan, [&](float& range) {
      // What is no reading, NaN or -inf, stays so.
      range = static_cast<float>(share * std::min(static_cast<double>(range), kFarthest));
    });
  }
}

}  // namespace

void add_scan_faults(double since_start, const std::vector<Fault>& faults, std::uint64_t seed,
                     LaserScan& scan) {
  for (std::size_t i = 0; i < faults.size(); ++i) {
    const Fault& fault = faults[i];
    if (scan.ranges.empty() || !fault.is_on(since_start)) {
      continue;
    }
    if (fault.kind == FaultKind::kCovered) {
      cover(fault, mix_seed(seed, i), scan);
    } else if (fault.kind == FaultKind::kPeople) {
      add_people(since_start, fault, mix_seed(seed, i), scan);
    }
  }
}

}  // namespace matchbox_slam
