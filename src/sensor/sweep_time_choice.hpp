#pragma once

#include <Eigen/Geometry>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/sensor/laser_scan.hpp"
#include "sensor/scan_timing.hpp"
#include "sensor/sweep_time.hpp"

namespace matchbox_slam {

/// The sweep of a laser as its scans have shown it.
struct ShownSweep {
  double seconds = 0.0;   ///< from the first beam to the last
  std::size_t scans = 0;  ///< that have told of it
  std::string text;       ///< for people, with what messages tell; empty: that is the same
};

/// Decides how long the sweep of one laser's scans takes. Drivers of lasers that turn all round
/// often send times that cannot be: 0, or an increment that is twenty times too small. By itself it
/// believes what can be. Where what is sent cannot be, it takes a sweep to last from scan to scan,
/// or no time where that is sent, until the scans of the moving robot tell: the likelier of both at
/// once, anything else when one or two more of them say so. A laser that takes all beams at once is
/// one whose scans tell so.
class SweepTimeChoice {
 public:
  /// @param shown  [s]: the sweep, as scans have shown it before; they are not asked again.
  explicit SweepTimeChoice(const SweepTimeSetting& setting, std::optional<double> shown = {})
      : setting_(setting), settled_(shown), is_final_(shown.has_value()) {}

  /// Where the base is at the stamp [s] of the next scan, before what is asked of that: it tells
  /// how the robot moved while the scan before was taken. Once more for the same scan is allowed.
  /// @param odom_from_base_at  of a stamp before that; none: it is not known.
  void note_pose(double stamp, const Pose2& odom_from_base,
                 const std::function<std::optional<Pose2>(double stamp)>& odom_from_base_at);

  /// Time from beam to beam [s] of the next scan, in the order of their stamps.
  /// @param sent_scan_time  [s], from scan to scan by the message; 0: it does not say.
  [[nodiscard]] double time_increment(const LaserScan& as_sent, double sent_scan_time);

  /// The scan as it was used.
  /// @param sent_increment  [s] between beams, by the message.
  void add(const LaserScan& scan, double sent_increment, const Eigen::Isometry3d& base_from_laser,
           const Pose2& odom_from_base);

  /// Whether scans are asked still how long they take.
  [[nodiscard]] bool is_undecided() const { return is_doubtful_ && !is_final_; }
  [[nodiscard]] bool is_final() const { return is_final_; }

  /// Whether scans that are still to come may show a sweep of the laser: they are asked, or too few
  /// have come to know whether what is sent can be.
  [[nodiscard]] bool is_open() const;
  /// What scans have shown so far; none: nothing.
  [[nodiscard]] std::optional<ShownSweep> shown() const;

  /// What was decided since the last call, for people; empty: nothing.
  [[nodiscard]] std::string take_news();

 private:
  void note_stamp(double stamp);
  [[nodiscard]] std::optional<double> period() const;
  [[nodiscard]] bool may_be_looked_at(const LaserScan& scan) const;
  [[nodiscard]] bool can_be(const LaserScan& as_sent, double sent_scan_time) const;
  [[nodiscard]] double log_likelihood_ratio(double sweep) const;
  [[nodiscard]] double likeliest() const;
  void decide(double whole);
  void settle(double sweep, double told, const std::string& which);

  SweepTimeSetting setting_;
  std::optional<double> last_stamp_;
  std::deque<double> gaps_;   ///< [s] between the latest scans
  bool is_believed_ = false;  ///< it is not of a laser that turns all round, or set
  bool is_doubtful_ = false;  ///< what is sent can not be, or says nothing
  bool has_told_ = false;     ///< that it cannot be
  std::optional<double>
      settled_;                  ///< [s] from the first beam to the last; none: scans have not told
  bool is_final_ = false;        ///< enough of them have
  std::optional<double> known_;  ///< [s], settled, as people were told last
  SweepTimeEstimator estimator_;
  std::vector<ToldSweepTime> told_;
  std::optional<MovingScan> last_;  ///< whose motion the next scan tells
  double sent_ = 0.0;               ///< [s] that its sweep takes by the message
  std::string finding_;             ///< what was settled last, for people
  std::size_t finding_scans_ = 0;   ///< that had told then
  std::string news_;
};

}  // namespace matchbox_slam
