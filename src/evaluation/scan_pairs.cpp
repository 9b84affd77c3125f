#include "evaluation/scan_pairs.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <mutex>
#include <string>
#include <system_error>
#include <thread>

#include "common/thread_time.hpp"
#include "matchbox_slam/common/random.hpp"

namespace matchbox_slam {
namespace {

Eigen::Matrix3d guess_covariance(const PairOptions& options, const MotionPriorOptions& least) {
  // A uniform distribution within +-a has the variance a^2 / 3.
  const double xy = std::max(options.error_xy / std::sqrt(3.0), least.translation_floor);
  const double theta = std::max(options.error_theta / std::sqrt(3.0), least.rotation_floor);
  return Eigen::Vector3d(xy * xy, xy * xy, theta * theta).asDiagonal();
}

PointScan project(const LocatedScan& located, const EngineOptions& options) {
  return project_scan(located.scan, located.base_from_laser, located.motion, options.scan);
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

/// Threads that are joined in the end, whatever happens.
class Helpers {
 public:
  Helpers() = default;
  Helpers(const Helpers&) = delete;
  Helpers& operator=(const Helpers&) = delete;
  ~Helpers() { join(); }

  /// Starts up to `count` threads; fewer where the system gives no more.
  void start(std::size_t count, const std::function<void()>& work) {
    try {
      while (threads_.size() < count) {
        threads_.emplace_back(work);
      }
    } catch (const std::system_error&) {
      // The work is done by those that there are, the calling one at least.
    }
  }

  void join() {
    for (std::thread& thread : threads_) {
      thread.join();
    }
    threads_.clear();
  }

 private:
  std::vector<std::thread> threads_;
};

/// The work that threads share: pairs are taken one by one, results go to their places.
class PairWork {
 public:
  PairWork(const std::vector<LocatedScan>& scans, const std::vector<ScanPair>& pairs,
           const std::vector<std::shared_ptr<const ScanMatcher>>& matchers,
           const EngineOptions& options)
      : scans_(scans),
        pairs_(pairs),
        matchers_(matchers),
        options_(options),
        matches_(matchers.size(), std::vector<PairMatch>(pairs.size())) {}

  /// Works until nothing is left, or somebody is told to stop.
  void work(const PairProgress& progress) {
    while (!stopped_) {
      const std::size_t index = next_++;
      if (index >= pairs_.size()) {
        break;
      }
      try {
        match(index);
      } catch (...) {
        const std::lock_guard<std::mutex> lock(error_mutex_);
        error_ = std::current_exception();
        stopped_ = true;
      }
      if (const std::size_t done = ++done_; progress && !progress(done)) {
        stopped_ = true;
      }
    }
  }

  [[nodiscard]] bool stopped() const { return stopped_; }

  void rethrow() const {
    if (error_) {
      std::rethrow_exception(error_);
    }
  }

  std::vector<std::vector<PairMatch>> take_matches() { return std::move(matches_); }

 private:
  void match(std::size_t index) {
    const ScanPair& pair = pairs_[index];
    const PointScan scan = project(scans_[pair.scan], options_);
    const auto key = std::make_shared<const KeyScan>(project(scans_[pair.reference], options_));
    const PlacedScans key_scans = {{key, Pose2{}}};
    SlamMap map(options_.map, options_.field);
    insert_scan(*key->points(), Pose2{}, options_.map, map);
    // Made once for many matches, as the map's field is, and so before the time is taken.
    (void)key->field();
    const MatchProblem problem{scan,      pair.guess, pair.guess_covariance,
                               map.field, key_scans,  pair.seed};
    for (std::size_t m = 0; m < matchers_.size(); ++m) {
      matches_[m][index] = timed_match(problem, *matchers_[m]);
    }
  }

  const std::vector<LocatedScan>& scans_;
  const std::vector<ScanPair>& pairs_;
  const std::vector<std::shared_ptr<const ScanMatcher>>& matchers_;
  const EngineOptions& options_;
  std::vector<std::vector<PairMatch>> matches_;
  std::atomic<std::size_t> next_{0};
  std::atomic<std::size_t> done_{0};
  std::atomic<bool> stopped_{false};
  std::mutex error_mutex_;
  std::exception_ptr error_;
};

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
    const Pose2& truth = pair.reference_from_base;
    pair.guess.x = truth.x + random.uniform(-options.error_xy, options.error_xy);
    pair.guess.y = truth.y + random.uniform(-options.error_xy, options.error_xy);
    pair.guess.theta =
        wrap_angle(truth.theta + random.uniform(-options.error_theta, options.error_theta));
    pair.guess_covariance = covariance;
    pair.seed = random.next();
  }
  return pairs;
}

std::vector<std::vector<PairMatch>> match_pairs(
    const std::vector<LocatedScan>& scans, const std::vector<ScanPair>& pairs,
    const std::vector<std::shared_ptr<const ScanMatcher>>& matchers, const EngineOptions& options,
    int threads, const PairProgress& progress) {
  PairWork work(scans, pairs, matchers, options);
  Helpers helpers;
  const std::size_t useful = std::min(static_cast<std::size_t>(std::max(1, threads)), pairs.size());
  helpers.start(std::max<std::size_t>(useful, 1) - 1, [&work] { work.work({}); });
  work.work(progress);
  helpers.join();
  work.rethrow();
  return work.stopped() ? std::vector<std::vector<PairMatch>>{} : work.take_matches();
}

}  // namespace matchbox_slam
