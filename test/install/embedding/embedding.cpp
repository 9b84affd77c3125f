// Maps one scan of a round room of 2 m radius, writes the map, and tells how much is known [m^2].

#include <cmath>
#include <iostream>
#include <memory>

#include "matchbox_slam/io/map_file.hpp"
#include "matchbox_slam/matching/olson/olson_matcher.hpp"
#include "matchbox_slam/slam/slam_engine.hpp"

int main() {
  using namespace matchbox_slam;
  auto matcher = std::make_shared<OlsonMatcher>();
  matcher->configure({});
  SlamEngine engine(EngineOptions{}, matcher, 1);
  ScanInput input;
  input.scan.angle_min = -3.14;
  input.scan.angle_increment = 0.01;
  input.scan.range_max = 10.0;
  input.scan.ranges.assign(628, 2.0F);
  engine.process(input);
  const OccupancyGrid& map = engine.map().occupancy;
  write_map("map", make_map_image(map));
  const CellBox box = map.known_bounds();
  int known = 0;
  for (int y = box.min.y; y < box.max.y; ++y) {
    for (int x = box.min.x; x < box.max.x; ++x) {
      known += map.is_known({x, y}) ? 1 : 0;
    }
  }
  std::cout << known * map.geometry().resolution() * map.geometry().resolution() << '\n';
}
