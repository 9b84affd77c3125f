#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "bag/bag_reader.hpp"
#include "ros/clock_comparison.hpp"

namespace matchbox_slam {

/// What the beginning of a bag tells about its frames and clocks.
struct BagSurvey {
  std::string scan_frame;  ///< of the first topic's scans; empty when there is none
  /// Parents of each frame, without what touches the map frame.
  std::map<std::string, std::set<std::string>> parents;
  std::string map_frame;
  std::set<std::string> map_links;  ///< what touches it, for people, such as "map -> odom"
  /// Frames whose place in their parent came on /tf, and not on /tf_static.
  std::set<std::string> on_tf;
  /// Those of them whose place changed.
  std::set<std::string> moving;
  /// To be added to the stamps of scans so that they agree with tf's [s]: by how much the two
  /// differ from the time of recording, in the median. None without scans or tf.
  std::optional<double> scan_time_offset;
  std::string damage;  ///< why it ends early; empty: it does not
};

/// Reads the first ten seconds of a period, or its first sixty scans where these take longer, two
/// minutes at most, and on until a scan and its frame's place in tf are seen, but where it is known
/// otherwise. Ends early when interrupted, or where the bag is damaged after a scan.
[[nodiscard]] BagSurvey survey_bag(const BagReader& reader,
                                   const std::vector<std::string>& scan_topics,
                                   const BagPeriod& period, const std::string& map_frame,
                                   const std::function<bool()>& is_interrupted = {},
                                   const CloudOptions& cloud = {}, bool is_laser_placed = false);

/// The range [m] from which on readings of a laser are no return, as MaxRangeDetector finds it
/// first: from the beginning of the recording, whatever part of it is asked for, so that who maps
/// it in pieces, each going on with the map of the one before, has the same for all of them.
[[nodiscard]] std::optional<double> find_no_returns(const BagReader& reader,
                                                    const std::vector<std::string>& scan_topics,
                                                    const std::function<bool()>& is_interrupted,
                                                    const CloudOptions& cloud);

/// That a bag has no laser scans, and what it has instead, for people.
[[nodiscard]] std::string text_of_no_scans(const BagReader& reader);

/// The topics asked for, or the only one that there is: with laser scans, else with those of
/// several echoes, else with clouds. Throws ConfigurationError listing the scan topics when there
/// is more than one to choose from, or when one asked for carries something else, and all topics
/// when there is none.
[[nodiscard]] std::vector<std::string> choose_scan_topics(const BagReader& reader,
                                                          const std::vector<std::string>& asked);

/// The topic of an IMU of this name, as the bag has it. Throws ConfigurationError when there is
/// none.
[[nodiscard]] std::string find_imu_topic(const BagReader& reader, const std::string& asked);

/// The same of odometry.
[[nodiscard]] std::string find_odometry_topic(const BagReader& reader, const std::string& asked);

struct BagFrames {
  std::string base;
  std::optional<std::string> odom;  ///< none: without odometry
};

/// Completes what was asked for: the odometry frame is the uppermost one above the scan's frame
/// that goes by the name of odom or odom_combined, else the uppermost one below which anything
/// moves; the base frame is its child on the way to the scan's frame. Without odometry and without
/// tf the laser's own frame is the base. Where tf is not to tell where the laser is, the only link
/// that may be odometry counts, wherever it is. Throws ConfigurationError when there is no answer
/// or more than one, or when the odometry frame asked for is below the base frame.
[[nodiscard]] BagFrames choose_frames(const BagSurvey& survey,
                                      const std::optional<std::string>& asked_base,
                                      const std::optional<std::string>& asked_odom,
                                      bool use_odometry, bool is_laser_placed = false);

/// Whether tf has anything to choose as odometry, right or wrong: `choose_frames` tells.
[[nodiscard]] bool has_odometry(const BagSurvey& survey,
                                const std::optional<std::string>& asked_base,
                                const std::optional<std::string>& asked_odom, bool is_laser_placed);

/// Whether tf connects two frames.
[[nodiscard]] bool are_connected(const BagSurvey& survey, const std::string& a,
                                 const std::string& b);

/// All that tf names, for people; "none".
[[nodiscard]] std::string text_of_frames(const BagSurvey& survey);

}  // namespace matchbox_slam
