#pragma once

#include <memory>

#include "matchbox_slam/matching/monte_carlo/monte_carlo_matcher.hpp"
#include "matchbox_slam/matching/olson/olson_matcher.hpp"

namespace matchbox_slam {

inline const std::shared_ptr<const ScanMatcher> kMonteCarlo = std::make_shared<MonteCarloMatcher>();
inline const std::shared_ptr<const ScanMatcher> kOlson = std::make_shared<OlsonMatcher>();

}  // namespace matchbox_slam
