#pragma once

#include <memory>
#include <pluginlib/class_loader.hpp>
#include <string>
#include <vector>

#include "matchbox_slam/matching/scan_matcher.hpp"

namespace matchbox_slam {

/// Finds scan matchers among the plugins of all packages. A plugin is named by its lookup name,
/// `matchbox_slam/MonteCarlo`, or shorter by `monte_carlo`, which is also the name of the section
/// that holds its parameters.
class MatcherLoader {
 public:
  /// Throws ConfigurationError when the workspace is not sourced.
  MatcherLoader();

  /// Lookup names of all declared matchers, sorted.
  [[nodiscard]] std::vector<std::string> lookup_names() const;

  /// The lookup name of the matcher that is meant. Throws ConfigurationError listing the declared
  /// ones when there is none of this name or a short name fits several.
  [[nodiscard]] std::string find(const std::string& name) const;

  /// A matcher with its defaults, not configured yet. It keeps its library loaded, also when this
  /// loader is gone. Throws ConfigurationError when its library cannot be loaded.
  [[nodiscard]] std::shared_ptr<ScanMatcher> create(const std::string& lookup_name) const;

 private:
  std::shared_ptr<pluginlib::ClassLoader<ScanMatcher>> loader_;
};

/// `monte_carlo` for `matchbox_slam/MonteCarlo`.
[[nodiscard]] std::string matcher_short_name(const std::string& lookup_name);

}  // namespace matchbox_slam
