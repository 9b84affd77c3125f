#include "slam/relocalizer.hpp"

#include <algorithm>

namespace matchbox_slam {
namespace {

/// As many key scans for a second or a metre, however many scans there are of it: of a log that has
/// one scan a metre, as of a robot that sends forty a second. Else such a log is at its end before
/// all key scans are searched. Stamps may be made up, and too close: then the way counts.
RecoveryOptions paced(RecoveryOptions options, const SearchStep& step) {
  constexpr double kWay = 0.1;  // [m] for each key scan
  // So that no scan waits long; where so many take longer the search itself leaves some out. With
  // three in place of five a robot was found in seattle's map after 33 scans, not 20, in that of
  // belgioioso after 154, not 92.
  constexpr double kMaxTimesAsMany = 5.0;
  constexpr double kJitter = 0.1;  // of the time between scans, as a share of the interval
  const double by_way = step.way / kWay;
  const double by_time = options.interval > 0.0 ? step.seconds / options.interval : 1.0;
  if (by_way >= 1.0) {
    options.interval = 0.0;
  }
  const double times =
      std::min(kMaxTimesAsMany, std::max(1.0, std::max(by_way, by_time) + kJitter));
  options.key_scans *= static_cast<int>(times);
  return options;
}

}  // namespace

void Relocalizer::begin(const MapParts& parts, double since) {
  search_ = {};
  search_.stamp = since;
  look_among(parts);
}

std::optional<PlaceHypothesis> Relocalizer::find(const PointScan& scan,
                                                 const Pose2& apart_from_base,
                                                 const SearchStep& step, const MapParts& parts,
                                                 const EngineOptions& options) {
  return search_places(scan, apart_from_base, parts.all(), parts.here_number(), places_,
                       paced(options.recovery, step), search_);
}

/// A robot that is not lost is looked for nowhere.
void Relocalizer::look_among(const MapParts& parts) {
  places_.clear();
  if (parts.is_lost()) {
    places_ = searched_places(parts.all(), parts.here_number());
  }
}

}  // namespace matchbox_slam
