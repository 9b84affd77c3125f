#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "run/matcher_catalog.hpp"

namespace matchbox_slam {

/// The scan matchers of this package, and those among the plugins of all others, by pluginlib,
/// which searches for them when they are asked for.
class MatcherLoader : public MatcherCatalog {
 public:
  [[nodiscard]] std::vector<std::string> names_at_hand() const override;

  /// Throws ConfigurationError when the workspace is not sourced.
  [[nodiscard]] std::vector<std::string> lookup_names() const override;

  /// It keeps its library loaded, also when this loader is gone.
  [[nodiscard]] std::shared_ptr<ScanMatcher> create(const std::string& lookup_name) const override;

 private:
  class Plugins;  // whose header takes seconds to compile

  [[nodiscard]] std::shared_ptr<Plugins> plugins() const;

  mutable std::once_flag is_searched_;
  mutable std::shared_ptr<Plugins> plugins_;
};

}  // namespace matchbox_slam
