#include "tools/evaluate_ate.hpp"

#include <fmt/core.h>

#include <cstddef>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/number_text.hpp"
#include "evaluation/absolute_trajectory_error.hpp"
#include "tools/comparison.hpp"
#include "tools/text_table.hpp"

namespace matchbox_slam {
namespace {

struct AteCommand : ComparisonOptions {
  std::string alignment = "se2";
};

using AteResult = Measured<AbsoluteTrajectoryError>;

std::vector<AteResult> evaluate(const AteCommand& command, const std::vector<Estimate>& estimates,
                                const Truth& truth) {
  AbsoluteTrajectoryErrorOptions options;
  options.alignment = command.alignment == "none" ? Alignment::kNone : Alignment::kSe2;
  options.max_gap = command.truth.max_gap;
  return measure_each<AbsoluteTrajectoryError>(
      estimates, truth.options.path, [&](const Trajectory& estimate) {
        return absolute_trajectory_error(estimate, truth.trajectory, options);
      });
}

std::string table_of(const std::vector<AteResult>& results) {
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

std::string heading_of(const AteCommand& command, const Truth& truth) {
  return fmt::format(
      "Absolute trajectory error against {}\nAlignment: {}\n{}\n", command.truth.path,
      command.alignment == "none"
          ? "none, the estimates are compared as they are"
          : "SE(2), each estimate is shifted and rotated onto the truth (Umeyama, no scale)",
      describe(truth));
}

nlohmann::json json_of(const AteCommand& command, const Truth& truth,
                       const std::vector<AteResult>& results) {
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
  nlohmann::json json = to_json(truth);
  json["metric"] = "ate";
  json["alignment"] = command.alignment;
  json["estimates"] = estimates;
  return json;
}

nlohmann::json figure_of(const Truth& truth, const std::vector<AteResult>& results) {
  nlohmann::json figure = {{"metric", "ate"}, {"estimates", nlohmann::json::array()}};
  for (const StampedPose2& stamped : truth.trajectory.poses()) {
    figure["truth"]["x"].push_back(stamped.pose.x);
    figure["truth"]["y"].push_back(stamped.pose.y);
  }
  for (const auto& [name, error] : results) {
    nlohmann::json estimate = {{"name", name}, {"rmse", error.translation.rmse}};
    for (const PosePair& pair : error.aligned_pairs) {
      estimate["stamp"].push_back(pair.stamp);
      estimate["x"].push_back(pair.estimate.x);
      estimate["y"].push_back(pair.estimate.y);
      estimate["error"].push_back((pair.estimate.translation() - pair.truth.translation()).norm());
    }
    figure["estimates"].push_back(estimate);
  }
  return figure;
}

void run(const AteCommand& command) {
  require_plot_file(command.output.plot);
  const std::vector<Estimate> estimates = read_estimates(command.estimates);
  const Truth truth = read_truth(command.truth, estimates.front());
  const std::vector<AteResult> results = evaluate(command, estimates, truth);
  warn_of_little_overlap(truth, estimates, results);
  present(command.output, json_of(command, truth, results),
          heading_of(command, truth) + table_of(results),
          [&] { return figure_of(truth, results); });
}

}  // namespace

void add_ate_command(CLI::App& app) {
  const auto command = std::make_shared<AteCommand>();
  CLI::App* ate = app.add_subcommand(
      "ate", "Absolute trajectory error: how far estimates are from the truth over all");
  add_comparison_options(*ate, *command);
  ate->add_option(
         "--align", command->alignment,
         "se2 (default): shift and rotate each estimate onto the truth first; none: leave it")
      ->check(CLI::IsMember({"se2", "none"}));
  ate->callback([command] { run(*command); });
}

}  // namespace matchbox_slam
