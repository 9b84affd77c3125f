#include <fmt/core.h>

#include <limits>
#include <utility>
#include <vector>

#include "io/saved_parts.hpp"

namespace matchbox_slam {
namespace {

constexpr double kMostReachCells = 120.0;  // as LikelihoodField allows

template <typename Visit>
void visit_known(const OccupancyGrid& grid, const Visit& visit) {
  const CellBox bounds = grid.known_bounds();
  for (int y = bounds.min.y; y < bounds.max.y; ++y) {
    for (int x = bounds.min.x; x < bounds.max.x; ++x) {
      if (grid.is_known({x, y})) {
        visit(Cell{x, y});
      }
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
  std::uint64_t known = 0;  // counted first, as a list of them would take more memory than the map
  visit_known(map.occupancy, [&known](const Cell& /*cell*/) { ++known; });
  writer.integer(known);
  visit_known(map.occupancy, [&](const Cell& cell) {
    writer.cell(cell);
    writer.integer(map.occupancy.stored(cell));
  });
  const std::vector<Cell> walls = map.field.surface_cells();
  writer.integer(std::uint64_t{walls.size()});
  for (const Cell& cell : walls) {
    writer.cell(cell);
    transfer_wall(writer, map.field.stored_surface(cell));
  }
}

SlamMap read_grids(MapReader& reader) {
  constexpr std::size_t kAnyCount = std::numeric_limits<std::size_t>::max();
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
  Cell cell;
  for (std::size_t left = reader.count(10, kAnyCount, "cells"); left > 0; --left) {
    reader.cell(cell);
    OccupancyGrid::Stored stored{};
    reader.integer(stored);
    map.occupancy.restore(cell, stored);
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
