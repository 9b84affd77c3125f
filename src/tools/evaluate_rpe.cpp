#include "tools/evaluate_rpe.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/number_text.hpp"
#include "evaluation/relative_pose_error.hpp"
#include "tools/comparison.hpp"
#include "tools/json_text.hpp"
#include "tools/text_table.hpp"

namespace matchbox_slam {
namespace {

using RpeResult = Measured<RelativePoseError>;

/// Such as "per scan", "per 5 m".
std::string name_of(const PairRule& rule) {
  if (rule.unit == PairRule::Unit::kScan) {
    return "per scan";
  }
  const char* unit = rule.unit == PairRule::Unit::kSecond  ? " s"
                     : rule.unit == PairRule::Unit::kMetre ? " m"
                                                           : " rad";
  return fmt::format("per {:.0f}{}", rule.step, unit);
}

/// Such as "per_scan", "per_5_m".
std::string key_of(const PairRule& rule) {
  std::string key = name_of(rule);
  std::replace(key.begin(), key.end(), ' ', '_');
  return key;
}

void add_cells(const std::optional<ErrorStatistics>& statistics, double scale, int decimals,
               std::vector<std::string>& row) {
  if (!statistics) {
    row.insert(row.end(), 5, "–");
    return;
  }
  for (const double value :
       {statistics->rmse, statistics->mean, statistics->median, statistics->p95, statistics->max}) {
    row.push_back(fixed_text(scale * value, decimals));
  }
}

/// One table a measure, with a row for each estimate.
std::string tables_of(const std::vector<RpeResult>& results) {
  std::string text;
  for (std::size_t i = 0; i < results.front().error.measures.size(); ++i) {
    std::vector<std::vector<std::string>> rows = {
        {name_of(results.front().error.measures[i].rule), "pairs", "rmse m", "mean m", "median m",
         "p95 m", "max m", "rmse deg", "mean deg", "median deg", "p95 deg", "max deg"}};
    for (const auto& [name, error] : results) {
      const RelativePoseErrorMeasure& measure = error.measures[i];
      std::vector<std::string> row = {name, std::to_string(measure.differences.size())};
      add_cells(measure.translation, 1.0, 4, row);
      add_cells(measure.rotation, radians_to_degrees(1.0), 3, row);
      rows.push_back(row);
    }
    text += "\n" + format_table(rows);
  }
  return text;
}

std::string heading_of(const Truth& truth) {
  return fmt::format(
      "Relative pose error against {}\nPairs of the estimates' poses: consecutive ones, and those "
      "that are as far apart in time, along the true path or in true turning, within 10 %\n{}",
      truth.options.path, describe(truth));
}

nlohmann::json json_of(const Truth& truth, const std::vector<RpeResult>& results) {
  nlohmann::json estimates = nlohmann::json::array();
  for (const auto& [name, error] : results) {
    nlohmann::json measures;
    for (const RelativePoseErrorMeasure& measure : error.measures) {
      nlohmann::json& entry = measures[key_of(measure.rule)];  // null without pairs
      if (measure.translation && measure.rotation) {
        entry = {{"pairs", measure.differences.size()},
                 {"translation_m", to_json(*measure.translation)},
                 {"rotation_rad", to_json(*measure.rotation)}};
      }
    }
    estimates.push_back(nlohmann::json::object(
        {{"estimate", name}, {"without_truth", error.without_truth}, {"measures", measures}}));
  }
  nlohmann::json json = to_json(truth);
  json["metric"] = "rpe";
  json["estimates"] = estimates;
  return json;
}

nlohmann::json figure_of(const std::vector<RpeResult>& results) {
  nlohmann::json figure = {{"metric", "rpe"}, {"measures", nlohmann::json::array()}};
  for (std::size_t i = 0; i < results.front().error.measures.size(); ++i) {
    nlohmann::json drawn = {{"name", name_of(results.front().error.measures[i].rule)},
                            {"estimates", nlohmann::json::array()}};
    for (const auto& [name, error] : results) {
      nlohmann::json estimate = {{"name", name},
                                 {"stamp", nlohmann::json::array()},
                                 {"translation", nlohmann::json::array()},
                                 {"rotation", nlohmann::json::array()}};
      for (const RelativeDifference& difference : error.measures[i].differences) {
        estimate["stamp"].push_back(difference.stamp);
        estimate["translation"].push_back(difference.translation);
        estimate["rotation"].push_back(difference.rotation);
      }
      drawn["estimates"].push_back(estimate);
    }
    figure["measures"].push_back(drawn);
  }
  return figure;
}

void run(const ComparisonOptions& command) {
  require_plot_file(command.output.plot);
  const std::vector<Estimate> estimates = read_estimates(command.estimates);
  const Truth truth = read_truth(command.truth, estimates.front());
  RelativePoseErrorOptions options;
  options.max_gap = truth.options.max_gap;
  const auto results = measure_each<RelativePoseError>(
      estimates, truth.options.path, [&](const Trajectory& estimate) {
        return relative_pose_error(estimate, truth.trajectory, options);
      });
  warn_of_little_overlap(truth, estimates, results);
  present(command.output, json_of(truth, results), heading_of(truth) + tables_of(results),
          [&] { return figure_of(results); });
}

}  // namespace

void add_rpe_command(CLI::App& app) {
  const auto command = std::make_shared<ComparisonOptions>();
  CLI::App* rpe = app.add_subcommand(
      "rpe", "Relative pose error: how fast estimates drift, per scan, second, metre and radian");
  add_comparison_options(*rpe, *command);
  rpe->callback([command] { run(*command); });
}

}  // namespace matchbox_slam
