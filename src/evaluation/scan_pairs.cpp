#include "evaluation/scan_pairs.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <future>
#include <string>
#include <system_error>

#include "common/thread_time.hpp"
#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/geometry/pose_covariance.hpp"

namespace matchbox_slam {
namespace {

Eigen::Matrix3d guess_covariance(const PairOptions& options, const MotionPriorOptions& least) {
  const double told_xy = options.told_xy > 0.0 ? options.told_xy : options.error_xy;
  const double told_theta = options.told_theta > 0.0 ? options.told_theta : options.error_theta;
  // A uniform distribution within +-a has the variance a^2 / 3.
  const double xy = std::max(told_xy / std::sqrt(3.0), least.translation_floor);
  const double theta = std::max(told_theta / std::sqrt(3.0), least.rotation_floor);
  return covariance_of(xy, theta);
}

/// What is added to a true motion: (x [m], y [m], theta [rad]).
Eigen::Vector3d draw_error(const PairOptions& options, Random& random) {
  if (options.error_draw == "size") {
    const double share = random.uniform();
    const double direction = random.uniform(-kPi, kPi);
    const double side = random.uniform() < 0.5 ? -1.0 : 1.0;
    return share * Eigen::Vector3d(options.error_xy * std::cos(direction),
                                   options.error_xy * std::sin(direction),
                                   options.error_theta * side);
  }
  const double x = random.uniform(-options.error_xy, options.error_xy);
  const double y = random.uniform(-options.error_xy, options.error_xy);
  return {x, y, random.uniform(-options.error_theta, options.error_theta)};
}

PointScan project(const LocatedScan& located, const EngineOptions& options) {
  return project_scan(located.scan, located.base_from_laser, located.motion, options.scan,
                      located.laser_motion);
}

struct ScanIndices {
  std::size_t reference;
  std::size_t scan;
};

/// All scans whose numbers are `gap` apart.
std::vector<ScanIndices> pairs_apart(const std::vector<LocatedScan>& scans, int gap) {
  std::vector<ScanIndices> pairs;
  std::size_t scan = 0;
  for (std::size_t reference = 0; reference < scans.size(); ++reference) {
    const std::size_t wanted = scans[reference].number + static_cast<std::size_t>(gap);
    while (scan < scans.size() && scans[scan].number < wanted) {
      ++scan;
    }
    if (scan < scans.size() && scans[scan].number == wanted) {
      pairs.push_back({reference, scan});
    }
  }
  return pairs;
}

PairMatch timed_match(const MatchProblem& problem, const ScanMatcher& matcher) {
  PairMatch match;
  const double begin = thread_seconds();
  match.result = matcher.match(problem);
  match.seconds = thread_seconds() - begin;
  return match;
}

/// What each matcher makes of a pair, one after the other.
std::vector<PairMatch> match_pair(const ScanPair& pair, const std::vector<LocatedScan>& scans,
                                  const std::vector<std::shared_ptr<const ScanMatcher>>& matchers,
                                  const EngineOptions& options) {
  const PointScan scan = project(scans[pair.scan], options);
  const auto key = std::make_shared<const KeyScan>(project(scans[pair.reference], options));
  const PlacedScans key_scans = {{key, Pose2{}}};
  SlamMap map(options.map, options.field);
  insert_scan(*key->points(), Pose2{}, options.map, map);
  // Made once for many matches, as the map's field is, and so before the time is taken.
  (void)key->field();
  const MatchProblem problem{scan,      pair.guess, pair.guess_covariance,
                             map.field, key_scans,  pair.seed};
  std::vector<PairMatch> matches;
  for (const auto& matcher : matchers) {
    matches.push_back(timed_match(problem, *matcher));
  }
  return matches;
}

}  // namespace

std::vector<ScanPair> draw_pairs(const std::vector<LocatedScan>& scans, const PairOptions& options,
                                 const MotionPriorOptions& least_uncertainty, std::uint64_t seed) {
  const std::vector<ScanIndices> candidates = pairs_apart(scans, options.gap);
  if (candidates.empty()) {
    throw EvaluationError("among " + std::to_string(scans.size()) +
                          " scans with truth no two are " + std::to_string(options.gap) +
                          " scans of the recording apart");
  }
  const Eigen::Matrix3d covariance = guess_covariance(options, least_uncertainty);
  std::vector<ScanPair> pairs(static_cast<std::size_t>(options.pairs));
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    // A pair's chance is its own, so that more pairs do not change the first ones.
    Random random(mix_seed(seed, i));
    ScanPair& pair = pairs[i];
    const auto drawn =
        static_cast<std::size_t>(random.uniform() * static_cast<double>(candidates.size()));
    pair.reference = candidates[drawn].reference;
    pair.scan = candidates[drawn].scan;
    pair.reference_from_base =
        scans[pair.reference].world_from_base.inverse() * scans[pair.scan].world_from_base;
    pair.guess = displaced(pair.reference_from_base, draw_error(options, random));
    pair.guess_covariance = covariance;
    pair.seed = random.next();
  }
  return pairs;
}

std::vector<std::vector<PairMatch>> match_pairs(
    const std::vector<LocatedScan>& scans, const std::vector<ScanPair>& pairs,
    const std::vector<std::shared_ptr<const ScanMatcher>>& matchers, const EngineOptions& options,
    int threads, const PairProgress& progress) {
  std::vector<std::vector<PairMatch>> matches(matchers.size(),
                                              std::vector<PairMatch>(pairs.size()));
  std::atomic<std::size_t> next{0};
  std::atomic<std::size_t> done{0};
  std::atomic<bool> stopped{false};
  // Takes pairs one by one until none is left, or somebody is told to stop.
  const auto work = [&](const PairProgress& is_to_go_on) {
    try {
      while (!stopped) {
        const std::size_t i = next++;
        if (i >= pairs.size()) {
          return;
        }
        const std::vector<PairMatch> of_pair = match_pair(pairs[i], scans, matchers, options);
        for (std::size_t m = 0; m < matchers.size(); ++m) {
          matches[m][i] = of_pair[m];
        }
        if (const std::size_t count = ++done; is_to_go_on && !is_to_go_on(count)) {
          stopped = true;
        }
      }
    } catch (...) {
      stopped = true;
      throw;
    }
  };
  const std::size_t useful = std::min(static_cast<std::size_t>(std::max(1, threads)), pairs.size());
  std::vector<std::future<void>> helpers;  // which wait for their threads, whatever happens
  try {
    while (helpers.size() + 1 < useful) {
      helpers.push_back(std::async(std::launch::async, work, PairProgress{}));
    }
  } catch (const std::system_error&) {
    // The work is done by those that there are, the calling one at least.
  }
  work(progress);
  for (std::future<void>& helper : helpers) {
    helper.get();
  }
  for (std::vector<PairMatch>& of_matcher : matches) {
    of_matcher.resize(std::min<std::size_t>(next, pairs.size()));  // what was begun was finished
  }
  return matches;
}

}  // namespace matchbox_slam
