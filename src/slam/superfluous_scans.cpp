#include "slam/superfluous_scans.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "matchbox_slam/geometry/angles.hpp"
#include "matchbox_slam/geometry/transform2.hpp"
#include "sensor/take_some.hpp"

namespace matchbox_slam {
namespace {

// Guesses: half and double were not tried.
constexpr double kSameViewDistance = 0.5;  // [m]
constexpr double kSameViewAngle = 0.35;    // [rad]
constexpr double kSharedViewRadius = 3.0;  // [m], from where most of the same is seen
constexpr std::uint64_t kNewestKept = 60;  // newest key scans
constexpr double kMaxUniqueShare = 0.01;   // share of its hits that nobody else need have seen
// Share of its hits that are seen no more where they were.
constexpr double kMinChangedShare = 0.15;
constexpr std::size_t kHitSamples = 120;  // hits of a scan

bool is_beside(const PlacedScan& a, const PlacedScan& b) {
  return (a.map_from_base.translation() - b.map_from_base.translation()).squaredNorm() <=
             kSameViewDistance * kSameViewDistance &&
         std::abs(wrap_angle(a.map_from_base.theta - b.map_from_base.theta)) <= kSameViewAngle &&
         a.scan->laser() == b.scan->laser();
}

/// Places that a key scan hit.
std::vector<Eigen::Vector2d> hits_of(const PlacedScan& key) {
  const std::shared_ptr<const PointScan> scan = key.scan->points();
  const Transform2 to_map(key.map_from_base);
  std::vector<Eigen::Vector2d> hits;
  take_some(*scan, kHitSamples, [&](const ScanPoint& point) {
    if (point.position.norm() < kFarthestPoint) {
      hits.push_back(to_map * point.position);
    }
  });
  return hits;
}

/// Of a place, by one scan.
enum class Look {
  kNone,     ///< it did not look there, or not so far
  kHit,      ///< something is there
  kThrough,  ///< it saw what lies behind: nothing is there
  kBlocked,  ///< something stands before it
};

/// How far a scan saw in each direction: tells of any place whether the scan looked at it.
class SeenReach {
 public:
  SeenReach(const PointScan& scan, const Pose2& map_from_base) : reaches_(kSectorCount) {
    const Eigen::Vector2d laser = laser_of(scan);
    map_from_laser_ = map_from_base * Pose2{laser.x(), laser.y(), 0.0};
    for (const ScanPoint& point : scan.points) {
      see(point.position - laser);
    }
    for (const FreeRay& ray : scan.free_rays) {
      see(ray.end - laser);
    }
  }

  [[nodiscard]] Look at(const Eigen::Vector2d& place) const {
    // [m] between what is the same, as seen from a little elsewhere.
    constexpr double kViewTolerance = 0.2;
    const Eigen::Vector2d way = map_from_laser_.inverse() * place;
    const Reach& reach = reaches_[sector_of(way)];
    const double range = way.norm();
    if (reach.farthest < 0.0F) {
      return Look::kNone;
    }
    if (range > reach.farthest + kViewTolerance) {
      return Look::kBlocked;
    }
    return range < reach.nearest - kViewTolerance ? Look::kThrough : Look::kHit;
  }

 private:
  static constexpr float kNever = std::numeric_limits<float>::infinity();
  // Of 2 degrees, as lasers have a beam a degree and more.
  static constexpr std::size_t kSectorCount = 180;

  struct Reach {
    float nearest = kNever;  ///< [m]
    float farthest = -kNever;
  };

  static std::size_t sector_of(const Eigen::Vector2d& direction) {
    const double turns = (std::atan2(direction.y(), direction.x()) + kPi) / (2.0 * kPi);
    return std::min(kSectorCount - 1, static_cast<std::size_t>(turns * kSectorCount));
  }

  static Eigen::Vector2d laser_of(const PointScan& scan) {
    if (!scan.points.empty()) {
      return scan.points.front().origin;
    }
    return scan.free_rays.empty() ? Eigen::Vector2d::Zero().eval() : scan.free_rays.front().origin;
  }

  void see(const Eigen::Vector2d& way) {
    if (!way.allFinite()) {
      return;
    }
    Reach& reach = reaches_[sector_of(way)];
    const auto range = static_cast<float>(way.norm());
    reach.nearest = std::min(reach.nearest, range);
    reach.farthest = std::max(reach.farthest, range);
  }

