#include "tools/map_movie.hpp"

#include <utility>

namespace matchbox_slam {
namespace {

double weight_of(const std::vector<WeightedPose>& poses) {
  double sum = 0.0;
  for (const WeightedPose& pose : poses) {
    sum += pose.weight;
  }
  return sum;
}

MovieFrame::Point point_of(const Pose2& pose) { return pose.translation().cast<float>(); }

/// The way of the base in the map, in pieces no shorter than a cell.
std::vector<std::vector<MovieFrame::Point>> path_of(const SlamRun& run, double cell) {
  std::vector<std::vector<MovieFrame::Point>> path;
  bool goes_on = false;
  for (const StampedPose2& pose : run.path().poses()) {
    if (!run.is_in_map(pose.stamp)) {
      goes_on = false;
      continue;
    }
    const MovieFrame::Point point = point_of(pose.pose);
    if (!goes_on) {
      path.push_back({point});
    } else if ((point - path.back().back()).norm() >= cell) {
      path.back().push_back(point);
    }
    goes_on = true;
  }
  return path;
}

std::vector<std::pair<MovieFrame::Point, MovieFrame::Point>> loops_of(const PoseGraph& graph) {
  std::vector<std::pair<MovieFrame::Point, MovieFrame::Point>> loops;
  for (const PoseEdge& edge : graph.edges) {
    if (edge.kind == EdgeKind::kLoop && is_used(edge)) {
      loops.emplace_back(point_of(graph.poses[edge.from]), point_of(graph.poses[edge.to]));
    }
  }
  return loops;
}

}  // namespace

/// Hypotheses come and go between frames.
void MapMovie::note_others(const SlamRun& run) {
  std::vector<WeightedPose> others = run.likely_poses();
  if (state_ != TrackingState::kLost && !others.empty()) {
    others.erase(others.begin());
  }
  if (weight_of(others) > weight_of(others_)) {
    others_ = std::move(others);
  }
}

void MapMovie::add(const ScanOutcome& outcome, const SlamRun& run) {
  if (scans_ == 0) {
    first_stamp_ = outcome.stamp;
  }
  stamp_ = outcome.stamp;
  state_ = outcome.state;
  note_others(run);
  if (scans_++ % scans_per_frame_ == 0) {
    take_frame(run);
    if (frames_.size() > kMostFrames) {
      drop_every_second();
    }
  }
}

void MapMovie::take_frame(const SlamRun& run) {
  map_.draw(run.key_scans().all(), run.setup().engine.map.resolution);
  MovieFrame frame;
  frame.time = stamp_ - first_stamp_;
  frame.state = state_;
  frame.level = map_.level();
  frame.map = MapShades(map_.grid());
  frame.path = path_of(run, map_.grid().geometry().resolution());
  frame.loops = loops_of(run.graph());
  if (run.is_in_map(stamp_)) {
    frame.robot = run.trajectory().back().pose;
  }
  frame.others = std::exchange(others_, {});
  frames_.push_back(std::move(frame));
}

void MapMovie::drop_every_second() {
  std::size_t kept = 1;
  for (std::size_t i = 2; i < frames_.size(); i += 2) {
    std::vector<WeightedPose>& others = frames_[i - 1].others;
    if (weight_of(others) > weight_of(frames_[i].others)) {
      std::swap(frames_[i].others, others);
    }
    frames_[kept++] = std::move(frames_[i]);
  }
  frames_.resize(kept);
  scans_per_frame_ *= 2;
}

const std::vector<MovieFrame>& MapMovie::finish(const SlamRun& run) {
  if (!frames_.empty() && frames_.back().time == stamp_ - first_stamp_) {
    others_ = std::move(frames_.back().others);
    frames_.pop_back();
  }
  take_frame(run);
  return frames_;
}

}  // namespace matchbox_slam
