#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/matching/hough/hough_alignment.hpp"
#include "matchbox_slam/matching/key_scan.hpp"
#include "matchbox_slam/matching/refinement.hpp"
#include "matching/hough/scan_view.hpp"

namespace matchbox_slam {

/// A pose that a search came up with.
struct RankedPose {
  Pose2 map_from_base;
  double score = 0.0;  ///< mean likelihood of the scan's points against the reference, 0...1
};

/// What a search among the alignments of two scans came up with.
struct KeyScanSearch {
  std::vector<RankedPose> poses;  ///< best first
  std::size_t ranked = 0;         ///< poses that were looked at, which is most of what it costs
};

/// A scan as the search sees it.
struct SearchedScan {
  SearchedScan(const PointScan& scan, double point_spacing)
      : points(hough_points(scan.points, point_spacing)), view(scan) {}

  HoughPoints points;
  ScanView view;
};

/// The share of what two scans saw that the other one saw to be free space, 0...1.
[[nodiscard]] double mutual_violation(const SearchedScan& a, const SearchedScan& b,
                                      const Pose2& a_from_b);

/// Poses of a key scan that are checked for violations of free space when there is a prior. With
/// half or double, pairs and intel are matched as well.
constexpr std::size_t kRankedPoses = 32;

/// The poses from which the scan may have been taken, judged by one key scan: the alignments of the
/// two Hough domains, ranked by how likely the scan is against the key scan, less what the prior
/// says against them, and what each of the two scans saw to be free where the other saw a wall.
/// @param prior_weight  score lost by a pose one standard deviation of the prior away.
/// @param most  poses returned; what each of the scans saw to be free is looked at for these alone.
///   Where they are few, a share of the scan's points chooses the ones that are ranked by all.
/// Cost: as of the alignment, then alignments times points.
[[nodiscard]] KeyScanSearch search_key_scan(const SearchedScan& scan, const PlacedScan& key,
                                            const PosePrior& prior, double prior_weight,
                                            const HoughAlignmentOptions& options,
                                            std::size_t most = kRankedPoses);

/// Whether a pose is within 0.1 m and 0.05 rad of one of the others.
[[nodiscard]] bool is_near_any(const RankedPose& pose, const std::vector<RankedPose>& others);

/// Sorts by score, best first, and drops poses that are near a better one, and what follows the
/// most that are wanted.
void sort_and_thin(std::vector<RankedPose>& poses,
                   std::size_t most = std::numeric_limits<std::size_t>::max());

}  // namespace matchbox_slam
