#pragma once

#include <cstddef>
#include <vector>

#include "run/slam_run.hpp"
#include "tools/movie_frame.hpp"
#include "tools/movie_map.hpp"

namespace matchbox_slam {

/// Looks at a run while it goes on, and keeps how it stood: a frame every so many scans. When there
/// are too many, every second one goes and the number of scans doubles, so that a movie has 60 to
/// 120 frames however long the drive is. Depends on the run alone, and changes nothing of it.
class MapMovie {
 public:
  static constexpr std::size_t kMostFrames = 120;

  /// After each scan. @param outcome  with the run's stamp.
  void add(const ScanOutcome& outcome, const SlamRun& run);

  /// The same, with how the run ends as the last one.
  [[nodiscard]] const std::vector<MovieFrame>& finish(const SlamRun& run);

 private:
  void note_others(const SlamRun& run);
  void take_frame(const SlamRun& run);
  void drop_every_second();

  MovieMap map_;
  std::vector<MovieFrame> frames_;
  std::vector<WeightedPose> others_;  ///< since the newest frame, where they had most weight
  TrackingState state_ = TrackingState::kTracking;
  std::size_t scans_ = 0;
  std::size_t scans_per_frame_ = 1;
  double first_stamp_ = 0.0;  ///< [s]
  double stamp_ = 0.0;        ///< of the newest scan [s]
};

}  // namespace matchbox_slam
