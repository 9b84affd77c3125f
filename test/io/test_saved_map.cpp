#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <string>

#include "common/error_text.hpp"
#include "io/gzip.hpp"
#include "io/temporary_folder.hpp"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/saved_map.hpp"
#include "matchbox_slam/matching/olson/olson_matcher.hpp"
#include "simulation/make_world.hpp"
#include "simulation/simulated_run.hpp"

namespace matchbox_slam {
namespace {

constexpr std::size_t kMapped = 160;  // scans, of 240

const SimulatedRun& drive() {
  static const SimulatedRun run = [] {
    SimulationOptions options;
    options.time.duration = 12.0;
    const World world = make_world("rooms", 5);
    return simulate_run(world, world.route(), options, 5);
  }();
  return run;
}

SlamEngine make_engine() {
  return {EngineOptions{}, std::make_shared<OlsonMatcher>(), 1, drive().world_from_base.front()};
}

/// The map of the first part of the drive.
MapStart mapped() {
  SlamEngine engine = make_engine();
  for (std::size_t i = 0; i < kMapped; ++i) {
    engine.process(drive().scan_input(i));
  }
  return engine.snapshot();
}

class SavedMap : public testing::Test {
 protected:
  void write(const std::string& bytes) const { replace_file(path_, bytes); }

  [[nodiscard]] std::string error() const {
    return error_text<FileError>([&] { (void)read_saved_map(path_); });
  }

  TemporaryFolder folder_;
  std::string path_ = folder_ / "map.slam";
};

TEST_F(SavedMap, ComesBackBitByBit) {
  const MapStart map = mapped();
  const std::string bytes = to_saved_map(map);
  write(bytes);
  const MapStart again = read_saved_map(path_);
  EXPECT_TRUE(to_saved_map(again) == bytes);
  EXPECT_EQ(again.map_from_base, map.map_from_base);
  EXPECT_EQ(again.covariance, map.covariance);
  ASSERT_EQ(again.key_scans.size(), map.key_scans.size());
  ASSERT_GT(map.map.field.surface_cells().size(), 500U);
  const CellBox box = map.map.occupancy.known_bounds();
  for (int y = box.min.y - 20; y < box.max.y + 20; ++y) {
    for (int x = box.min.x - 20; x < box.max.x + 20; ++x) {
      const Cell cell{x, y};
      ASSERT_EQ(again.map.occupancy.stored(cell), map.map.occupancy.stored(cell));
      ASSERT_EQ(again.map.field.likelihood(cell), map.map.field.likelihood(cell));
      ASSERT_EQ(again.map.field.distance(cell), map.map.field.distance(cell));
    }
  }
}

TEST_F(SavedMap, MappingGoesOnAsIfItHadNeverStopped) {
  const MapStart map = mapped();
  write(to_saved_map(map));
  SlamEngine from_memory = make_engine();
  from_memory.start_from(map);
  SlamEngine from_file = make_engine();
  from_file.start_from(read_saved_map(path_));
  for (std::size_t i = kMapped; i < drive().scans.size(); ++i) {
    const ScanOutcome a = from_memory.process(drive().scan_input(i));
    const ScanOutcome b = from_file.process(drive().scan_input(i));
    ASSERT_EQ(a.map_from_base, b.map_from_base) << i;
    ASSERT_EQ(a.covariance, b.covariance) << i;
  }
  EXPECT_TRUE(to_saved_map(from_memory.snapshot()) == to_saved_map(from_file.snapshot()));
  EXPECT_LT((from_file.snapshot().map_from_base.translation() -
             drive().world_from_base.back().translation())
                .norm(),
            0.01);
}

TEST_F(SavedMap, RefusesWhatIsCutOffDamagedOrNoMap) {
  const std::string bytes = to_saved_map(mapped());
  EXPECT_TRUE(contains(error(), "map.slam"));  // missing
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{10}, bytes.size() / 2, bytes.size() - 1}) {
    write(bytes.substr(0, size));
    EXPECT_TRUE(contains(error(), "is no saved map, or is cut off or damaged")) << size;
  }
  for (std::size_t i = 0; i < 50; ++i) {
    std::string damaged = bytes;
    damaged[(i * bytes.size()) / 50] = static_cast<char>(~damaged[(i * bytes.size()) / 50]);
    write(damaged);
    EXPECT_NO_THROW({
      try {
        (void)read_saved_map(path_);
      } catch (const FileError&) {  // or the byte did not matter, as in the head of gzip
      }
    }) << i;
  }
  write("P5\n");
  EXPECT_FALSE(error().empty());
}

// --- files that would take all memory, or that no map could have made ---

/// A map of two known cells and one wall, the last cells of both lists there; without compression.
std::string map_with_cells_at(const Cell& known, const Cell& wall) {
  SlamMap map(MapOptions{}, LikelihoodFieldOptions{});
  map.occupancy.restore({0, 0}, 1);
  map.occupancy.restore({1, 0}, 1);
  map.field.update({{{0.01, 0.01}, {1.0, 0.0}}}, {});
  std::string bytes = decompress(to_saved_map({map, {}, {}}), "map");
  const std::size_t first_cell = std::string("matchbox_slam map, version 1\n").size() + 4 * 8;
  for (const auto& [at, cell] :
       {std::make_pair(first_cell + 10, known), std::make_pair(first_cell + 28, wall)}) {
    const std::array<std::int32_t, 2> image = {cell.x, cell.y};
    std::memcpy(bytes.data() + at, image.data(), sizeof image);
  }
  return bytes;
}

