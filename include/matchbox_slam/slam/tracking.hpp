#pragma once

#include <utility>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/slam/doubt.hpp"
#include "matchbox_slam/slam/engine_options.hpp"
#include "matchbox_slam/slam/map_parts.hpp"
#include "matchbox_slam/slam/tracking_state.hpp"

namespace matchbox_slam {

/// How far it is believed that the robot is where matches have it: what score is usual, the doubt
/// that comes and goes, and the scans that are held until it is gone. A value.
class Tracking {
 public:
  Tracking() = default;
  Tracking(const TrackingDoubt& doubt, double usual_score, double contradicted_way,
           std::vector<WaitingScan> held)
      : doubt_(doubt),
        usual_score_(usual_score),
        contradicted_way_(contradicted_way),
        held_(std::move(held)) {}

  [[nodiscard]] const TrackingDoubt& doubt() const { return doubt_; }
  [[nodiscard]] double usual_score() const { return usual_score_; }
  [[nodiscard]] double contradicted_way() const { return contradicted_way_; }
  [[nodiscard]] const std::vector<WaitingScan>& held() const { return held_; }

  /// Of the next match.
  [[nodiscard]] Expectation expected() const {
    return {usual_score_, doubt_.doubts, contradicted_way_};
  }

  /// What becomes of the scans that were held.
  struct Held {
    std::vector<WaitingScan> confirmed;  ///< to be inserted
    bool is_any_dropped = false;
  };

  /// Takes what became of the next scan.
  /// @param stamp    [s] of that scan.
  /// @param seconds  since the scan before.
  /// @param way      [m] that the base moved since.
  [[nodiscard]] Held follow(const WeighedMatch& match, double stamp, double seconds, double way,
                            const Pose2& map_from_base, const EngineOptions& options);

  /// Keeps a scan until the place is confirmed.
  void hold(WaitingScan scan) { held_.push_back(std::move(scan)); }

  /// The robot is where it is thought to be now; what was held is dropped.
  void believe();

 private:
  TrackingDoubt doubt_;
  double usual_score_ = 0.0;       ///< of matches lately; 0: none is known
  double contradicted_way_ = 0.0;  ///< [m] since a match that the map does not contradict
  std::vector<WaitingScan> held_;
};

}  // namespace matchbox_slam
