#pragma once

#include <string>
#include <vector>

#include "run/live_configuration.hpp"
#include "run/run_event.hpp"

namespace matchbox_slam {

/// Events as a YAML list, from which a run is repeated. Each names the scan before which it takes
/// effect, by its stamp [s] and where need be its laser and the time jumps before it, and one of
/// set_pose, correct_pose, be_anywhere, reset, load, pause, reconfigure and leave_out, with frames
/// and units of RunEvent:
///
///   - scan: 12.25
///     set_pose: {x: 1.0, y: 2.0, theta: 0.5, covariance: [0.1, 0, 0, 0, 0.1, 0, 0, 0, 0.05]}
///   - {scan: 13.05, correct_pose: {scan: 12.9, x: 1.0, y: 2.0, theta: 0.5}}
///   - {scan: 14.0, reset: true}
///   - {scan: 15.0, load: /maps/office.slam}
///   - {scan: 16.0, pause: true}
///   - {scan: 17.0, laser: 1, reconfigure: {matcher: hough, hough/peaks: 5}}
///
/// The same events read back are the same to the bit.
[[nodiscard]] std::string to_events_file(const std::vector<TimedEvent>& events);

/// Reads what `to_events_file` or a person wrote, in the order of its scans, and the maps that it
/// names. Throws ConfigurationError naming file, line and key.
/// @param configuration  that the run starts with.
[[nodiscard]] std::vector<TimedEvent> read_events_file(const std::string& path,
                                                       LiveConfiguration configuration);

}  // namespace matchbox_slam
