#pragma once

#include <fmt/core.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>

#include "io/map_archive.hpp"
#include "matchbox_slam/slam/slam_engine.hpp"

namespace matchbox_slam {

/// More are no robot's, but a file that is damaged.
constexpr std::size_t kMostLasers = 1000;

/// A saved map before it is compressed.
void write_map_bytes(const EngineState& map, const ByteSink& sink);

// What a saved map is made of. Reading throws FileError for what no map could have made.

void write_grids(const SlamMap& map, MapWriter& writer);
[[nodiscard]] SlamMap read_grids(MapReader& reader);

void write_key_scans(const KeyScans& key_scans, MapWriter& writer);
[[nodiscard]] KeyScans read_key_scans(MapReader& reader);

/// map_from_base by laser, as in MapComponent.
void write_last_inserted(const std::map<int, Pose2>& last_inserted, MapWriter& writer);
[[nodiscard]] std::map<int, Pose2> read_last_inserted(MapReader& reader);

void write_localization(const LocalizationState& localization, MapWriter& writer);
/// @param key_scans  of the map.
[[nodiscard]] LocalizationState read_localization(const KeyScans& key_scans, MapReader& reader);

/// What closing loops knows: of the graph the edges, as its poses are those of the key scans.
void write_loops(const EngineState& map, MapWriter& writer);
void read_loops(MapReader& reader, EngineState& map);

void write_secondary_lasers(const SecondaryLasers& lasers, MapWriter& writer);
[[nodiscard]] SecondaryLasers read_secondary_lasers(MapReader& reader);

template <typename Archive, typename Matrix>
void transfer_covariance(Archive& archive, const std::string& name, Matrix& matrix) {
  transfer_matrix(archive, matrix);
  if constexpr (Archive::kReads) {
    if (!is_covariance(matrix)) {
      archive.fail(fmt::format("is damaged: the covariance of {} is none", name));
    }
  }
}

/// Which one of so many things a whole is made of, from 0.
template <typename Archive, typename Number>
void transfer_number(Archive& archive, const std::string& thing, Number& number,
                     const std::string& whole, std::size_t things) {
  std::uint64_t written = number;
  archive.integer(written);
  if constexpr (Archive::kReads) {
    if (written >= things) {
      archive.fail(
          fmt::format("is damaged: it names {} {} of a {} of {}", thing, written, whole, things));
    }
    number = static_cast<std::size_t>(written);
  }
}

}  // namespace matchbox_slam
