#include "run/mergeable_map.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>

#include "io/map_kind.hpp"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/saved_map.hpp"

namespace matchbox_slam {
namespace {

namespace fs = std::filesystem;

/// What people give in place of a saved map.
void require_saved_map(const std::string& path) {
  const std::string kind = fs::path(path).extension().string();
  if (fs::is_directory(path)) {
    throw ConfigurationError(fmt::format("{} is a folder; give the map in it, as {}", path,
                                         (fs::path(path) / "map.slam").string()));
  }
  if (kind == ".bag" || is_bag(path)) {
    throw ConfigurationError(fmt::format(
        "{} is a recording; map_bag {} --out DIR makes DIR/map.slam of it, which can be merged",
        path, path));
  }
  if (kind == ".yaml" || kind == ".pgm" || kind == ".png") {
    throw ConfigurationError(path +
                             " is an image of a map, which has no scans to merge it by; give the "
                             ".slam that was saved beside it, or make one with map_bag");
  }
}

}  // namespace

EngineState read_mergeable_map(const std::string& path, const EngineOptions& options) {
  require_saved_map(path);
  EngineState map = read_saved_map(path, options.map.max_cells);
  if (!map.is_of_key_scans) {
    throw FileError(path +
                    ": holds walls of which there are no key scans, as of an image, or "
                    "of a map that was begun before 1.0; such a map cannot be merged: map the "
                    "drive anew with map_bag");
  }
  if (map.key_scans.empty()) {
    throw FileError(path + ": holds no key scans; there is nothing to merge");
  }
  return map;
}

int last_laser(const EngineState& map) {
  int last = -1;
  const auto take = [&last](const PlacedScan& key) { last = std::max(last, key.scan->laser()); };
  const auto take_all = [&take](const KeyScans& keys) {
    std::for_each(keys.all().begin(), keys.all().end(), take);
  };
  take_all(map.key_scans);
  for (const MapComponent& component : map.localization.components) {
    take_all(component.key_scans);
  }
  for (const WaitingScan& waiting : map.localization.pending) {
    take(waiting.scan);
  }
  return last;
}

}  // namespace matchbox_slam
