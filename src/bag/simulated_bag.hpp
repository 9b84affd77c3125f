#pragma once

#include <functional>
#include <string>

#include "bag/bag_writer.hpp"
#include "bag/simulation_record.hpp"
#include "matchbox_slam/common/options.hpp"
#include "simulation/simulated_run.hpp"

namespace matchbox_slam {

/// How a simulated run is recorded.
struct SimulatedBagOptions {
  std::string compression = "none";
  bool no_odometry = false;
  double clock_offset = 0.0;
  bool leading_slashes = false;
  bool imu = false;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor&& option) {
    option(self.compression, "compression", one_of({"none", "bz2", "lz4"}), "",
           "How the bag is packed.");
    option(self.no_odometry, "no_odometry", any(), "", "Leave the odometry out of the bag.");
    option(self.clock_offset, "clock_offset", between(-1e6, 1e6), "s",
           "By how much the clock of the laser, and with it the truth, is behind that of tf.");
    option(self.leading_slashes, "leading_slashes", any(), "",
           "Write frames as before tf2, such as /base_link.");
    option(self.imu, "imu", any(), "",
           "Write what an IMU tells on /imu; the odometry then tells nothing of how the robot "
           "rocks.");
  }
};

/// Records a run as the MIT Stata bags are: `/base_scan`, and on `/tf`, the links that never move
/// included, `odom_combined` -> `base_footprint` -> `base_link` -> `base_laser_link`; and how it
/// was made on `/simulation`. A second laser is on `/second_scan`, in `second_laser_link`.
/// The IMU lies on its side in `imu_link`, and its headings have an origin of their own. A message
/// is recorded a little later than its stamp says, so the transforms around a scan may come after
/// it.
class SimulatedBagWriter {
 public:
  /// Opens the bag, so that a path that cannot be written shows before the work starts. The bag is
  /// written beside its place until it is complete.
  /// Throws FileError.
  SimulatedBagWriter(std::string path, SimulatedBagOptions options);

  /// Writes the run and puts the bag in its place; to be called once.
  /// Throws FileError when that fails and ConfigurationError when the clock offset leads to stamps
  /// before 1970. Where `is_interrupted` says so it throws Interrupted, and there is no bag.
  void write(const SimulatedRun& run, const SimulationRecord& record,
             const std::function<bool()>& is_interrupted = {});

 private:
  SimulatedBagOptions options_;
  BagWriter bag_;
};

}  // namespace matchbox_slam
