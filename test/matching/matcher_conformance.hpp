#pragma once

#include <functional>
#include <memory>
#include <string>

#include "matchbox_slam/matching/scan_matcher.hpp"

namespace matchbox_slam {

/// Makes a matcher as its plugin loader does: default-constructed, not configured.
using MatcherFactory = std::function<std::shared_ptr<ScanMatcher>()>;

/// Adds the tests of what every matcher promises (see ScanMatcher) to those that GoogleTest runs,
/// as `<name>.Identity`, `<name>.KnownShiftsInRooms` and so on.
///
/// A matcher that evaluates more than one pose has to find the true one; one that does not, such as
/// a baseline that believes the odometry, has to be honest about its covariance.
void register_matcher_conformance(const std::string& name, const MatcherFactory& make);

}  // namespace matchbox_slam
