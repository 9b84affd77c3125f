#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "matchbox_slam/matching/hough/hough_matcher.hpp"
#include "matchbox_slam/matching/key_scan.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"
#include "matching/hough/hough_search.hpp"

namespace matchbox_slam {

/// Where a scan may have been taken.
struct Relocalisation {
  std::vector<RankedPose> poses;  ///< best first, none within 0.1 m and 0.05 rad of another
  /// Score of the best pose over that of the second: near 1 the scan fits two places alike.
  /// 0: there are not two.
  double ratio = 0.0;
  bool interrupted = false;  ///< then there are no poses
};

/// Finds a scan among key scans with no idea of where it was taken: the Hough matcher's search with
/// a prior that is flat in the heading and in the translation up to `alignment.max_window_xy` from
/// each key scan, the best poses then refined against the key scan that they come from.
/// Of key scans that see the same, within 1 m and 45 degrees of each other, only the newest is
/// searched. More shifts and translations are followed than while tracking: at least 8 and 16.
/// @param is_interrupted  asked before each key scan; true ends the search.
/// @param most  poses that are refined and returned at most.
/// Cost: key scans that are searched times some ten milliseconds.
[[nodiscard]] Relocalisation relocalise(
    const PointScan& scan, const PlacedScans& key_scans, const HoughOptions& options,
    const std::function<bool()>& is_interrupted = [] { return false; }, std::size_t most = 8);

/// The same for one key scan, without refinement: where around it the scan may have been taken, as
/// of `search_key_scan`.
[[nodiscard]] KeyScanSearch search_anywhere(const SearchedScan& scan, const PlacedScan& key,
                                            const HoughOptions& options, std::size_t most);

/// The key scans that `relocalise` searches, newest first.
[[nodiscard]] PlacedScans spread_out(const PlacedScans& key_scans);

}  // namespace matchbox_slam
