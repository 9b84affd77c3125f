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
/// Returns the matchers that sections may be of: those at hand, and all where there is a section of
/// none of these.
/// @param in_sections  options of `sections`, by their whole names, to be suggested to who has left
///   out the section; those of matchers come besides.
[[nodiscard]] std::vector<std::string> reject_unknown_names(
    const Parameters& parameters, const std::vector<std::string>& options,
    std::vector<std::string> sections, const std::vector<OptionDescription>& in_sections,
    const MatcherCatalog& catalog);

/// The matcher of that lookup name, configured by its section. The sections of other matchers are
/// checked too, so that a slip there is told now and not on the day they are chosen.
/// Throws ConfigurationError.
/// @param others  lookup names of matchers that there may be sections of.
[[nodiscard]] std::shared_ptr<const ScanMatcher> make_matcher(
    const Parameters& parameters, const MatcherCatalog& catalog, const std::string& lookup_name,
    const std::vector<std::string>& others);

}  // namespace matchbox_slam
