#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "evaluation/error_statistics.hpp"
#include "evaluation/scan_pairs.hpp"

namespace matchbox_slam {

/// A match within these of the truth is a success.
struct SuccessLimits {
  double xy = 0.02;     ///< [m]
  double theta = 0.01;  ///< [rad]
};

/// Whether a matcher's covariances are honest: the errors squared in units of the covariance
/// (NEES; Bar-Shalom, Li, Kirubarajan 2001, section 5.4). With three degrees of freedom the mean is
/// 3 when they are, more when the matcher claims too much. Rejected matches are left out.
struct CovarianceStatistics {
  std::size_t matches = 0;  ///< accepted, with a covariance that is positive definite
  double mean_nees = 0.0;
  double median_nees = 0.0;  ///< 2.37 when honest
};

/// How far the successful matches are from the best that is possible.
struct BoundStatistics {
  /// Root of the mean squared error of the successes in units of the bound, over the coordinates
  /// that the surroundings tell of: 1 is the best possible. None without a success.
  std::optional<double> ratio;
  /// Root of the bound's variance in x and y [m], in the median over all pairs; infinite where the
  /// surroundings leave a direction open.
  double translation = 0.0;
  double heading = 0.0;  ///< root of the bound's variance in heading [rad], likewise
};

/// Fisher information about the motion between the scans of each pair, over (x, y, theta) along the
/// axes of the base at the second; empty where it is not known.
struct PairInformation {
  std::vector<Eigen::Matrix3d> known_world;    ///< of `fisher_information`
  std::vector<Eigen::Matrix3d> unknown_walls;  ///< of `fisher_information_of_pair`
};

/// How one matcher's searches did alone, before anything refined their answers.
struct SearchStatistics {
  std::size_t successes = 0;    ///< of the accepted matches
  ErrorStatistics translation;  ///< [m], of all pairs; what was rejected keeps the guess's error
  ErrorStatistics heading;      ///< [rad], likewise
};

/// How one matcher did on all pairs.
struct PairStatistics {
  std::size_t pairs = 0;
  std::size_t accepted = 0;
  std::size_t successes = 0;
  ErrorStatistics translation;  ///< [m], of all pairs; what was rejected keeps the guess's error
  ErrorStatistics heading;      ///< [rad], likewise
  ErrorStatistics seconds;      ///< that a match took
  SearchStatistics search;
  std::optional<CovarianceStatistics> covariance;      ///< none when nothing was accepted
  std::optional<BoundStatistics> known_world_bound;    ///< none without the information
  std::optional<BoundStatistics> unknown_walls_bound;  ///< likewise

  [[nodiscard]] double success_rate() const {
    return static_cast<double>(successes) / static_cast<double>(pairs);
  }
  [[nodiscard]] double search_success_rate() const {
    return static_cast<double>(search.successes) / static_cast<double>(pairs);
  }
};

/// Summarises the matches of one matcher.
/// @param matches  one a pair.
/// Throws std::invalid_argument when there are no pairs or the numbers of entries differ.
[[nodiscard]] PairStatistics summarize_pairs(const std::vector<ScanPair>& pairs,
                                             const std::vector<PairMatch>& matches,
                                             const PairInformation& information,
                                             const SuccessLimits& limits = {});

}  // namespace matchbox_slam
