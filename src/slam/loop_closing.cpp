#include "matchbox_slam/slam/loop_closing.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "matchbox_slam/geometry/pose_covariance.hpp"
#include "matchbox_slam/graph/optimise.hpp"
#include "slam/graph_distance.hpp"
#include "slam/loop_search.hpp"

namespace matchbox_slam {
namespace {

constexpr std::size_t kTogether = 40;  // edges of the graph

/// Of a pose as seen from another one that it was found from.
Eigen::Matrix3d in_frame_of(const Pose2& map_from_frame, const Eigen::Matrix3d& map_covariance) {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(-map_from_frame.theta).toRotationMatrix();
  return turn * map_covariance * turn.transpose();
}

MapCorrection correction_of(const PlacedScans& keys, const std::vector<Pose2>& new_map_from_base) {
  MapCorrection correction;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const Pose2 new_from_old = new_map_from_base[i] * keys[i].map_from_base.inverse();
    correction.steps.push_back({keys[i].scan->stamp(), new_from_old});
    const Eigen::Vector2d moved =
        new_map_from_base[i].translation() - keys[i].map_from_base.translation();
    correction.most_moved = std::max(correction.most_moved, moved.norm());
  }
  correction.newest = correction.steps.back().new_from_old;
  // What was mapped by a lost robot came later into the map than it was seen.
  std::stable_sort(correction.steps.begin(), correction.steps.end(),
                   [](const auto& a, const auto& b) { return a.since < b.since; });
  return correction;
}

}  // namespace

LoopCloser::LoopCloser(State state)
    : graph_(std::move(state.graph)),
      loops_(std::move(state.loops)),
      way_(state.way),
      tries_(state.tries) {
  if (!empty()) {
    find_ways();
  }
}

std::size_t LoopCloser::closed() const {
  return static_cast<std::size_t>(std::count_if(
      loops_.begin(), loops_.end(), [](const ClosedLoop& loop) { return loop.believed; }));
}

void LoopCloser::add(const KeyScans& keys, const Eigen::Matrix3d& map_covariance, bool is_continued,
                     const LoopOptions& options) {
  constexpr double kFound = 0.1;          // [m], how well a place is found anew
  constexpr double kFoundHeading = 0.05;  // [rad]
  const PlacedScans& all = keys.all();
  const std::size_t newest = all.size() - 1;
  while (graph_.poses.size() < newest) {
    join_rigidly(all);
  }
  Eigen::Matrix3d covariance = map_covariance;
  if (!is_continued) {
    covariance += covariance_of(kFound, kFoundHeading);
  }
  join_to_before(all, covariance, options);
  find_ways();
  join_to_earlier(keys, is_continued, options);
}

/// Of a map that comes without its graph nobody knows how it drifted: it stays as it is.
void LoopCloser::join_rigidly(const PlacedScans& keys) {
  constexpr double kXy = 1e-3;     // [m]
  constexpr double kTheta = 1e-4;  // [rad]
  const std::size_t node = graph_.poses.size();
  graph_.poses.push_back(keys[node].map_from_base);
  if (node > 0) {
    const Pose2 moved = keys[node - 1].map_from_base.inverse() * keys[node].map_from_base;
    graph_.edges.push_back({node - 1, node, moved, covariance_of(kXy, kTheta)});
  }
}

void LoopCloser::find_ways() {
  GraphWays ways = ways_from(graph_, graph_.poses.size() - 1);
  variances_ = std::move(ways.variances);
  edges_ = std::move(ways.edges);
}

std::vector<bool> LoopCloser::apart(const LoopOptions& options) const {
  std::vector<bool> apart(variances_.size());
  for (std::size_t i = 0; i < apart.size(); ++i) {
    apart[i] = edges_[i] > kTogether && variances_[i] > options.apart * options.apart;
  }
  return apart;
}

void LoopCloser::join_to_before(const PlacedScans& keys, const Eigen::Matrix3d& map_covariance,
                                const LoopOptions& options) {
  const std::size_t node = graph_.poses.size();
  graph_.poses.push_back(keys[node].map_from_base);
  if (node == 0) {
    return;
  }
  constexpr double kMetresPerRadian = 0.3;  // a turn drifts as so much way
  constexpr double kLeastWay = 0.01;        // [m]
  const Pose2& before = keys[node - 1].map_from_base;
  const Pose2 moved = before.inverse() * keys[node].map_from_base;
  const double way =
      std::max(kLeastWay, moved.translation().norm() + kMetresPerRadian * std::abs(moved.theta));
  way_ += way;
  const Eigen::Matrix3d drift = way * covariance_of(options.drift_xy, options.drift_theta);
  graph_.edges.push_back({node - 1, node, moved, drift + in_frame_of(before, map_covariance)});
}

/// What is matched with belongs together from now on, too; and what lies where the robot was found.
void LoopCloser::join_to_earlier(const KeyScans& keys, bool is_continued,
                                 const LoopOptions& options) {
  constexpr double kNear = 2.0;         // [m]
  constexpr std::size_t kEarlier = 30;  // key scans
  const PlacedScans& all = keys.all();
  const std::size_t newest = all.size() - 1;
  const std::vector<bool> is_apart = apart(options);
  std::optional<std::size_t> nearest;
  double least = kNear;
  for (std::size_t i = 0; i + kEarlier < newest; ++i) {
    const double distance =
        (all[i].map_from_base.translation() - all[newest].map_from_base.translation()).norm();
    if (distance < least && (!is_apart[i] || !is_continued)) {
      least = distance;
      nearest = i;
    }
  }
  if (!nearest) {
    return;
  }
  if (const std::optional<FoundLoop> found = find_near(all, *nearest)) {
    graph_.edges.push_back({*nearest, newest, found->key_from_newest, found->covariance});
    find_ways();
  }
}

std::optional<MapCorrection> LoopCloser::search(const KeyScans& keys, const LoopOptions& options) {
  if (way_ < options.search_way) {
    return std::nullopt;
  }
  const PlacedScans& all = keys.all();
  const std::size_t newest = all.size() - 1;
  for (const std::size_t candidate : loop_candidates(all, apart(options), variances_, options)) {
    way_ = 0.0;
    ++tries_;
    const std::optional<FoundLoop> found =
        find_loop(all, candidate, std::sqrt(variances_[candidate]), options);
    if (!found) {
      continue;
    }
    graph_.edges.push_back(
        {found->key, newest, found->key_from_newest, found->covariance, EdgeKind::kLoop});
    OptimisedGraph best = optimise(graph_);
    ClosedLoop loop{*found, newest, best.graph.edges.back().belief == Belief::kBelieved,
                    best.chi_square.back(), 0.0};
    if (!loop.believed) {
      loops_.push_back(loop);
      continue;
    }
    const MapCorrection correction = correction_of(all, best.graph.poses);
    loop.moved = correction.most_moved;
    loops_.push_back(loop);
    graph_ = std::move(best.graph);
    find_ways();
    return correction;
  }
  return std::nullopt;
}

}  // namespace matchbox_slam
