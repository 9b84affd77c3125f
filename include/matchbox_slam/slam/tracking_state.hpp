#pragma once

#include <optional>

#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/slam/doubt.hpp"

namespace matchbox_slam {

/// How sure it is where the robot is in the map.
enum class TrackingState {
  kTracking,     ///< the scans match
  kDoubt,        ///< they do not, or contradict the map; nothing is inserted
  kProvisional,  ///< they match again, which further scans have to confirm; insertion waits
  kLost,         ///< the robot may be anywhere: it maps on apart, and searches for the map
  kRecovered,    ///< it was found; what it mapped apart is being joined to the map
};

/// A word for logs and reports, such as "tracking".
[[nodiscard]] const char* to_string(TrackingState state);

struct TrackingOptions {
  int confirmations = 2;
  double lost_after = 1.0;
  double lost_way = 5.0;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor&& option) {
    option(self.confirmations, "confirmations", between(1, 100), "",
           "After a doubt, scans that have to match well, 0.1 m or 0.1 rad apart, before anything "
           "is inserted again.");
    option(self.lost_after, "lost_after", between(0.0, 1000.0), "s",
           "The robot counts as lost after this time of scans that contradict the map, five or "
           "more.");
    option(
        self.lost_way, "lost_way", between(0.0, 1000.0), "m",
        "After this way of scans, ten or more, that match nowhere, the robot counts as lost, too. "
        "Where they contradict nothing, as where nothing is mapped, and loops are closed, it maps "
        "on where odometry says instead. A provisional pose that nothing speaks against for so "
        "long is confirmed.");
  }
};

/// What leads from state to state: a doubtful match to doubt, a good one from there to a
/// provisional pose, and enough of them with motion between to tracking; too long without to being
/// lost. Scans from one place repeat its error, hence the motion. A value, to be copied and saved.
struct TrackingDoubt {
  bool doubts = false;             ///< since the last match that was confirmed
  bool is_provisional = false;     ///< else the newest match is no good
  double since = 0.0;              ///< [s] stamp of the first doubtful scan
  double way = 0.0;                ///< [m] driven since then, or since a provisional pose was
                                   ///< found or contradicted
  int doubtful = 0;                ///< scans since then that matched nowhere
  int contradictions = 0;          ///< of those, scans that contradicted the map
  double contradiction_sum = 0.0;  ///< of all those, of the shares of beams that contradicted it
  int confirmations = 0;  ///< scans that agree with a provisional pose, less contradicted ones
  Pose2 map_from_base;    ///< at the newest scan that counted

  /// To be called before `follow` with the time [s] since the scan before: where it is long, such
  /// as while a laser is tilted, most of it says nothing for or against the pose.
  void pass(double seconds);

  /// Takes what became of the next scan. Scans that say nothing, such as those of a covered laser,
  /// lead nowhere.
  /// @param way          [m] that the base moved since the scan before.
  /// @param usual_score  of matches before the doubt; 0: none is known.
  void follow(const WeighedMatch& match, double stamp, double way, const Pose2& map_from_base,
              double usual_score, const DoubtOptions& doubt, const TrackingOptions& options);

  /// Whether nothing matched for long, and hardly anything contradicted either.
  [[nodiscard]] bool is_blind(const TrackingOptions& options) const;

  [[nodiscard]] bool is_lost(double stamp, const TrackingOptions& options) const;
};

}  // namespace matchbox_slam
