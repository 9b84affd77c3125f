#include "sensor/max_range_detector.hpp"

#include <algorithm>
#include <array>
#include <bitset>
#include <cmath>
#include <iterator>
#include <limits>

namespace matchbox_slam {
namespace {

// Guesses: half and double were not tried.
// [m], of the pile, kDeviations of 6 cm to either side, and of what lies below it.
constexpr double kWidth = 0.6;
constexpr std::size_t kFewestScans = 20;  // and after how many more it is looked for again
// What is looked at: so long [s] and so many scans, but no longer than that. Logs with a scan each
// metre have so many after minutes.
constexpr double kSeconds = 10.0;
constexpr std::size_t kScans = 100;
constexpr double kMaxSeconds = 120.0;
constexpr std::size_t kMostScans = 5000;  // of which stamps may stand still
constexpr double kMinPileShare = 0.25;    // share of scans that have a reading of the pile
constexpr double kContrast = 5.0;         // to what lies below, on the same width
// Added to what lies below: none seen there says little beside a pile of a few.
constexpr std::size_t kPriorBelow = 10;
constexpr double kDeviations = 5.0;
constexpr double kLeastDeviation = 3e-3;  // [m], of ranges that are rounded to 1 cm
constexpr std::size_t kSectors = 12;
constexpr std::size_t kFewestSectors = 8;
constexpr float kMinChange = 0.5F;  // [m], of what else is seen
// Of a pile below range_max: arcs of one scan with holes between, how fine they are told apart, and
// how many scans have so many. A wall that is met head-on is one arc, both ends of a corridor are
// two, and as the robot turns they go through all directions. In 3,600 simulated turns no scan had
// three; from any start of a log whose laser does so, 5 and more of 60 scans have.
constexpr std::size_t kFineSectors = 36;
constexpr std::size_t kFewestArcs = 3;
constexpr std::size_t kMinScatteredScans = 5;

using FineSectors = std::bitset<kFineSectors>;

/// Runs of neighbours, the last sector being one of the first: of a laser that turns all round it
/// is, and for others that asks for more.
std::size_t arcs_in(const FineSectors& sectors) {
  std::size_t arcs = 0;
  for (std::size_t k = 0; k < kFineSectors; ++k) {
    arcs += sectors[k] && !sectors[(k + 1) % kFineSectors] ? 1U : 0U;
  }
  return arcs;
}

/// Reorders the values.
template <typename Value>
Value median_of(std::vector<Value>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

void MaxRangeDetector::add(const LaserScan& scan) {
  if (is_complete_) {
    return;
  }
  if (median_range_.empty()) {
    range_max_ = scan.range_max;
    begin_ = scan.stamp;
  }
  if (scan.range_max != range_max_ || scan.ranges.empty()) {
    return;
  }
  add_readings(scan);
  const double seconds = scan.stamp - begin_;
  const std::size_t scans = median_range_.size();
  is_complete_ = seconds > kMaxSeconds || (scans >= kScans && seconds > kSeconds) ||
                 scans >= kMostScans || seconds < 0.0;
  if (is_complete_ || scans % kFewestScans == 0) {
    first_range_ = find_first_range();
  }
  if (first_range_ || is_complete_) {
    is_complete_ = true;
    readings_ = {};
    median_range_ = {};
  }
}

void MaxRangeDetector::add_readings(const LaserScan& scan) {
  beams_ = std::max(beams_, scan.ranges.size());
  const float largest_before = largest_;
  std::vector<float> shorter;
  for (std::size_t k = 0; k < scan.ranges.size(); ++k) {
    const float range = scan.ranges[k];
    if (!(range > 0.0F && static_cast<double>(range) < range_max_ + 0.5 * kWidth)) {
      continue;
    }
    if (static_cast<double>(range) < static_cast<double>(largest_) - 2.0 * kWidth) {
      shorter.push_back(range);
      continue;
    }
    largest_ = std::max(largest_, range);
    readings_.push_back(
        {range, static_cast<std::uint32_t>(k), static_cast<std::uint32_t>(median_range_.size())});
  }
  median_range_.push_back(shorter.empty() ? 0.0F : median_of(shorter));
  if (largest_ > largest_before) {
    drop_short_ones();
  }
}

void MaxRangeDetector::drop_short_ones() {
  const double least = static_cast<double>(largest_) - 2.0 * kWidth;
  readings_.erase(std::remove_if(readings_.begin(), readings_.end(),
                                 [least](const Reading& reading) {
                                   return static_cast<double>(reading.range) < least;
                                 }),
                  readings_.end());
}

std::optional<double> MaxRangeDetector::find_first_range() const {
  const double least = static_cast<double>(largest_) - kWidth;
  std::vector<Reading> pile;
  std::vector<Reading> below;
  std::partition_copy(
      readings_.begin(), readings_.end(), std::back_inserter(pile), std::back_inserter(below),
      [least](const Reading& reading) { return static_cast<double>(reading.range) >= least; });
  if (median_range_.size() < kFewestScans ||
      static_cast<double>(pile.size()) <
          kContrast * static_cast<double>(without_stuck_beam(below) + kPriorBelow)) {
    return std::nullopt;
  }
  const bool is_at_range_max = static_cast<double>(largest_) > range_max_ - 0.5 * kWidth;
  return is_at_range_max || (has_moved(pile) && is_scattered(pile)) ? first_of(pile) : std::nullopt;
}

/// How many there are but for those of the beam that has most: some logs have one that reads the
/// same all the time.
std::size_t MaxRangeDetector::without_stuck_beam(const std::vector<Reading>& readings) const {
  std::vector<std::size_t> of_beam(beams_ + 1, 0);
  for (const Reading& reading : readings) {
    ++of_beam[reading.beam];
  }
  return readings.size() - *std::max_element(of_beam.begin(), of_beam.end());
}

/// Whether the scans that have the pile differ in what else they show.
bool MaxRangeDetector::has_moved(const std::vector<Reading>& pile) const {
  float nearest = std::numeric_limits<float>::infinity();
  float farthest = 0.0F;
  for (const Reading& reading : pile) {
    if (const float median = median_range_[reading.scan]; median > 0.0F) {
      nearest = std::min(nearest, median);
      farthest = std::max(farthest, median);
    }
  }
  return farthest - nearest > kMinChange;
}

/// Whether enough scans have the pile in several directions at once, with something else between.
bool MaxRangeDetector::is_scattered(const std::vector<Reading>& pile) const {
  std::vector<FineSectors> sectors(median_range_.size());
  for (const Reading& reading : pile) {
    sectors[reading.scan].set(reading.beam * kFineSectors / beams_);
  }
  const auto scans = std::count_if(sectors.begin(), sectors.end(), [](const FineSectors& one) {
    return arcs_in(one) >= kFewestArcs;
  });
  return static_cast<std::size_t>(scans) >= kMinScatteredScans;
}

/// What is range_max or more is no return by itself: the others have to be many.
std::optional<double> MaxRangeDetector::first_of(const std::vector<Reading>& pile) const {
  std::array<std::size_t, kSectors> in_sector{};
  std::vector<bool> is_in_scan(median_range_.size(), false);
  std::vector<double> values;
  for (const Reading& reading : pile) {
    const auto range = static_cast<double>(reading.range);
    values.push_back(range);
    if (range < range_max_) {
      ++in_sector.at(reading.beam * kSectors / beams_);
      is_in_scan[reading.scan] = true;
    }
  }
  const auto scans = std::count(is_in_scan.begin(), is_in_scan.end(), true);
  const auto sectors = std::count_if(in_sector.begin(), in_sector.end(), [&](std::size_t count) {
    return 100 * count >= pile.size() && count > 0;
  });
  if (static_cast<double>(scans) < kMinPileShare * static_cast<double>(median_range_.size()) ||
      static_cast<std::size_t>(sectors) < kFewestSectors) {
    return std::nullopt;
  }
  const double middle = median_of(values);
  for (double& value : values) {
    value = std::abs(value - middle);
  }
  const double deviation = std::max(kLeastDeviation, 1.4826 * median_of(values));
  const double first = middle - kDeviations * deviation;
  return first > static_cast<double>(largest_) - kWidth ? std::optional(first) : std::nullopt;
}

}  // namespace matchbox_slam
