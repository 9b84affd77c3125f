#include <fmt/core.h>

#include <limits>
#include <utility>
#include <vector>

#include "io/saved_parts.hpp"

namespace matchbox_slam {
namespace {

constexpr double kMostReachCells = 120.0;  // as LikelihoodField allows
constexpr std::size_t kAnyCount = std::numeric_limits<std::size_t>::max();

/// Known cells that follow each other in a row.
struct Run {
  Cell first;
  std::uint32_t count = 0;
};

/// Row by row.
std::vector<Run> known_runs(const OccupancyGrid& grid) {
  const CellBox bounds = grid.known_bounds();
  std::vector<Run> runs;
  for (int y = bounds.min.y; y < bounds.max.y; ++y) {
    bool is_in_run = false;
    for (int x = bounds.min.x; x < bounds.max.x; ++x) {
      const bool is_known = grid.is_known({x, y});
      if (is_known && !is_in_run) {
        runs.push_back({{x, y}, 0});
      }
      if (is_known) {
        ++runs.back().count;
      }
      is_in_run = is_known;
    }
  }
  return runs;
}

/// Of a map of release 1.0, which told where each cell is.
void read_cells_of_1_0(MapReader& reader, OccupancyGrid& grid) {
  Cell cell;
  for (std::size_t left = reader.count(10, kAnyCount, "cells"); left > 0; --left) {
    reader.cell(cell);
    OccupancyGrid::Stored stored{};
    reader.integer(stored);
    grid.restore(cell, stored);
  }
}

void read_cells(MapReader& reader, OccupancyGrid& grid) {
  Run run;
  for (std::size_t left = reader.count(14, kAnyCount, "rows of cells"); left > 0; --left) {
    reader.run(run.first, run.count);
    for (Cell cell = run.first; run.count > 0; ++cell.x, --run.count) {
      OccupancyGrid::Stored stored{};
      reader.integer(stored);
      grid.restore(cell, stored);
    }
  }
}

template <typename Archive, typename Surface>
void transfer_wall(Archive& archive, Surface& surface) {
  archive.integer(surface.hits);
  for (auto* value :
       {&surface.offset_x, &surface.offset_y, &surface.mean_double_angle_x,
        &surface.mean_double_angle_y, &surface.double_angle_x, &surface.double_angle_y}) {
    archive.integer(*value);
  }
  if (!archive.is_of_1_0()) {  // which did not keep from which side: both look alike
    archive.integer(surface.facing_x);
    archive.integer(surface.facing_y);
  }
}

}  // namespace

void write_grids(const SlamMap& map, MapWriter& writer) {
  writer.number(map.field.geometry().resolution());
  writer.number(map.field.options().sigma);
  writer.number(map.field.options().reach);
  const std::vector<Run> runs = known_runs(map.occupancy);
  writer.integer(std::uint64_t{runs.size()});
  for (const Run& run : runs) {
    writer.run(run.first, run.count);
    const int end = run.first.x + static_cast<int>(run.count);
    for (Cell cell = run.first; cell.x < end; ++cell.x) {
      writer.integer(map.occupancy.stored(cell));
    }
  }
  const std::vector<Cell> walls = map.field.surface_cells();
  writer.integer(std::uint64_t{walls.size()});
  for (const Cell& cell : walls) {
    writer.cell(cell);
    transfer_wall(writer, map.field.stored_surface(cell));
  }
}

SlamMap read_grids(MapReader& reader) {
  MapOptions map_options;
  LikelihoodFieldOptions field_options;
  reader.begin_map();
  for (double* value : {&map_options.resolution, &field_options.sigma, &field_options.reach}) {
    reader.number(*value);
  }
  check_limits(map_options, reader);
  check_limits(field_options, reader);
  if (field_options.reach / map_options.resolution > kMostReachCells) {
    reader.fail(
        fmt::format("is damaged: its reach is {} m with cells of {} m; allowed: at most 120 cells",
                    to_string(field_options.reach), to_string(map_options.resolution)));
  }
  SlamMap map(map_options, field_options);
  if (reader.is_of_1_0()) {
    read_cells_of_1_0(reader, map.occupancy);
  } else {
    read_cells(reader, map.occupancy);
  }
  std::vector<std::pair<Cell, LikelihoodField::StoredSurface>> walls;
  reader.size(walls, reader.is_of_1_0() ? 22 : 24, kAnyCount, "walls");
  for (auto& [wall, surface] : walls) {
    reader.cell(wall);
    transfer_wall(reader, surface);
  }
  map.field.restore(walls);
  return map;
}

}  // namespace matchbox_slam
