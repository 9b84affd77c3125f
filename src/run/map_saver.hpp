#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "geometry/trajectory.hpp"
#include "io/map_changes.hpp"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/map_file.hpp"
#include "matchbox_slam/map/occupancy_grid.hpp"
#include "run/slam_run.hpp"

namespace matchbox_slam {

/// How far the mapping has come; any change is a reason to show or to save it.
struct MapRevision {
  std::size_t resets = 0;
  std::size_t clock_steps = 0;  ///< since
  std::size_t inserted = 0;     ///< scans in the map
  std::size_t scans = 0;        ///< that were processed

  [[nodiscard]] bool operator==(const MapRevision& other) const {
    return is_same_beginning(other) && inserted == other.inserted && scans == other.scans;
  }
  /// Whether the one went on to be the other, without another map or a step of the clock.
  [[nodiscard]] bool is_same_beginning(const MapRevision& other) const {
    return resets == other.resets && clock_steps == other.clock_steps;
  }
};

[[nodiscard]] MapRevision revision_of(const SlamRun& run);

/// All that is saved of a map, as of one moment.
struct MapToSave {
  SlamSetup setup;
  MapRevision revision;
  EngineState map;
  Trajectory trajectory;  ///< to be drawn, as the next
  Trajectory odometry;
};

/// Throws std::runtime_error where no scan was mapped yet, so that no map is lost.
[[nodiscard]] MapToSave map_to_save(const SlamRun& run);

/// Adds the image as of map_server and the picture for people: `path` + .yaml and so on.
/// @param picture  a PNG's bytes.
void add_images(const std::string& path, const OccupancyGrid& shown, const std::string& picture,
                MapFormat format, FileReplacement& files);

/// Saves the map of a run again and again where `map_file` says: as a whole, or what has changed
/// since beside it (io/map_changes.hpp). A map that this one did not go on from stays beside it.
class MapSaver {
 public:
  /// The map has begun as what this file holds.
  void begin_from(const std::string& file, const MapRevision& now);

  /// As a whole: images and .slam. Returns where they are, for people. Throws FileError.
  std::string save(const MapToSave& now);

  /// What has changed, until as much was written as the whole takes, and then that: so it costs
  /// twice the least there is at most. Throws FileError.
  void save_changes(const MapToSave& now);

  /// Scans that no saved file has.
  [[nodiscard]] std::size_t unsaved_scans(const MapRevision& now) const {
    return saved_ && now.is_same_beginning(*saved_) ? now.scans - saved_->scans : now.scans;
  }

  /// Whether nothing would be lost now; so it is where there is nothing.
  [[nodiscard]] bool is_saved(const MapRevision& now) const {
    return now.scans == 0 || now == saved_;
  }

 private:
  std::string save_whole(const MapToSave& now);
  [[nodiscard]] bool is_own(const std::string& file, const MapRevision& now) const;
  void keep_other_map(const std::string& file, const MapRevision& now) const;
  [[nodiscard]] bool can_add_changes(const MapToSave& now) const;

  /// The map that was written as a whole last.
  struct WholeMap {
    MapPieces pieces;
    std::uintmax_t size = 0;           ///< [bytes] of the file
    std::uintmax_t written_since = 0;  ///< [bytes] of changes to it
    std::filesystem::file_time_type written;
  };
  std::optional<MapRevision> saved_;  ///< last
  std::string file_;                  ///< what it holds is this map as it was, or what it began as
  MapRevision begun_;                 ///< then
  std::optional<WholeMap> whole_;
};

}  // namespace matchbox_slam
