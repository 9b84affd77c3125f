#include "matching/rendered_map.hpp"

namespace matchbox_slam {

SlamMap rendered(const PlacedScans& keys, const MapOptions& map_options,
                 const LikelihoodFieldOptions& field_options, MapUse use) {
  SlamMap map(map_options, field_options);
  for (const PlacedScan& key : keys) {
    insert_unrendered(*key.scan->points(), key.map_from_base, map_options, use, map);
  }
  map.field.render();
  return map;
}

}  // namespace matchbox_slam
