#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace matchbox_slam {

/// What a line of a log tells of its time.
struct CarmenMoment {
  std::size_t line = 0;                ///< its number
  bool is_beat = false;                ///< a scan of the laser that has most of them
  std::optional<double> ipc_stamp;     ///< [s]
  std::optional<double> logger_stamp;  ///< [s] from the log's beginning
};

struct CarmenStamps {
  std::vector<double> stamps;  ///< one a moment [s]
  std::string remark;          ///< where they are not those of the log: why; else empty
};

/// The stamps in use: those that the messages were sent with; where these are missing, or were cut
/// to so few digits that scans have the same, those of the logger; where these are no better, made
/// up at a second a scan, with what lies between two scans spread evenly. Those that are not of the
/// messages begin at 1e9 s.
[[nodiscard]] CarmenStamps choose_stamps(const std::vector<CarmenMoment>& moments);

/// Where the clock was set back in the middle of a log: the places of the first moments after that,
/// in their order. Three scans in a row tell, each more than a second before the three that came
/// before them; fewer are stamps that are wrong.
/// @param stamps  [s] of the moments.
[[nodiscard]] std::vector<std::size_t> find_clock_steps(const std::vector<CarmenMoment>& moments,
                                                        const std::vector<double>& stamps);

}  // namespace matchbox_slam
