#include <gtest/gtest.h>

#include <cstdint>
#include <memory>

#include "common/error_text.hpp"
#include "io/temporary_folder.hpp"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/saved_map.hpp"
#include "matchbox_slam/matching/olson_matcher.hpp"
#include "matchbox_slam/simulation/make_world.hpp"
#include "matchbox_slam/simulation/simulated_run.hpp"

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
  const EngineOptions options;
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
  image.origin.theta = 0.5;
  EXPECT_TRUE(contains(text(), "is turned by 0.5 rad")) << text();
  EXPECT_EQ(
      error_text<FileError>([&] { (void)read_map_start("map.png", options); }),
      "'map.png' is not read as a map; allowed: a .slam file of ~save_map, or a .yaml file as "
      "of map_server");
}

}  // namespace
}  // namespace matchbox_slam
