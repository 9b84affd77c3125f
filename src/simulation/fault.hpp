#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace matchbox_slam {

/// What can go wrong on a drive.
enum class FaultKind {
  kFreeze,       ///< odometry stands still, and afterwards is where it would have been
  kEncoders,     ///< odometry stands still, and what was driven meanwhile is never told
  kHeadingSlip,  ///< turns are told too large by a share of them; negative: too small
  kWaySlip,      ///< likewise distances
  kJump,         ///< odometry jumps by some metres, in a random direction
  kTurnJump,     ///< odometry jumps by some radians
  kKidnap,       ///< the robot is carried to a place some metres away or farther, and goes on there
  kDropout,      ///< no scan comes
  kCovered,      ///< a share of the beams, side by side, ends on a cover 5 cm away
  kPeople,       ///< a share of the beams ends early, on people and doors that move
};

/// A fault and when it happens.
struct Fault {
  FaultKind kind = FaultKind::kFreeze;
  double time = std::numeric_limits<double>::quiet_NaN();  ///< [s] since the start; NaN: random
  double duration = 0.0;                                   ///< [s]; jumps take none
  double amount = 0.0;  ///< share, [m] or [rad], as the kind says; 0 where it has none

  /// From its beginning up to its end.
  /// @param since_start  [s]
  [[nodiscard]] bool is_on(double since_start) const {
    return since_start >= time && since_start < time + duration;
  }
};

/// Whether a fault of this kind is on.
[[nodiscard]] bool is_any_on(FaultKind kind, double since_start, const std::vector<Fault>& faults);

/// A fault from its text KIND:TIME:DURATION:AMOUNT, such as "freeze:20:1.5", "jump:30::0.5" or
/// "heading_slip:random:2:-0.5". Duration and amount may be left out, and have a kind's defaults
/// then. Throws ConfigurationError naming what is allowed.
[[nodiscard]] Fault parse_fault(const std::string& text);

/// The text that parse_fault reads, with everything in it.
[[nodiscard]] std::string to_string(const Fault& fault);

/// What may be written, a line a kind, for --help.
[[nodiscard]] std::string fault_help();

/// Draws the times that are random: uniformly over the run, but for 10 s before and after each
/// where the run is long enough. Throws ConfigurationError for a time after the end of the run.
/// @param run_duration  [s]
[[nodiscard]] std::vector<Fault> with_drawn_times(std::vector<Fault> faults, double run_duration,
                                                  std::uint64_t seed);

}  // namespace matchbox_slam
