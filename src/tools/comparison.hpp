#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "geometry/trajectory.hpp"
#include "tools/evaluation_plot.hpp"
#include "tools/truth_options.hpp"

namespace matchbox_slam {

/// What every command that compares estimates with the truth is told.
struct ComparisonOptions {
  std::vector<std::string> estimates;  ///< their files
  TruthOptions truth;
  bool json = false;
  std::string plot;  ///< empty: none
};

inline void add_comparison_options(CLI::App& command, ComparisonOptions& options) {
  command.add_option("estimates", options.estimates, "Trajectories to evaluate, in the TUM format")
      ->type_name("EST.tum")
      ->required();
  add_truth_options(command, options.truth);
  command.add_flag("--json", options.json, "Print JSON instead of a table");
  add_plot_option(command, options.plot);
}

/// An estimate's file and its error.
template <typename Error>
struct Measured {
  std::string name;
  Error error;
};

/// Measures the estimates one after the other: `measure` is given two trajectories, the estimate
/// and the truth. An EvaluationError is thrown on with the names of both files.
template <typename Error, typename Measure>
[[nodiscard]] std::vector<Measured<Error>> measure_each(const std::vector<Estimate>& estimates,
                                                        const Truth& truth, Measure&& measure) {
  std::vector<Measured<Error>> results;
  for (const auto& [path, trajectory] : estimates) {
    try {
      results.push_back({path, measure(trajectory, truth.trajectory)});
    } catch (const EvaluationError& error) {
      throw EvaluationError(path + " against " + truth.options.path + ": " + error.what());
    }
  }
  return results;
}

}  // namespace matchbox_slam
