#pragma once

#include <memory>
#include <pluginlib/class_loader.hpp>
#include <string>
#include <vector>

#include "run/matcher_catalog.hpp"

namespace matchbox_slam {

/// The scan matchers among the plugins of all packages, by pluginlib.
class MatcherLoader : public MatcherCatalog {
 public:
  /// Throws ConfigurationError when the workspace is not sourced.
  MatcherLoader();

  [[nodiscard]] std::vector<std::string> lookup_names() const override;

  /// It keeps its library loaded, also when this loader is gone.
  [[nodiscard]] std::shared_ptr<ScanMatcher> create(const std::string& lookup_name) const override;

 private:
  std::shared_ptr<pluginlib::ClassLoader<ScanMatcher>> loader_;
};

}  // namespace matchbox_slam
