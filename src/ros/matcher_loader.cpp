#include "ros/matcher_loader.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <pluginlib/class_loader.hpp>

#include "matchbox_slam/matching/hough/hough_matcher.hpp"
#include "matchbox_slam/matching/monte_carlo/monte_carlo_matcher.hpp"
#include "matchbox_slam/matching/odometry_only_matcher.hpp"
#include "matchbox_slam/matching/olson/olson_matcher.hpp"

namespace matchbox_slam {
namespace {

using Make = std::shared_ptr<ScanMatcher> (*)();

template <typename Matcher>
std::shared_ptr<ScanMatcher> make() {
  return std::make_shared<Matcher>();
}

/// Those of plugins.xml that are of this package: they are in the program anyway, and to search all
/// packages for plugins takes half of the time until the first scan.
const std::map<std::string, Make> kOwnMatchers = {
    {"matchbox_slam/Hough", make<HoughMatcher>},
    {"matchbox_slam/MonteCarlo", make<MonteCarloMatcher>},
    {"matchbox_slam/OdometryOnly", make<OdometryOnlyMatcher>},
    {"matchbox_slam/Olson", make<OlsonMatcher>}};

}  // namespace

class MatcherLoader::Plugins : public pluginlib::ClassLoader<ScanMatcher> {
 public:
  using ClassLoader::ClassLoader;
};

std::vector<std::string> MatcherLoader::names_at_hand() const {
  std::vector<std::string> names;
  std::transform(kOwnMatchers.begin(), kOwnMatchers.end(), std::back_inserter(names),
                 [](const auto& own) { return own.first; });
  return names;
}

std::shared_ptr<MatcherLoader::Plugins> MatcherLoader::plugins() const {
  try {
    std::call_once(is_searched_, [this] {
      plugins_ = std::make_shared<Plugins>("matchbox_slam", "matchbox_slam::ScanMatcher");
    });
  } catch (const pluginlib::PluginlibException&) {
    throw ConfigurationError(
        "the package matchbox_slam is not on ROS_PACKAGE_PATH, so scan matchers of other packages "
        "cannot be found; source the setup.bash of its workspace first");
  }
  return plugins_;
}

std::vector<std::string> MatcherLoader::lookup_names() const {
  std::vector<std::string> names = plugins()->getDeclaredClasses();
  std::sort(names.begin(), names.end());
  return names;
}

std::shared_ptr<ScanMatcher> MatcherLoader::create(const std::string& lookup_name) const {
  if (const auto own = kOwnMatchers.find(lookup_name); own != kOwnMatchers.end()) {
    return own->second();
  }
  try {
    const std::shared_ptr<Plugins> loader = plugins();
    auto matcher = loader->createUniqueInstance(lookup_name);
    ScanMatcher* const raw = matcher.get();
    // The deleter holds the loader: a library may only be unloaded after its last object.
    return {raw, [loader, deleter = matcher.get_deleter(),
                  owned = matcher.release()](ScanMatcher* /*raw*/) mutable { deleter(owned); }};
  } catch (const pluginlib::PluginlibException& error) {
    throw ConfigurationError(
        fmt::format("matcher '{}' cannot be loaded: {}", lookup_name, error.what()));
  }
}

}  // namespace matchbox_slam
