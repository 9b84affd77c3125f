#pragma once

#include <string>
#include <vector>

#include "matchbox_slam/common/options.hpp"
#include "run/matcher_catalog.hpp"
#include "run/slam_setup.hpp"

namespace matchbox_slam {

/// A configuration of which parts may change while the mapping goes on: the matcher, everything
/// about matchers, and what the engine does with the next scan. Frames, clocks and what the map was
/// made with may not.
class LiveConfiguration {
 public:
  /// Throws as make_slam_setup does. @param catalog  outlives this object.
  LiveConfiguration(Parameters parameters, const MatcherCatalog& catalog,
                    SetupOf whose = SetupOf::kNode);

  [[nodiscard]] const SlamSetup& setup() const { return setup_; }

  /// Whether somebody has set an option, by its full name.
  [[nodiscard]] bool is_given(const std::string& name) const {
    return parameters_.find(name) != nullptr;
  }

  /// The options that may change, with their present values; those of all matchers that there are.
  [[nodiscard]] std::vector<OptionDescription> options() const;

  /// What the configuration would be with these values. Throws ConfigurationError when one is not
  /// allowed or may not change.
  [[nodiscard]] LiveConfiguration with(const Parameters& changes) const;

 private:
  Parameters parameters_;  ///< as given
  const MatcherCatalog* catalog_;
  SlamSetup setup_;
};

}  // namespace matchbox_slam
