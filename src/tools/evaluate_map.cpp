#include "tools/evaluate_map.hpp"

#include <fmt/core.h>

#include <cstddef>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/number_text.hpp"
#include "evaluation/map_quality.hpp"
#include "geometry/trajectory.hpp"
#include "matchbox_slam/io/map_file.hpp"
#include "tools/evaluation_plot.hpp"
#include "tools/text_table.hpp"

namespace matchbox_slam {
namespace {

struct MapCommand {
  std::vector<std::string> maps;
  OutputOptions output;
};

struct MeasuredMap {
  std::string name;
  MapImage map;
  MapQuality quality;
};

std::vector<MeasuredMap> measure(const MapCommand& command) {
  std::vector<MeasuredMap> results;
  for (const std::string& path : command.maps) {
    MapImage map = read_map(path);
    try {
      MapQuality quality = measure_map_quality(map);
      results.push_back({path, std::move(map), std::move(quality)});
    } catch (const EvaluationError& error) {
      throw EvaluationError(fmt::format("{}: {}", path, error.what()));
    }
  }
  return results;
}

double metres(int cells, const MapImage& map) { return cells * map.resolution; }

std::string table_of(const std::vector<MeasuredMap>& results) {
  std::vector<std::vector<std::string>> rows = {{"map", "resolution m", "size m", "known cells",
                                                 "occupied/known", "occupied/free", "corners",
                                                 "enclosed areas"}};
  for (const auto& [name, map, quality] : results) {
    rows.push_back(
        {name, fixed_text(map.resolution, 3),
         fmt::format("{:.1f} x {:.1f}", metres(map.width, map), metres(map.height, map)),
         std::to_string(quality.known_cells()), fixed_text(quality.occupied_of_known(), 4),
         fixed_text(quality.occupied_of_free(), 4), std::to_string(quality.corners.size()),
         std::to_string(quality.enclosed_areas.size())});
  }
  return format_table(rows);
}

nlohmann::json json_of(const std::vector<MeasuredMap>& results) {
  nlohmann::json maps = nlohmann::json::array();
  for (const auto& [name, map, quality] : results) {
    maps.push_back(nlohmann::json::object({{"map", name},
                                           {"resolution_m", map.resolution},
                                           {"width_m", metres(map.width, map)},
                                           {"height_m", metres(map.height, map)},
                                           {"known_cells", quality.known_cells()},
                                           {"occupied_cells", quality.occupied_cells},
                                           {"free_cells", quality.free_cells},
                                           {"occupied_of_known", quality.occupied_of_known()},
                                           {"occupied_of_free", quality.occupied_of_free()},
                                           {"corners", quality.corners.size()},
                                           {"enclosed_areas", quality.enclosed_areas.size()}}));
  }
  return nlohmann::json::object({{"metric", "map"}, {"maps", maps}});
}

/// Rows of cells from the top: '#' occupied, '.' free, '?' unknown; in an enclosed area 'a' to 'f'.
std::vector<std::string> rows_of(const MeasuredMap& measured) {
  const MapImage& map = measured.map;
  std::vector<std::string> rows(static_cast<std::size_t>(map.height));
  const auto row_of = [&](int y) -> std::string& {
    return rows[static_cast<std::size_t>(map.height - 1 - y)];
  };
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const CellState state = map.state({x, y});
      row_of(y) += state == CellState::kOccupied ? '#' : state == CellState::kFree ? '.' : '?';
    }
  }
  int number = 0;
  for (const EnclosedArea& area : measured.quality.enclosed_areas) {
    for (const Cell& cell : area) {
      char& shown = row_of(cell.y)[static_cast<std::size_t>(cell.x)];
      shown = shown == '#' ? shown : static_cast<char>('a' + number % 6);  // specks stay to be seen
    }
    ++number;
  }
  return rows;
}

nlohmann::json figure_of(const std::vector<MeasuredMap>& results) {
  nlohmann::json figure = {{"metric", "map"}, {"maps", nlohmann::json::array()}};
  for (const MeasuredMap& measured : results) {
    nlohmann::json map = {{"name", measured.name},
                          {"rows", rows_of(measured)},
                          {"areas", measured.quality.enclosed_areas.size()},
                          {"corners", nlohmann::json::array()}};
    for (const Eigen::Vector2d& corner : measured.quality.corners) {
      map["corners"].push_back({corner.x(), corner.y()});
    }
    figure["maps"].push_back(map);
  }
  return figure;
}

void run(const MapCommand& command) {
  require_plot_file(command.output.plot);
  const std::vector<MeasuredMap> results = measure(command);
  present(command.output, json_of(results),
          "Map quality without ground truth (Filatov et al. 2017)\n"
          "Of maps of one place, one resolution and one extent, the sharper has less of each\n\n" +
              table_of(results),
          [&] { return figure_of(results); });
}

}  // namespace

void add_map_command(CLI::App& app) {
  const auto command = std::make_shared<MapCommand>();
  CLI::App* map = app.add_subcommand(
      "map", "Map quality without ground truth: doubled and smeared walls raise the figures");
  map->add_option("maps", command->maps, "Maps to measure, as map_server reads them")
      ->type_name("MAP.yaml")
      ->required();
  add_output_options(*map, command->output);
  map->callback([command] { run(*command); });
}

}  // namespace matchbox_slam
