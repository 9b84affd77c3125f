#include "matching/hough/relocalise.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

namespace matchbox_slam {
namespace {

/// Anywhere around the key scan, in any heading.
PosePrior anywhere_around(const PlacedScan& key) {
  constexpr double kSigma = 1e3;  // [m], [rad]: any width that nothing is left of the prior
  return {key.map_from_base, kSigma * kSigma * Eigen::Matrix3d::Identity()};
}

/// Scans that share little have their true shift far down among those of each column, and its pose
/// far down among those ranked by likelihood alone: without a prior, more of both are followed.
HoughAlignmentOptions without_prior(HoughAlignmentOptions options) {
  // Guesses: half and double were not tried.
  constexpr int kPeaks = 8;
  constexpr int kTranslations = 16;
  options.peaks = std::max(options.peaks, kPeaks);
  options.translations = std::max(options.translations, kTranslations);
  return options;
}

/// A pose and the key scan that it comes from.
struct Candidate {
  RankedPose pose;
  PlacedScan key;
};

/// None when it is interrupted.
std::optional<std::vector<Candidate>> search_all(const SearchedScan& scan,
                                                 const PlacedScans& key_scans,
                                                 const HoughOptions& options,
                                                 const std::function<bool()>& is_interrupted) {
  constexpr std::size_t kRanked = 3 * kRankedPoses;
  std::vector<Candidate> candidates;
  for (const PlacedScan& key : key_scans) {
    if (is_interrupted()) {
      return std::nullopt;
    }
    for (const RankedPose& pose : search_anywhere(scan, key, options, kRanked).poses) {
      candidates.push_back({pose, key});
    }
  }
  std::stable_sort(
      candidates.begin(), candidates.end(),
      [](const Candidate& a, const Candidate& b) { return a.pose.score > b.pose.score; });
  return candidates;
}

}  // namespace

KeyScanSearch search_anywhere(const SearchedScan& scan, const PlacedScan& key,
                              const HoughOptions& options, std::size_t most) {
  return search_key_scan(scan, key, anywhere_around(key), options.prior_weight,
                         without_prior(options.alignment), most);
}

PlacedScans spread_out(const PlacedScans& key_scans) {
  // Guesses. With half or double of both a carried robot is found 3 to 4 s later, with the same
  // error (benchmark/reports/current/CONSTANTS.md).
  constexpr double kMinSpacing = 1.0;      // [m]
  constexpr double kMinTurn = 0.25 * kPi;  // [rad]
  PlacedScans chosen;
  for (auto key = key_scans.rbegin(); key != key_scans.rend(); ++key) {
    const bool is_new = std::none_of(chosen.begin(), chosen.end(), [&](const PlacedScan& other) {
      const Eigen::Vector3d apart = difference(key->map_from_base, other.map_from_base);
      return apart.head<2>().norm() < kMinSpacing && std::abs(apart.z()) < kMinTurn;
    });
    if (is_new) {
      chosen.push_back(*key);
    }
  }
  return chosen;
}

Relocalisation relocalise(const PointScan& scan, const PlacedScans& key_scans,
                          const HoughOptions& options, const std::function<bool()>& is_interrupted,
                          std::size_t most) {
  const SearchedScan searched(scan, options.alignment.point_spacing);
  Relocalisation result;
  // For each pose wanted: several may be refined to one place.
  constexpr std::size_t kTriesPerPose = 3;
  std::size_t tries = 0;
  const std::optional<std::vector<Candidate>> candidates =
      search_all(searched, spread_out(key_scans), options, is_interrupted);
  result.interrupted = !candidates;
  for (const Candidate& candidate : candidates.value_or(std::vector<Candidate>{})) {
    if (result.poses.size() == most) {
      break;
    }
    if (is_near_any(candidate.pose, result.poses)) {
      continue;
    }
    if (tries++ == kTriesPerPose * most) {
      break;
    }
    const PlacedScan& key = candidate.key;
    const std::shared_ptr<const LikelihoodField> field = key.scan->field();
    const RefinedPose refined =
        refine(scan.points, PlacedFields{{field.get(), key.map_from_base}},
               candidate.pose.map_from_base, anywhere_around(key), options.refinement);
    if (is_near_any({refined.map_from_base, 0.0}, result.poses)) {
      continue;
    }
    const double against =
        mutual_violation(SearchedScan(*key.scan->points(), options.alignment.point_spacing),
                         searched, key.map_from_base.inverse() * refined.map_from_base);
    result.poses.push_back({refined.map_from_base, std::clamp(refined.score - against, 0.0, 1.0)});
  }
  sort_and_thin(result.poses);
  if (result.poses.size() > 1 && result.poses[1].score > 0.0) {
    result.ratio = result.poses[0].score / result.poses[1].score;
  }
  return result;
}

}  // namespace matchbox_slam
