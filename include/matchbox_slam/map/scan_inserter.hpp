#pragma once

#include <memory>
#include <vector>

#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/map/likelihood_field.hpp"
#include "matchbox_slam/map/occupancy_grid.hpp"
#include "matchbox_slam/map/reflection_grid.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"

namespace matchbox_slam {

struct MapOptions {
  double resolution = 0.05;
  double quality = 0.35;
  double no_return_quality = 0.1;
  double hole_width = 0.1;
  double occupied_threshold = 0.5;
  double max_cells = 4e8;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor&& option) {
    option(self.resolution, "resolution", between(0.005, 1.0), "m", "Edge of a cell.");
    option(self.quality, "quality", between(0.001, 1.0), "",
           "Weight of a new observation when it is blended into a cell.");
    option(
        self.no_return_quality, "no_return_quality", between(0.0, 1.0), "",
        "Weight of a beam without return when it is blended into a cell; less than quality, since "
        "dark and shiny surfaces return nothing either.");
    option(self.hole_width, "hole_width", between(0.0, 5.0), "m",
           "Length of the obstacle that a hit draws along its beam, the hit in its middle.");
    option(
        self.occupied_threshold, "occupied_threshold", between(0.05, 0.95), "",
        "A hit cell becomes a surface to match against from this occupancy on, and ceases below.");
    option(self.max_cells, "max_cells", between(1e5, 1e10), "",
           "A scan that would make the map's rectangle larger than so many cells is left out, so "
           "that one wild pose does not take all memory; 1 km^2 has 4e8 of 5 cm.");
  }
};

/// What insertions work in, kept from one to the next; what it holds never matters. A copy has
/// none.
class InsertionMemory {
 public:
  InsertionMemory();
  InsertionMemory(const InsertionMemory& other);
  InsertionMemory(InsertionMemory&& other) noexcept;
  InsertionMemory& operator=(const InsertionMemory& other);
  InsertionMemory& operator=(InsertionMemory&& other) noexcept;
  ~InsertionMemory();

  struct Parts;
  [[nodiscard]] Parts& parts();

 private:
  std::unique_ptr<Parts> parts_;
};

/// Everything that a scan is matched against and inserted into. Copies are cheap snapshots.
struct SlamMap {
  SlamMap(const MapOptions& map_options, const LikelihoodFieldOptions& field_options)
      : occupancy(map_options.resolution),
        field(map_options.resolution, field_options),
        reflection(map_options.resolution) {}

  OccupancyGrid occupancy;
  LikelihoodField field;
  ReflectionGrid reflection;
  InsertionMemory insertion;
};

/// Whether the map with the scan in it is no larger than the options allow, and lies within the
/// cells that are counted, 2^28 to each side of the origin.
[[nodiscard]] bool has_room(const PointScan& scan, const Pose2& map_from_base,
                            const MapOptions& options, const SlamMap& map);

/// What a map is drawn for.
enum class MapUse {
  kShown,    ///< people look at it, too
  kMatched,  ///< nobody does: of beams side by side, which say the same, some tell what is free
};

/// Draws a scan into the map: free along each beam, an obstacle profile around its hit (tinySLAM's
/// "hole"), and the hits as surfaces into the likelihood field.
/// Each cell is blended once a scan, with the most occupied value that any beam gave it, so that
/// beams grazing along a wall do not erase it and the order of the beams does not matter.
/// Nothing is drawn of a scan with which the map would have more than 4e8 cells and `max_cells`, as
/// damaged files alone have them, or that lies beyond the cells that are counted.
/// @param map_from_base  pose at the scan's stamp.
void insert_scan(const PointScan& scan, const Pose2& map_from_base, const MapOptions& options,
                 SlamMap& map);

/// The same into a map whose field is to be rendered before it is read: many scans then cost a
/// third of what they cost one by one.
/// @param use  of the map.
void insert_unrendered(const PointScan& scan, const Pose2& map_from_base, const MapOptions& options,
                       MapUse use, SlamMap& map);

}  // namespace matchbox_slam
