// All scan matchers of this package, as plugins. Their descriptions are in plugins.xml.

#include <pluginlib/class_list_macros.hpp>

#include "matchbox_slam/matching/hough/hough_matcher.hpp"
#include "matchbox_slam/matching/monte_carlo/monte_carlo_matcher.hpp"
#include "matchbox_slam/matching/odometry_only_matcher.hpp"
#include "matchbox_slam/matching/olson/olson_matcher.hpp"

PLUGINLIB_EXPORT_CLASS(matchbox_slam::HoughMatcher, matchbox_slam::ScanMatcher)
PLUGINLIB_EXPORT_CLASS(matchbox_slam::MonteCarloMatcher, matchbox_slam::ScanMatcher)
PLUGINLIB_EXPORT_CLASS(matchbox_slam::OdometryOnlyMatcher, matchbox_slam::ScanMatcher)
PLUGINLIB_EXPORT_CLASS(matchbox_slam::OlsonMatcher, matchbox_slam::ScanMatcher)
