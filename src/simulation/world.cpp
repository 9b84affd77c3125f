#include "simulation/world.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "matchbox_slam/common/random.hpp"

namespace matchbox_slam {
namespace {

std::vector<WallSegment> checked(std::vector<WallSegment> segments, std::size_t walks) {
  for (std::size_t i = 0; i < segments.size(); ++i) {
    if (!segments[i].start.allFinite() || !segments[i].end.allFinite() ||
        !(segments[i].length() > 0.0)) {
      throw std::invalid_argument("wall segment " + std::to_string(i) + " has length " +
                                  std::to_string(segments[i].length()) +
                                  "; it must be finite and above 0");
    }
    if (segments[i].surface.walk && *segments[i].surface.walk >= walks) {
      throw std::invalid_argument("wall segment " + std::to_string(i) + " goes way " +
                                  std::to_string(*segments[i].surface.walk) + " of " +
                                  std::to_string(walks) + "; it must be one of them");
    }
  }
  return segments;
}

}  // namespace

World::World(std::vector<WallSegment> segments, Route route, std::vector<Walk> walks,
             std::uint64_t seed, std::vector<Thing> things)
    : segments_(checked(std::move(segments), walks.size())),
      route_(std::move(route)),
      walks_(std::move(walks)),
      seed_(seed),
      things_(std::move(things)),
      grid_(segments_),
      walkers_(walkers()) {}

std::vector<World::Walkers> World::walkers() const {
  std::vector<Walkers> walkers(walks_.size());
  for (std::size_t i = 0; i < segments_.size(); ++i) {
    const WallSegment& segment = segments_[i];
    if (segment.surface.walk) {
      const Eigen::Vector2d place = walks_[*segment.surface.walk].at(0.0);
      Walkers& those = walkers[*segment.surface.walk];
      those.segments.push_back(i);
      those.reach =
          std::max({those.reach, (segment.start - place).norm(), (segment.end - place).norm()});
    }
  }
  return walkers;
}

std::optional<SegmentGrid::Hit> World::first_moving_hit(const Eigen::Vector2d& origin,
                                                        const Eigen::Vector2d& direction,
                                                        double nearest,
                                                        const RayMoment& moment) const {
  std::optional<SegmentGrid::Hit> best;
  for (std::size_t k = 0; k < walks_.size(); ++k) {
    const Eigen::Vector2d place = walks_[k].at(moment.time);
    const Eigen::Vector2d to_place = place - origin;
    const double aside = direction.x() * to_place.y() - direction.y() * to_place.x();
    if (std::abs(aside) > walkers_[k].reach || direction.dot(to_place) < -walkers_[k].reach) {
      continue;
    }
    // As seen from the thing where it is at time 0.
    const Eigen::Vector2d origin_then = origin - place + walks_[k].at(0.0);
    for (const std::size_t i : walkers_[k].segments) {
      const std::optional<double> range = intersect_ray(segments_[i], origin_then, direction);
      if (range && *range < nearest &&
          !lets_pass(segments_[i], direction, mix_seed(moment.chance, i))) {
        nearest = *range;
        best = SegmentGrid::Hit{*range, i};
      }
    }
  }
  return best;
}

std::optional<RayHit> World::cast_ray(const Eigen::Vector2d& origin,
                                      const Eigen::Vector2d& direction, double max_range,
                                      const RayPart& at_tables, const RayMoment& moment) const {
  std::optional<SegmentGrid::Hit> hit =
      grid_.first_hit(segments_, origin, direction, max_range, at_tables, moment.chance);
  if (!walks_.empty()) {
    const auto moving = first_moving_hit(origin, direction, hit ? hit->range : max_range, moment);
    hit = moving ? moving : hit;
  }
  if (!hit) {
    return std::nullopt;
  }
  const WallSegment& segment = segments_[hit->segment];
  const Eigen::Vector2d normal = segment.normal();
  const double depth = depth_of_return(segment, mix_seed(~moment.chance, hit->segment));
  return RayHit{hit->range + depth, hit->segment, normal.dot(direction) > 0.0 ? -normal : normal};
}

}  // namespace matchbox_slam
