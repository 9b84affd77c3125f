#pragma once

#include <optional>
#include <string>
#include <vector>

#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/common/parameters.hpp"

namespace matchbox_slam {

/// What is made of the times of a laser's messages.
struct ScanTimingOptions {
  std::string sweep_time = "auto";
  std::string join_parts = "auto";

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor&& option) {
    option(
        self.sweep_time, "sweep_time", any(), "s",
        "From the first beam of a scan to the last: a number, 'as_sent' (messages are believed), "
        "or 'auto': where a laser turns all round and its messages tell what cannot be, what "
        "the scans of the moving robot show.");
    option(self.join_parts, "join_parts", any(), "",
           "So many scans in a row are the parts of one turn and are joined; 1: each is whole; "
           "'auto': as many as are seen to go on where the one before has ended.");
  }
};

/// How long the sweep of a scan takes; neither: what cannot be is found out.
struct SweepTimeSetting {
  bool as_sent = false;           ///< messages are believed
  std::optional<double> seconds;  ///< from the first beam to the last, whatever messages say
};

/// What they mean.
struct ScanTiming {
  SweepTimeSetting sweep_time;
  std::optional<int> join_parts;  ///< none: found out
};

/// What the texts mean. Throws ConfigurationError.
[[nodiscard]] ScanTiming scan_timing(const ScanTimingOptions& options);

/// Reads its options from the section `scan`, which has others, too. Throws ConfigurationError.
[[nodiscard]] ScanTimingOptions read_scan_timing_options(const Parameters& parameters);

/// The options by their full names.
[[nodiscard]] std::vector<OptionDescription> describe_scan_timing_options(
    const ScanTimingOptions& options);

}  // namespace matchbox_slam
