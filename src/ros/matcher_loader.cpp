#include "ros/matcher_loader.hpp"

#include <algorithm>

namespace matchbox_slam {

MatcherLoader::MatcherLoader() {
  try {
    loader_ = std::make_shared<pluginlib::ClassLoader<ScanMatcher>>("matchbox_slam",
                                                                    "matchbox_slam::ScanMatcher");
  } catch (const pluginlib::PluginlibException&) {
    throw ConfigurationError(
        "the package matchbox_slam is not on ROS_PACKAGE_PATH, so its scan matchers cannot be "
        "found; source the setup.bash of its workspace first");
  }
}

std::vector<std::string> MatcherLoader::lookup_names() const {
  std::vector<std::string> names = loader_->getDeclaredClasses();
  std::sort(names.begin(), names.end());
  return names;
}

std::shared_ptr<ScanMatcher> MatcherLoader::create(const std::string& lookup_name) const {
  try {
    auto matcher = loader_->createUniqueInstance(lookup_name);
    ScanMatcher* const raw = matcher.get();
    // The deleter holds the loader: a library may only be unloaded after its last object.
    return {raw, [loader = loader_, deleter = matcher.get_deleter(),
                  owned = matcher.release()](ScanMatcher* /*raw*/) mutable { deleter(owned); }};
  } catch (const pluginlib::PluginlibException& error) {
    throw ConfigurationError("matcher '" + lookup_name + "' cannot be loaded: " + error.what());
  }
}

}  // namespace matchbox_slam
