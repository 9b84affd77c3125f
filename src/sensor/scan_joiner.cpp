#include "sensor/scan_joiner.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "matchbox_slam/geometry/angles.hpp"

namespace matchbox_slam {
namespace {

constexpr double kWholeTurn = 2.0 * kPi;
constexpr double kNoPart = degrees_to_radians(330.0);  // a scan of so much is a whole turn
constexpr double kSlowestTurn = 0.5;  // s: parts that lie farther apart are none of one turn

double angle_of(const LaserScan& scan) {
  return std::abs(scan.angle_increment) * static_cast<double>(scan.ranges.size());
}

std::size_t beams_of_turn(const LaserScan& scan) {
  return static_cast<std::size_t>(std::lround(kWholeTurn / std::abs(scan.angle_increment)));
}

}  // namespace

/// The beam of the whole that a part begins with; none: it is no further part of it.
std::optional<std::size_t> ScanJoiner::place_after(const LaserScan& whole,
                                                   const LaserScan& part) const {
  const double increment = whole.angle_increment;
  const double since = part.stamp - whole.stamp;
  if (std::abs(part.angle_increment - increment) > 0.01 * std::abs(increment) || since <= 0.0 ||
      since > kSlowestTurn || std::abs(increment) < 1e-6) {
    return std::nullopt;
  }
  const double direction = increment > 0.0 ? 1.0 : -1.0;
  double angle = std::fmod(direction * (part.angle_min - whole.angle_min), kWholeTurn);
  angle += angle < 0.0 ? kWholeTurn : 0.0;
  const auto beam = static_cast<std::size_t>(std::lround(angle / std::abs(increment)));
  const bool fits =
      beam >= whole.ranges.size() && beam + part.ranges.size() <= beams_of_turn(whole);
  return fits ? std::optional(beam) : std::nullopt;
}

void ScanJoiner::begin(LaserScan&& part) {
  whole_ = std::move(part);
  joined_ = 1;
}

/// Its beams are spread over the time between the stamps of its parts, whatever they say.
void ScanJoiner::append(const LaserScan& part, std::size_t first_beam) {
  whole_.ranges.resize(first_beam, std::numeric_limits<float>::quiet_NaN());
  whole_.ranges.insert(whole_.ranges.end(), part.ranges.begin(), part.ranges.end());
  whole_.time_increment = (part.stamp - whole_.stamp) / static_cast<double>(first_beam);
  whole_.range_min = std::min(whole_.range_min, part.range_min);
  whole_.range_max = std::max(whole_.range_max, part.range_max);
  ++joined_;
}

bool ScanJoiner::is_whole() const {
  return whole_.ranges.size() + 1 >= beams_of_turn(whole_) || joined_ == parts_;
}

void ScanJoiner::finish() {
  if (joined_ > 0) {
    ready_.push_back(std::move(whole_));
    joined_ = 0;
  }
}

void ScanJoiner::note_alone() {
  constexpr int kMinTurns = 10;  // turns; single ones lose parts, and the first begins anywhere
  alone_ = joined_ == 1 ? alone_ + 1 : 0;
  if (parts_ && alone_ == kMinTurns) {
    news_ = "scan/join_parts is " + std::to_string(*parts_) + ", but " + std::to_string(kMinTurns) +
            " scans in a row do not go on where the one before ended, half a second later at most: "
            "they are used one by one; 'auto' looks whether they are parts";
  }
}

/// With 'auto': whether scans are parts is seen from the first two, or the next two where there is
/// a gap between these, as of a laser that starts. Not from later ones: those of a slow laser would
/// all have to wait.
void ScanJoiner::watch(const LaserScan& scan) {
  const bool is_gap = first_ && !has_waited_ && scan.stamp - first_->stamp > kSlowestTurn;
  if ((!first_ || is_gap) && angle_of(scan) < kNoPart) {
    has_waited_ = is_gap;
    first_ = scan;
    return;
  }
  is_watching_ = false;
  joins_ = first_ && place_after(*first_, scan);
  if (joins_) {
    begin(std::move(*first_));
    news_ = "each turn of the laser comes in parts, here of " + std::to_string(scan.ranges.size()) +
            " beams: they are joined; scan/join_parts sets how many are one turn, 1: each is";
  }
  first_.reset();
}

bool ScanJoiner::add(LaserScan scan) {
  const bool joined_before = joins_;
  if (is_watching_ && !parts_) {
    watch(scan);
  }
  if (parts_ ? *parts_ == 1 : !joins_) {
    ready_.push_back(std::move(scan));
    return false;
  }
  if (joined_ > 0) {
    if (const std::optional<std::size_t> beam = place_after(whole_, scan)) {
      append(scan, *beam);
    } else {
      note_alone();
      finish();
      begin(std::move(scan));
    }
  } else {
    begin(std::move(scan));
  }
  if (is_whole()) {
    finish();
  }
  return joins_ != joined_before;
}

// Not where it is called: GCC 14 would warn there of what the moved-from one leaves uninitialised.
void ScanJoiner::begin_anew() { *this = ScanJoiner(parts_); }

std::vector<LaserScan> ScanJoiner::take() { return std::exchange(ready_, {}); }

std::string ScanJoiner::take_news() { return std::exchange(news_, {}); }

}  // namespace matchbox_slam
