#pragma once

#include <string>
#include <vector>

#include "evaluation/scan_pairs.hpp"
#include "tools/recording_request.hpp"

namespace matchbox_slam {

/// What match_pairs is asked to do; what is not given keeps its default.
struct MatchPairsRequest : RecordingRequest {
  std::string truth;  ///< TUM file
  std::vector<std::string> matchers;
  PairOptions pairs;
  int threads = 1;
};

/// Measures scan matching alone: draws pairs of scans of a recording whose truth is known, lets
/// every matcher match them from a guess that is wrong by a known amount, and writes pairs.csv (one
/// line a matcher and pair), summary.json and summary.md (one row a matcher) into the folder. Of a
/// simulated recording it also tells how near the matchers come to the Cramér-Rao bound.
///
/// All but the times is the same for any number of threads. Interrupted, it writes the results of
/// the pairs that are done, and throws std::runtime_error. Throws ConfigurationError when the
/// request makes no sense, FileError when a file cannot be read or written, BagError and
/// EvaluationError when there is nothing to match.
void match_pairs(const MatchPairsRequest& request, const RunDialog& dialog);

}  // namespace matchbox_slam
