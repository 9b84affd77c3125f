#pragma once

#include <vector>

#include "matchbox_slam/slam/slam_engine.hpp"
#include "run/slam_run.hpp"
#include "tools/report_page.hpp"

namespace matchbox_slam {

/// How sure the robot was of its place after each scan of a drive, as it was told at the time.
class DriveRecord {
 public:
  /// @param outcome  with the run's stamp. @param stamp  by the robot's clock [s].
  void add(const ScanOutcome& outcome, double stamp);

  /// One a scan, each where the run has the robot now: loops have moved it since. Those that are
  /// not in the map have no place.
  [[nodiscard]] std::vector<PagePoint> points(const SlamRun& run) const;

 private:
  struct Scan {
    double run_stamp;  ///< [s]
    double stamp;      ///< [s]
    float sigma;       ///< [m]
    TrackingState state;
    Certainty certainty;
  };
  std::vector<Scan> scans_;
};

}  // namespace matchbox_slam