  Pose2 map_from_laser_;  ///< at the first beam
  std::vector<Reach> reaches_;
};

class Selection {
 public:
  Selection(const PlacedScans& keys, std::size_t enough)
      : keys_(keys), enough_(enough), stays_(keys.size(), true) {}

  std::vector<std::uint64_t> run(std::uint64_t newest) {
    std::vector<std::uint64_t> superfluous;
    for (std::size_t i = 0; i < keys_.size(); ++i) {
      const std::uint64_t id = keys_[i].scan->id();
      if (id > 0 && id + kNewestKept <= newest && is_superfluous(i)) {
        stays_[i] = false;
        superfluous.push_back(id);
      }
    }
    return superfluous;
  }

 private:
  [[nodiscard]] bool is_superfluous(std::size_t key) {
    std::vector<std::size_t> newer;
    bool is_oldest = true;
    for (std::size_t i = 0; i < keys_.size(); ++i) {
      if (i != key && stays_[i] && is_beside(keys_[i], keys_[key])) {
        is_oldest = is_oldest && i > key;
        if (i > key) {
          newer.push_back(i);
        }
      }
    }
    if (newer.size() < enough_) {
      return false;
    }
    const std::vector<Eigen::Vector2d> hits = hits_of(keys_[key]);
    const auto most = [&hits](double share) { return share * static_cast<double>(hits.size()); };
    double lost = 0.0;
    double differing = 0.0;
    for (const Eigen::Vector2d& hit : hits) {
      const Looks looks = looks_at(hit, newer);
      const bool is_seen = 3 * (looks.hits + looks.through) >= enough_;
      lost += is_seen || is_seen_around(hit, key) ? 0.0 : 1.0;
      differing += 2 * std::max(looks.through, looks.blocked) > newer.size() ? 1.0 : 0.0;
    }
    return lost <= most(kMaxUniqueShare) && (!is_oldest || differing > most(kMinChangedShare));
  }

  struct Looks {
    std::size_t hits = 0;
    std::size_t through = 0;
    std::size_t blocked = 0;
  };

  [[nodiscard]] Looks looks_at(const Eigen::Vector2d& place, const std::vector<std::size_t>& from) {
    Looks looks;
    for (const std::size_t i : from) {
      const Look look = reach_of(i).at(place);
      looks.hits += look == Look::kHit ? 1 : 0;
      looks.through += look == Look::kThrough ? 1 : 0;
      looks.blocked += look == Look::kBlocked ? 1 : 0;
    }
    return looks;
  }

  [[nodiscard]] bool is_seen_around(const Eigen::Vector2d& place, std::size_t key) {
    const Eigen::Vector2d here = keys_[key].map_from_base.translation();
    for (std::size_t i = keys_.size(); i-- > 0;) {  // the newest are the least likely to go
      if (i == key || !stays_[i] ||
          (keys_[i].map_from_base.translation() - here).squaredNorm() >
              kSharedViewRadius * kSharedViewRadius) {
        continue;
      }
      const Look look = reach_of(i).at(place);
      if (look == Look::kHit || look == Look::kThrough) {
        return true;
      }
    }
    return false;
  }

  [[nodiscard]] const SeenReach& reach_of(std::size_t key) {
    const auto known = seen_.find(key);
    return known != seen_.end()
               ? known->second
               : seen_.emplace(key, SeenReach(*keys_[key].scan->points(), keys_[key].map_from_base))
                     .first->second;
  }

  const PlacedScans& keys_;
  std::size_t enough_;
  std::vector<bool> stays_;
  std::map<std::size_t, SeenReach> seen_;  ///< those that were asked
};

}  // namespace

std::vector<std::uint64_t> superfluous_scans(const PlacedScans& keys, std::uint64_t newest,
                                             std::size_t enough) {
  return enough > 0 ? Selection(keys, enough).run(newest) : std::vector<std::uint64_t>{};
}

bool is_crowded(const PlacedScans& keys, std::size_t enough) {
  const auto beside = std::count_if(
      keys.begin(), keys.end(), [&](const PlacedScan& key) { return is_beside(key, keys.back()); });
  return enough > 0 && static_cast<std::size_t>(beside) > enough + 1;  // and itself
}

}  // namespace matchbox_slam
