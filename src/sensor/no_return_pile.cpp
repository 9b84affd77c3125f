#include "sensor/no_return_pile.hpp"

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
constexpr std::size_t kFewestScans = 20;
constexpr double kMostScans = 0.25;  // have a reading of the pile
constexpr double kContrast = 5.0;    // to what lies below, on the same width
constexpr double kDeviations = 5.0;
constexpr std::size_t kSectors = 12;
constexpr std::size_t kFewestSectors = 8;
constexpr float kMoved = 0.5F;  // [m], of what else is seen
// Sectors of one scan, of a pile below range_max, and how many scans have so many: the end of a
// corridor fills one, or two, and as the robot turns all of them, one after the other.
constexpr std::size_t kSectorsAtOnce = 3;
constexpr std::size_t kFewestAtOnce = 10;

/// Reorders the values.
template <typename Value>
Value median_of(std::vector<Value>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

void NoReturnPile::add(const LaserScan& scan) {
  range_max_ = median_range_.empty() ? scan.range_max : range_max_;
  if (scan.range_max != range_max_ || scan.ranges.empty()) {
    return;
  }
  beams_ = std::max(beams_, scan.ranges.size());
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
  drop_short_ones();
}

void NoReturnPile::drop_short_ones() {
  const double least = static_cast<double>(largest_) - 2.0 * kWidth;
  readings_.erase(std::remove_if(readings_.begin(), readings_.end(),
                                 [least](const Reading& reading) {
                                   return static_cast<double>(reading.range) < least;
                                 }),
                  readings_.end());
}

std::optional<double> NoReturnPile::first_range() const {
  const double least = static_cast<double>(largest_) - kWidth;
  std::vector<Reading> pile;
  std::vector<Reading> below;
  std::partition_copy(
      readings_.begin(), readings_.end(), std::back_inserter(pile), std::back_inserter(below),
      [least](const Reading& reading) { return static_cast<double>(reading.range) >= least; });
  if (median_range_.size() < kFewestScans ||
      static_cast<double>(pile.size()) <
          kContrast * static_cast<double>(without_stuck_beam(below))) {
    return std::nullopt;
  }
  const bool is_at_range_max = static_cast<double>(largest_) > range_max_ - 0.5 * kWidth;
  return is_at_range_max || (has_moved(pile) && is_all_around(pile)) ? first_of(pile)
                                                                     : std::nullopt;
}

/// How many there are but for those of the beam that has most: some logs have one that reads the
/// same all the time.
std::size_t NoReturnPile::without_stuck_beam(const std::vector<Reading>& readings) const {
  std::vector<std::size_t> of_beam(beams_ + 1, 0);
  for (const Reading& reading : readings) {
    ++of_beam[reading.beam];
  }
  return readings.size() - *std::max_element(of_beam.begin(), of_beam.end());
}

/// Whether the scans that have the pile differ in what else they show.
bool NoReturnPile::has_moved(const std::vector<Reading>& pile) const {
  float nearest = std::numeric_limits<float>::infinity();
  float farthest = 0.0F;
  for (const Reading& reading : pile) {
    if (const float median = median_range_[reading.scan]; median > 0.0F) {
      nearest = std::min(nearest, median);
      farthest = std::max(farthest, median);
    }
  }
  return farthest - nearest > kMoved;
}

bool NoReturnPile::is_all_around(const std::vector<Reading>& pile) const {
  std::vector<std::bitset<kSectors>> sectors(median_range_.size());
  for (const Reading& reading : pile) {
    sectors[reading.scan].set(reading.beam * kSectors / beams_);
  }
  const auto scans = std::count_if(sectors.begin(), sectors.end(), [](const auto& of_scan) {
    return of_scan.count() >= kSectorsAtOnce;
  });
  return static_cast<std::size_t>(scans) >= kFewestAtOnce;
}

/// What is range_max or more is no return by itself: the others have to be many.
std::optional<double> NoReturnPile::first_of(const std::vector<Reading>& pile) const {
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
  if (static_cast<double>(scans) < kMostScans * static_cast<double>(median_range_.size()) ||
      static_cast<std::size_t>(sectors) < kFewestSectors) {
    return std::nullopt;
  }
  const double middle = median_of(values);
  for (double& value : values) {
    value = std::abs(value - middle);
  }
  const double deviation = std::max(1e-3, 1.4826 * median_of(values));
  const double first = middle - kDeviations * deviation;
  return first > static_cast<double>(largest_) - kWidth ? std::optional(first) : std::nullopt;
}

}  // namespace matchbox_slam