TEST_F(SavedMap, RefusesCellsThatSpanMoreThanTheOptionAllows) {
  const Cell near{5, 5};
  write(compress(map_with_cells_at(near, near)));
  EXPECT_EQ(error(), "(no error)");
  for (const Cell& far : {Cell{1 << 24, 1 << 24}, Cell{-(1 << 24), 0}, Cell{30000, -30000}}) {
    write(compress(map_with_cells_at(far, near)));
    EXPECT_TRUE(contains(error(), "is damaged, or its map is too large: its cells span")) << far.x;
    EXPECT_TRUE(contains(error(), "set map/max_cells higher")) << error();
    write(compress(map_with_cells_at(near, far)));
    EXPECT_TRUE(contains(error(), "is damaged, or its map is too large")) << error();
  }
  EngineOptions options;
  write(compress(map_with_cells_at({30000, -30000}, near)));
  EXPECT_THROW((void)read_map_start(path_, options), FileError);
  options.map.max_cells = 1e9;
  EXPECT_NO_THROW((void)read_map_start(path_, options));
  write(compress(map_with_cells_at({(1 << 24) + 1, 0}, near)));
  EXPECT_TRUE(contains(error(), "is damaged: a cell lies at 16777217, 0")) << error();
  write(compress(map_with_cells_at({0, std::numeric_limits<int>::min()}, near)));
  EXPECT_TRUE(contains(error(), "is damaged: a cell lies at 0, -2147483648")) << error();
}

TEST_F(SavedMap, RefusesNumbersThatNoMapHolds) {
  std::string bytes = map_with_cells_at({1, 0}, {0, 0});
  const std::size_t head = std::string("matchbox_slam map, version 1\n").size();
  const auto error_with = [&](double number, std::size_t at) {
    std::string sound(bytes, at, sizeof number);
    std::memcpy(bytes.data() + at, &number, sizeof number);
    write(compress(bytes));
    bytes.replace(at, sound.size(), sound);
    return error();
  };
  EXPECT_TRUE(contains(error_with(5.0, head), "its resolution is 5.0; allowed: 0.005 to 1"));
  EXPECT_TRUE(contains(error_with(1e-30, head + 16), "its reach is 1e-30; allowed: 0.05 to 5"));
  const double reach = 5.0;
  std::memcpy(bytes.data() + head + 16, &reach, sizeof reach);
  EXPECT_TRUE(contains(error_with(0.01, head), "5.0 m with cells of 0.01 m; allowed: at most 120"));
  const std::size_t pose = bytes.size() - 12 * sizeof(double);
  EXPECT_TRUE(contains(error_with(1e300, pose), "it holds the number 1e+300 where at most"));
  EXPECT_TRUE(contains(error_with(std::nan(""), pose), "it holds the number"));
  EXPECT_TRUE(contains(error_with(-1.0, pose + 3 * sizeof(double)), "covariance of its pose"));
  EXPECT_EQ(error_with(1.0, pose), "(no error)");
}

// --- images ---

/// A loaded image has no more than half a cell to say where a wall is; the line through its pixels
/// says more.
TEST_F(SavedMap, ARobotFindsItselfInAnImage) {
  const MapStart map = mapped();
  write_map(folder_ / "image", make_map_image(map.map.occupancy));
  EngineOptions options;
  options.slam.update_map = false;
  MapStart start = read_map_start(folder_ / "image.yaml", options);
  EXPECT_TRUE(start.key_scans.empty());
  SlamEngine engine(options, std::make_shared<OlsonMatcher>(), 1);
  start.map_from_base = drive().world_from_base.front() * Pose2{0.2, 0.1, -0.1};
  start.covariance = Eigen::Vector3d(0.1, 0.1, 0.03).asDiagonal();
  engine.start_from(start);
  double squares = 0.0;
  for (std::size_t i = 0; i < kMapped; ++i) {
    const ScanOutcome outcome = engine.process(drive().scan_input(i));
    ASSERT_TRUE(outcome.match.accepted()) << i;
    squares += (outcome.map_from_base.translation() - drive().world_from_base[i].translation())
                   .squaredNorm();
  }
  EXPECT_LT(std::sqrt(squares / kMapped), 0.02);
}

TEST_F(SavedMap, SaysWhyAnImageIsNotTaken) {
  MapImage image = make_map_image(mapped().map.occupancy);
  EngineOptions options;
  const auto text = [&] {
    write_map(folder_ / "image", image);
    try {
      (void)read_map_start(folder_ / "image.yaml", options);
    } catch (const std::exception& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(text(), "");
  image.resolution = 0.1;
  EXPECT_TRUE(contains(text(), "map/resolution: 0.05 is not allowed with the map")) << text();
  EXPECT_TRUE(contains(text(), "allowed: its own, 0.1")) << text();
  image.resolution = 0.05;
  options.map.max_cells = 100.0;
  EXPECT_TRUE(contains(text(), "cells; allowed: 100.0 in all")) << text();
  options.map.max_cells = 1e6;
  EXPECT_EQ(text(), "");
  image.origin.theta = 0.5;
  EXPECT_TRUE(contains(text(), "is turned by 0.5 rad")) << text();
  EXPECT_EQ(
      error_text<FileError>([&] { (void)read_map_start("map.png", options); }),
      "'map.png' is not read as a map; allowed: a .slam file of ~save_map, or a .yaml file as "
      "of map_server");
}

}  // namespace
}  // namespace matchbox_slam
