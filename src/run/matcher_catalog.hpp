#pragma once

#include <memory>
#include <string>
#include <vector>

#include "matchbox_slam/matching/scan_matcher.hpp"

namespace matchbox_slam {

/// The matchers that there are to choose from, each by its lookup name (such as
/// matchbox_slam/MonteCarlo). Where they come from is for who implements it to say: plugins, in the
/// programs of this package.
class MatcherCatalog {
 public:
  MatcherCatalog() = default;
  MatcherCatalog(const MatcherCatalog&) = delete;
  MatcherCatalog& operator=(const MatcherCatalog&) = delete;
  virtual ~MatcherCatalog() = default;

  /// Lookup names of those that are there without a search for plugins, which takes as long as
  /// fifty scans. Their short names mean them, whatever else there is.
  [[nodiscard]] virtual std::vector<std::string> names_at_hand() const { return {}; }

  /// Lookup names of all declared matchers, sorted.
  [[nodiscard]] virtual std::vector<std::string> lookup_names() const = 0;

  /// A matcher with its defaults, not configured yet; it may outlive the catalog. Throws
  /// ConfigurationError when it cannot be made.
  [[nodiscard]] virtual std::shared_ptr<ScanMatcher> create(
      const std::string& lookup_name) const = 0;

  /// The lookup name of the matcher that is meant. Throws ConfigurationError listing the declared
  /// ones when there is none of this name or a short name fits several.
  [[nodiscard]] std::string find(const std::string& name) const;
};

/// `monte_carlo` for `matchbox_slam/MonteCarlo`.
[[nodiscard]] std::string matcher_short_name(const std::string& lookup_name);

}  // namespace matchbox_slam
