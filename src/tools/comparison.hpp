#pragma once

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <cstddef>
#include <iostream>
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
  OutputOptions output;
};

inline void add_comparison_options(CLI::App& command, ComparisonOptions& options) {
  command.add_option("estimates", options.estimates, "Trajectories to evaluate, in the TUM format")
      ->type_name("EST.tum")
      ->required();
  add_truth_options(command, options.truth);
  add_output_options(command, options.output);
}

/// An estimate's file and its error.
template <typename Error>
struct Measured {
  std::string name;
  Error error;
};

/// Measures the estimates one after the other. An EvaluationError is thrown on with the names of
/// the estimate's file and of what it is compared with.
template <typename Error, typename Measure>
[[nodiscard]] std::vector<Measured<Error>> measure_each(const std::vector<Estimate>& estimates,
                                                        const std::string& against,
                                                        Measure&& measure) {
  std::vector<Measured<Error>> results;
  for (const auto& [path, trajectory] : estimates) {
    try {
      results.push_back({path, measure(trajectory)});
    } catch (const EvaluationError& error) {
      throw EvaluationError(fmt::format("{} against {}: {}", path, against, error.what()));
    }
  }
  return results;
}

/// @param results  of the estimates, in their order.
template <typename Error>
void warn_of_little_overlap(const Truth& truth, const std::vector<Estimate>& estimates,
                            const std::vector<Measured<Error>>& results) {
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    const std::string text =
        text_of_little_overlap(truth, estimates[i], results[i].error.without_truth);
    if (!text.empty()) {
      std::cerr << "warning: " << text << std::endl;
    }
  }
}

}  // namespace matchbox_slam
