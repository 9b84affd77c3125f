#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "bag/bag_scans.hpp"
#include "evaluation/pair_statistics.hpp"
#include "evaluation/scan_pairs.hpp"
#include "matchbox_slam/common/options.hpp"

namespace matchbox_slam {

/// One matcher, and what it made of all pairs.
struct MatcherOnPairs {
  std::string name;  ///< short
  std::vector<OptionDescription> configuration;
  std::vector<PairMatch> matches;
  PairStatistics statistics;
};

/// Where the pairs come from.
struct PairFacts {
  BagFacts bag;
  std::string truth;                 ///< file
  std::size_t scans = 0;             ///< in the recording
  std::size_t scans_with_truth = 0;  ///< that can be used, too
  double gap_seconds = 0.0;          ///< between the scans of a pair, median
  std::size_t beams = 0;             ///< of a scan, median
  double reach = 0.0;  ///< distance of a scan's farthest hit from the base [m], median
};

/// What was asked of the matchers.
struct PairTask {
  PairFacts facts;
  PairOptions options;
  SuccessLimits limits;
  int seed = 1;
  int threads = 1;
};

/// One line a matcher and pair, under the heading `matcher,reference_stamp,scan_stamp,guess_x,
/// guess_y,guess_theta,x,y,theta,search_x,search_y,search_theta,var_x,var_y,var_theta,status,
/// time_us`; poses of the base at the second scan in the base at the first, in metres and radians;
/// stamps in seconds. `search_` is the search's own answer, before it was refined.
[[nodiscard]] std::string pairs_csv(const std::vector<LocatedScan>& scans,
                                    const std::vector<ScanPair>& pairs,
                                    const std::vector<MatcherOnPairs>& matchers);

/// The statistics for programs.
[[nodiscard]] std::string pairs_json(const PairTask& task,
                                     const std::vector<MatcherOnPairs>& matchers);

/// The statistics for people, as a table in Markdown.
[[nodiscard]] std::string pairs_markdown(const PairTask& task,
                                         const std::vector<MatcherOnPairs>& matchers);

}  // namespace matchbox_slam
