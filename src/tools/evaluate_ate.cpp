#include "evaluate_ate.hpp"

#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/evaluation/absolute_trajectory_error.hpp"
#include "matchbox_slam/io/tum.hpp"
#include "text_table.hpp"

namespace matchbox_slam {
namespace {

struct AteCommand {
  std::vector<std::string> estimates;
  std::string truth;
  std::string alignment = "se2";
  double max_gap = AbsoluteTrajectoryErrorOptions{}.max_gap;
  bool json = false;
};

struct Result {
  std::string name;
  AbsoluteTrajectoryError error;
};

std::vector<Result> evaluate(const AteCommand& command) {
  if (!(command.max_gap > 0.0)) {
    throw ConfigurationError("--max-gap: " + to_string(command.max_gap) +
                             " s is not allowed; allowed: more than 0");
  }
  AbsoluteTrajectoryErrorOptions options;
  options.alignment = command.alignment == "none" ? Alignment::kNone : Alignment::kSe2;
  options.max_gap = command.max_gap;
  const Trajectory truth = read_tum(command.truth);
  std::vector<Result> results;
  for (const std::string& path : command.estimates) {
    const Trajectory estimate = read_tum(path);
    try {
      results.push_back({path, absolute_trajectory_error(estimate, truth, options)});
    } catch (const EvaluationError& error) {
      throw EvaluationError(path + " against " + command.truth + ": " + error.what());
    }
  }
  return results;
}

std::string table_of(const std::vector<Result>& results) {
  constexpr int kDecimals = 4;
  std::vector<std::vector<std::string>> rows = {{"estimate", "poses", "no truth", "rmse m",
                                                 "mean m", "median m", "p95 m", "max m",
                                                 "heading rmse deg"}};
  for (const auto& [name, error] : results) {
    const ErrorStatistics& translation = error.translation;
    rows.push_back({name, std::to_string(translation.count), std::to_string(error.without_truth),
                    fixed_text(translation.rmse, kDecimals),
                    fixed_text(translation.mean, kDecimals),
                    fixed_text(translation.median, kDecimals),
                    fixed_text(translation.p95, kDecimals), fixed_text(translation.max, kDecimals),
                    fixed_text(radians_to_degrees(error.heading_rmse), 3)});
  }
  return format_table(rows);
}

std::string heading_of(const AteCommand& command) {
  return "Absolute trajectory error against " + command.truth + "\nAlignment: " +
         (command.alignment == "none"
              ? "none, the estimates are compared as they are"
              : "SE(2), each estimate is shifted and rotated onto the truth (Umeyama, no scale)") +
         "\nTruth interpolated at the stamps of the estimate, across gaps of up to " +
         fixed_text(command.max_gap, 2) + " s\n\n";
}

nlohmann::json json_of(const AteCommand& command, const std::vector<Result>& results) {
  nlohmann::json estimates = nlohmann::json::array();
  for (const auto& [name, error] : results) {
    const ErrorStatistics& translation = error.translation;
    const Pose2& moved = error.truth_from_estimate;
    estimates.push_back(nlohmann::json::object(
        {{"estimate", name},
         {"poses", translation.count},
         {"without_truth", error.without_truth},
         {"rmse_m", translation.rmse},
         {"mean_m", translation.mean},
         {"median_m", translation.median},
         {"p95_m", translation.p95},
         {"max_m", translation.max},
         {"heading_rmse_rad", error.heading_rmse},
         {"truth_from_estimate",
          nlohmann::json::object(
              {{"x_m", moved.x}, {"y_m", moved.y}, {"theta_rad", moved.theta}})}}));
  }
  return nlohmann::json::object({{"metric", "ate"},
                                 {"truth", command.truth},
                                 {"alignment", command.alignment},
                                 {"max_gap_s", command.max_gap},
                                 {"estimates", estimates}});
}

void run(const AteCommand& command) {
  const std::vector<Result> results = evaluate(command);
  if (command.json) {
    std::cout << json_of(command, results).dump(2) << std::endl;
  } else {
    std::cout << heading_of(command) << table_of(results) << std::flush;
  }
}

}  // namespace

void add_ate_command(CLI::App& app) {
  const auto command = std::make_shared<AteCommand>();
  CLI::App* ate = app.add_subcommand(
      "ate", "Absolute trajectory error: how far estimates are from the truth over all");
  ate->add_option("estimates", command->estimates, "Trajectories to evaluate, in the TUM format")
      ->type_name("EST.tum")
      ->required();
  ate->add_option("--truth", command->truth, "True trajectory, in the TUM format")
      ->type_name("FILE")
      ->required();
  ate->add_option(
         "--align", command->alignment,
         "se2 (default): shift and rotate each estimate onto the truth first; none: leave it")
      ->check(CLI::IsMember({"se2", "none"}));
  ate->add_option("--max-gap", command->max_gap,
                  "Truth is not interpolated across more than this [s] (default: " +
                      fixed_text(command->max_gap, 1) + ")");
  ate->add_flag("--json", command->json, "Print JSON instead of a table");
  ate->callback([command] { run(*command); });
}

}  // namespace matchbox_slam
