#pragma once

#include <cstddef>
#include <string>

#include "bag/bag_scans.hpp"
#include "run/run_dialog.hpp"

namespace matchbox_slam {

/// What a conversion wrote.
struct ConvertedBag {
  std::size_t scans = 0;
  std::size_t transforms = 0;  ///< messages on /tf and /tf_static
  std::size_t others = 0;      ///< odometry and IMU
  std::string damage;          ///< why reading ended early; empty: it did not
};

/// Writes what map_bag reads of a recording in any format as a bag of ROS 1: the scans of the
/// topics that are asked for, else of all, in the period that is asked for, with tf, odometry and
/// IMU, each with the time of its recording. Mapped with the same options it gives the same map to
/// the byte. Says what is unusual about the recording and how far it has got. Throws
/// ConfigurationError where there is a file at the path already, or no topic that is asked for;
/// FileError when the bag cannot be written; BagError when nothing can be read; Interrupted when
/// the user ends it: then there is no bag.
[[nodiscard]] ConvertedBag convert_bag(const BagRequest& request, const std::string& path,
                                       const RunDialog& dialog);

}  // namespace matchbox_slam
