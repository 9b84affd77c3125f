#include "tools/evaluate_relations.hpp"

#include <fmt/core.h>

#include <cstddef>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/number_text.hpp"
#include "evaluation/relation_error.hpp"
#include "io/relations_file.hpp"
#include "io/tum.hpp"
#include "tools/comparison.hpp"
#include "tools/text_table.hpp"

namespace matchbox_slam {
namespace {

struct RelationsCommand {
  std::vector<std::string> estimates;
  std::string relations;
  std::string odometry;  ///< empty: none
  OutputOptions output;
};

using RelationResult = Measured<RelationError>;

std::string spread_text(const ErrorSpread& spread, double scale, int decimals) {
  return fmt::format("{} ± {}", fixed_text(scale * spread.mean, decimals),
                     fixed_text(scale * spread.deviation, decimals));
}

std::string table_of(const std::vector<RelationResult>& results) {
  const double degrees = radians_to_degrees(1.0);
  std::vector<std::vector<std::string>> rows = {{"estimate", "usable", "unusable", "extrapolated",
                                                 "translation m", "max m", "squared m2",
                                                 "rotation deg", "max deg", "squared deg2"}};
  for (const auto& [name, error] : results) {
    rows.push_back(
        {name, std::to_string(error.differences.size()), std::to_string(error.unusable),
         std::to_string(error.extrapolated), spread_text(error.translation, 1.0, 4),
         fixed_text(error.translation.max, 4), spread_text(error.translation_squared, 1.0, 4),
         spread_text(error.rotation, degrees, 3), fixed_text(degrees * error.rotation.max, 3),
         spread_text(error.rotation_squared, degrees * degrees, 3)});
  }
  return format_table(rows);
}

std::string heading_of(const RelationsCommand& command, std::size_t count) {
  const std::string who = command.odometry.empty() ? "the estimate" : "odometry";
  const double distance = RelationErrorOptions{}.max_distance;
  return fmt::format(
      "Error against the {} relations of {}, mean ± standard deviation\n{}Unusable: {} has no pose "
      "within {:.1f} s of one of the stamps. Extrapolated: usable, but more than {:.1f} s before "
      "or after the estimate\n\n",
      count, command.relations,
      command.odometry.empty()
          ? "Between its poses the estimate is interpolated\n"
          : fmt::format("Between its poses the estimate is carried by the odometry of {}\n",
                        command.odometry),
      who, distance, distance);
}

nlohmann::json json_of(const RelationsCommand& command, std::size_t count,
                       const std::vector<RelationResult>& results) {
  const auto spread = [](const ErrorSpread& value) {
    return nlohmann::json::object(
        {{"mean", value.mean}, {"std", value.deviation}, {"max", value.max}});
  };
  const auto squared = [](const ErrorSpread& value) {
    return nlohmann::json::object({{"mean", value.mean}, {"std", value.deviation}});
  };
  const char* reason = command.odometry.empty() ? "no_estimate_nearby" : "no_odometry_nearby";
  nlohmann::json estimates = nlohmann::json::array();
  for (const auto& [name, error] : results) {
    estimates.push_back(
        nlohmann::json::object({{"estimate", name},
                                {"usable", error.differences.size()},
                                {"unusable", nlohmann::json::object({{reason, error.unusable}})},
                                {"extrapolated", error.extrapolated},
                                {"translation_m", spread(error.translation)},
                                {"translation_squared_m2", squared(error.translation_squared)},
                                {"rotation_rad", spread(error.rotation)},
                                {"rotation_squared_rad2", squared(error.rotation_squared)}}));
  }
  return nlohmann::json::object(
      {{"metric", "relations"},
       {"relations_file", command.relations},
       {"relations", count},
       {"odometry", command.odometry.empty() ? nlohmann::json() : nlohmann::json(command.odometry)},
       {"estimates", estimates}});
}

nlohmann::json figure_of(const std::vector<RelationResult>& results) {
  nlohmann::json figure = {{"metric", "relations"}, {"estimates", nlohmann::json::array()}};
  for (const auto& [name, error] : results) {
    nlohmann::json estimate = {{"name", name}};
    for (const RelationDifference& difference : error.differences) {
      estimate["translation"].push_back(difference.translation);
      estimate["rotation"].push_back(difference.rotation);
    }
    figure["estimates"].push_back(estimate);
  }
  return figure;
}

void run(const RelationsCommand& command) {
  require_plot_file(command.output.plot);
  const std::vector<Relation> relations = read_relations(command.relations);
  std::optional<Trajectory> odometry;
  if (!command.odometry.empty()) {
    odometry = read_tum(command.odometry);
  }
  const auto results = measure_each<RelationError>(
      read_estimates(command.estimates), command.relations,
      [&](const Trajectory& estimate) { return relation_error(estimate, relations, odometry); });
  present(command.output, json_of(command, relations.size(), results),
          heading_of(command, relations.size()) + table_of(results),
          [&] { return figure_of(results); });
}

}  // namespace

void add_relations_command(CLI::App& app) {
  const auto command = std::make_shared<RelationsCommand>();
  CLI::App* relations = app.add_subcommand(
      "relations", "Error against verified relative poses (Kümmerle et al. 2009)");
  relations
      ->add_option("estimates", command->estimates, "Trajectories to evaluate, in the TUM format")
      ->type_name("EST.tum")
      ->required();
  relations
      ->add_option("--relations", command->relations,
                   "Relative poses: lines of stamp1 stamp2 x y z roll pitch yaw")
      ->type_name("FILE")
      ->required();
  relations
      ->add_option("--odometry", command->odometry,
                   "Raw odometry, which carries the estimates to stamps between their poses")
      ->type_name("TUM");
  add_output_options(*relations, command->output);
  relations->callback([command] { run(*command); });
}

}  // namespace matchbox_slam
