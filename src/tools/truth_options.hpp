#pragma once

#include <CLI/CLI.hpp>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "evaluation/clock_offset.hpp"
#include "geometry/trajectory.hpp"

namespace matchbox_slam {

/// What is said on the command line of the truth that estimates are compared with.
struct TruthOptions {
  std::string path;       ///< TUM, or the format of the MIT Stata Center data set
  std::string lever_arm;  ///< "X[,Y[,THETA]]": pose of the truth's body on the estimate's [m, rad]
  double time_offset = 0.0;                          ///< [s], added to the truth's stamps
  bool find_offset = false;                          ///< whether that is estimated instead
  double offset_range = ClockOffsetOptions{}.range;  ///< [s], how far it is searched both ways
  double max_gap = ClockOffsetOptions{}.max_gap;     ///< [s], truth is not interpolated across more
};

/// A trajectory, and the file it is from.
struct Estimate {
  std::string path;
  Trajectory trajectory;
};

/// Truth made comparable, and what was done to it.
struct Truth {
  Trajectory trajectory;  ///< of the estimate's body, in the estimate's clock
  TruthOptions options;
  Pose2 base_from_truth_body;         ///< the lever arm
  double time_offset = 0.0;           ///< [s], was added to the stamps
  std::optional<ClockOffset> search;  ///< when the offset was searched ...
  std::string searched_with;          ///< ... the estimate it was searched with
};

/// Adds `--truth`, which is required, and its companions to a command.
void add_truth_options(CLI::App& command, TruthOptions& options);

/// Reads trajectories in the TUM format. Throws FileError.
[[nodiscard]] std::vector<Estimate> read_estimates(const std::vector<std::string>& paths);

/// Reads the truth, moves it to the estimates' body and shifts it to their clock. All estimates
/// are compared with the same truth: an offset that is to be found is found with the first one.
/// Throws ConfigurationError for options that are not allowed, FileError, and EvaluationError when
/// no offset is found.
[[nodiscard]] Truth read_truth(const TruthOptions& options, const Estimate& first_estimate);

/// What to tell people when less than 80 % of an estimate's poses have truth, with the offset
/// between the clocks that the trajectories themselves tell; else empty.
[[nodiscard]] std::string text_of_little_overlap(const Truth& truth, const Estimate& estimate,
                                                 std::size_t without_truth);

/// What was done to the truth, in lines for people; with the curve of a search around its least.
[[nodiscard]] std::string describe(const Truth& truth);

/// The same with the whole curve: members `truth`, `max_gap_s`, `lever_arm` (null without),
/// `time_offset_s` and `offset_search` (null without).
[[nodiscard]] nlohmann::json to_json(const Truth& truth);

}  // namespace matchbox_slam
