#pragma once

#include <memory>
#include <string>
#include <vector>

#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/common/parameters.hpp"
#include "matchbox_slam/matching/scan_matcher.hpp"
#include "run/matcher_catalog.hpp"

namespace matchbox_slam {

// What reading a node's configuration consists of, for all nodes.

/// Looks at the first part of every key, which has to be one of `options` or a section: one of
/// `sections` or a matcher's. Throws ConfigurationError for any other, and suggests what was meant.
/// @param in_sections  options of `sections`, by their whole names, to be suggested to who has left
///   out the section; those of matchers come besides.
void reject_unknown_names(const Parameters& parameters, const std::vector<std::string>& options,
                          std::vector<std::string> sections,
                          const std::vector<OptionDescription>& in_sections,
                          const MatcherCatalog& catalog);

/// The matcher of that lookup name, configured by its section. The sections of other matchers are
/// checked too, so that a slip there is told now and not on the day they are chosen.
/// Throws ConfigurationError.
[[nodiscard]] std::shared_ptr<const ScanMatcher> make_matcher(const Parameters& parameters,
                                                              const MatcherCatalog& catalog,
                                                              const std::string& lookup_name);

}  // namespace matchbox_slam
