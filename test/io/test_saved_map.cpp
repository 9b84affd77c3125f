#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "common/error_text.hpp"
#include "io/gzip.hpp"
#include "io/temporary_folder.hpp"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/saved_map.hpp"
#include "matchbox_slam/matching/hough/hough_matcher.hpp"
#include "matchbox_slam/matching/monte_carlo/monte_carlo_matcher.hpp"
#include "matchbox_slam/matching/odometry_only_matcher.hpp"
#include "matchbox_slam/matching/olson/olson_matcher.hpp"
#include "simulation/fault.hpp"
#include "simulation/make_world.hpp"
#include "simulation/simulated_run.hpp"
#include "simulation/simulation_support.hpp"

namespace matchbox_slam {
namespace {

constexpr std::size_t kMapped = 160;  // scans, of 240

const SimulatedRun& drive() {
  static const SimulatedRun kRun = [] {
    SimulationOptions options;
    options.time.duration = 12.0;
    const World world = make_world("rooms", 5);
    return simulate_run(world, world.route(), options, 5);
  }();
  return kRun;
}

SlamEngine make_engine() {
  return {EngineOptions{}, std::make_shared<OlsonMatcher>(), 1, drive().world_from_base.front()};
}

/// What the engine knows after the first part of the drive.
EngineState mapped() {
  SlamEngine engine = make_engine();
  for (std::size_t i = 0; i < kMapped; ++i) {
    engine.process(scan_input(drive(), i));
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
  const EngineState map = mapped();
  const std::string bytes = to_saved_map(map);
  write(bytes);
  const EngineState again = read_saved_map(path_);
  EXPECT_TRUE(to_saved_map(again) == bytes);
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

/// The drive in several ways: with or without odometry, by one laser or two that take turns.
struct Drive {
  bool odometry;
  int lasers;

  [[nodiscard]] ScanInput scan(std::size_t i) const {
    ScanInput input = scan_input(drive(), i);
    input.laser = static_cast<int>(i) % lasers;
    if (!odometry) {
      input.odometry.reset();
    }
    return input;
  }
};

TEST_F(SavedMap, MappingGoesOnToTheBitAsIfItHadNeverStopped) {
  const std::vector<std::shared_ptr<const ScanMatcher>> matchers = {
      std::make_shared<OlsonMatcher>(), std::make_shared<HoughMatcher>(),
      std::make_shared<MonteCarloMatcher>()};
  for (std::size_t m = 0; m < matchers.size(); ++m) {
    for (const Drive& way : {Drive{true, 1}, Drive{false, 1}, Drive{true, 2}, Drive{false, 2}}) {
      SCOPED_TRACE("matcher " + std::to_string(m) + (way.odometry ? ", odometry, " : ", ") +
                   std::to_string(way.lasers) + " lasers");
      const auto make_engine = [&] {
        return SlamEngine({}, matchers[m], 1, drive().world_from_base.front());
      };
      SlamEngine uninterrupted = make_engine();
      for (std::size_t i = 0; i < kMapped; ++i) {
        uninterrupted.process(way.scan(i));
      }
      write(to_saved_map(uninterrupted.snapshot()));
      SlamEngine from_file = make_engine();
      from_file.start_from(read_saved_map(path_));
      for (std::size_t i = kMapped; i < drive().scans.size(); ++i) {
        const ScanOutcome a = uninterrupted.process(way.scan(i));
        const ScanOutcome b = from_file.process(way.scan(i));
        ASSERT_EQ(a.map_from_base, b.map_from_base) << i;
        ASSERT_EQ(a.covariance, b.covariance) << i;
        ASSERT_EQ(a.inserted, b.inserted) << i;
      }
      EXPECT_TRUE(to_saved_map(uninterrupted.snapshot()) == to_saved_map(from_file.snapshot()));
    }
  }
}

TEST_F(SavedMap, ALostRobotGoesOnToTheBitAsIfItHadNeverStopped) {
  SimulationOptions options;
  options.laser.scan_rate = 10.0;
  options.laser.beams = 260;
  options.time.duration = 90.0;
  options.faults = {parse_fault("kidnap:60:2:2")};
  const World world = make_world("rooms", 3);
  const SimulatedRun run = simulate_run(world, world.route(), options, 3);
  const auto matcher = std::make_shared<OlsonMatcher>();
  SlamEngine uninterrupted({}, matcher, 1, run.world_from_base.front());
  std::size_t lost = 0;
  std::size_t i = 0;
  for (; i < run.scans.size() && lost < 60; ++i) {
    lost += uninterrupted.process(scan_input(run, i)).state == TrackingState::kLost ? 1 : 0;
  }
  ASSERT_EQ(lost, 60U);
  const EngineState saved = uninterrupted.snapshot();
  ASSERT_EQ(saved.localization.components.size(), 1U);
  ASSERT_GT(saved.localization.components.front().key_scans.size(), 1U);
  write(to_saved_map(saved));
  SlamEngine again({}, matcher, 1, run.world_from_base.front());
  again.start_from(read_saved_map(path_));
  for (; i < run.scans.size(); ++i) {
    const ScanOutcome expected = uninterrupted.process(scan_input(run, i));
    const ScanOutcome outcome = again.process(scan_input(run, i));
    ASSERT_EQ(outcome.map_from_base, expected.map_from_base) << i;
    ASSERT_EQ(outcome.state, expected.state) << i;
  }
  EXPECT_TRUE(to_saved_map(again.snapshot()) == to_saved_map(uninterrupted.snapshot()));
}

/// Saved before the loop, with a map that the loop has moved, and each time between.
TEST_F(SavedMap, LoopsAreClosedToTheBitAsIfItHadNeverStopped) {
  SimulationOptions options;
  options.laser.scan_rate = 2.5;
  options.laser.beams = 260;
  const World world = make_world("loop", 3);
  const SimulatedRun run = simulate_run(world, world.route(), options, 3);
  const auto matcher = std::make_shared<OdometryOnlyMatcher>();
  SlamEngine uninterrupted({}, matcher, 1, run.world_from_base.front());
  SlamEngine again({}, matcher, 1, run.world_from_base.front());
  for (std::size_t i = 0; i < run.scans.size(); ++i) {
    const ScanOutcome expected = uninterrupted.process(scan_input(run, i));
    const ScanOutcome outcome = again.process(scan_input(run, i));
    ASSERT_EQ(outcome.map_from_base, expected.map_from_base) << i;
    ASSERT_EQ(outcome.covariance, expected.covariance) << i;
    ASSERT_EQ(outcome.corrected.has_value(), expected.corrected.has_value()) << i;
    if (outcome.corrected || i % 50 == 0) {
      write(to_saved_map(again.snapshot()));
      again = SlamEngine({}, matcher, 1, run.world_from_base.front());
      again.start_from(read_saved_map(path_));
    }
  }
  ASSERT_FALSE(uninterrupted.loop_state().loops.empty());
  EXPECT_GT(uninterrupted.loop_state().loops.front().moved, 0.1);
  EXPECT_TRUE(to_saved_map(again.snapshot()) == to_saved_map(uninterrupted.snapshot()));
}

TEST_F(SavedMap, KeepsKeyScansThatWereMadeOfPoints) {
  EngineState map = mapped();
  PointScan scan = *map.key_scans.all().front().scan->points();
  scan.points.front().moved = 0.25;
  scan.free_rays = {{{1.0, 2.0}, {3.0, 4.0}}};
  map.key_scans.add(scan, 3, {0.1, 0.2, 0.3});
  write(to_saved_map(map));
  const EngineState again = read_saved_map(path_);
  const PlacedScan& key = again.key_scans.all().back();
  EXPECT_EQ(key.map_from_base, (Pose2{0.1, 0.2, 0.3}));
  EXPECT_EQ(key.scan->laser(), 3);
  EXPECT_EQ(key.scan->points()->points.front().moved, 0.25);
  ASSERT_EQ(key.scan->points()->free_rays.size(), 1U);
  EXPECT_EQ(key.scan->points()->free_rays.front().end, Eigen::Vector2d(3.0, 4.0));
}

/// Written by release 1.0.0 of a lost robot, with something in all that this release kept.
std::string map_of_1_0() { return std::string(MATCHBOX_SOURCE_DIR) + "/test/io/version_7.slam"; }

TEST_F(SavedMap, ReadsWhatRelease1Wrote) {
  const EngineState start = read_saved_map(map_of_1_0());
  EXPECT_EQ(start.scan_count, 3U);
  ASSERT_EQ(start.key_scans.size(), 3U);
  for (const PlacedScan& key : start.key_scans.all()) {
    const std::optional<MeasuredScan> measured = key.scan->measured();
    ASSERT_TRUE(measured);
    EXPECT_EQ(measured->scan.ranges.size(), 12U);
    EXPECT_EQ(measured->base_from_laser.translation().x(), 0.275);
    EXPECT_EQ(measured->options.max_drop, 0.15);
  }
  EXPECT_EQ(start.motion.stamp, 1.2);
  EXPECT_EQ(start.motion.fixed_from_base, start.key_scans.all().back().map_from_base);
  EXPECT_EQ(start.motion.noise_scale.translation, 0.5);
  EXPECT_EQ(start.motion.noise_scale.rotation, 0.25);
  EXPECT_EQ(start.motion.calibration.missing, Eigen::Vector3d(0.0, 0.0, 0.0));
  EXPECT_EQ(start.last_inserted.at(0), start.motion.fixed_from_base);
  EXPECT_TRUE(start.is_moved);
  EXPECT_TRUE(start.is_continued);
  EXPECT_TRUE(start.is_of_key_scans);
  ASSERT_EQ(start.secondary_lasers.all().count(1), 1U);
  EXPECT_EQ(start.secondary_lasers.primary().others, 4);
  const SecondaryLaser& laser = start.secondary_lasers.all().at(1);
  ASSERT_EQ(laser.mount.samples().size(), 1U);
  EXPECT_EQ(laser.mount.samples().front().velocity, Eigen::Vector3d(0.5, 0.0, 0.1));
  EXPECT_EQ(laser.waiting.value().measured.options.max_drop, 0.3);
}

TEST_F(SavedMap, ReadsWallsOfRelease1WithBothSidesAlike) {
  const EngineState start = read_saved_map(map_of_1_0());
  const std::vector<Cell> walls = start.map.field.surface_cells();
  ASSERT_FALSE(walls.empty());
  EXPECT_FALSE(start.local_map) << "which key scans it shows was not told";
  for (const Cell& wall : walls) {
    Surface surface;
    ASSERT_TRUE(start.map.field.nearest_surface(wall, surface));
    EXPECT_TRUE(surface.facing.isZero());
  }
}

TEST_F(SavedMap, ReadsLoopsOfRelease1) {
  const LoopState loops = read_saved_map(map_of_1_0()).loops;
  EXPECT_EQ(loops.nodes, 3U);
  ASSERT_EQ(loops.edges.size(), 3U);
  EXPECT_EQ(loops.edges[2].kind, EdgeKind::kLoop);
  EXPECT_EQ(loops.edges[2].verdict, LoopVerdict::kOutlier);
  for (const PoseEdge& edge : loops.edges) {
    EXPECT_TRUE(edge.drift.isZero()) << "it was not told apart";
  }
  ASSERT_EQ(loops.loops.size(), 1U);
  EXPECT_EQ(loops.loops[0].found.rival_share, 0.5);
  EXPECT_EQ(loops.loops[0].found.log_odds, 0.0) << "a contradiction of 0.05 is none";
  EXPECT_EQ(loops.loops[0].chi_square, 1.5);
  EXPECT_EQ(loops.way, 0.75);
  EXPECT_EQ(loops.tries, 7U);
  EXPECT_TRUE(loops.are_others.empty());
  EXPECT_EQ(loops.pending.value().newest, 2U);
  EXPECT_EQ(loops.pending.value().edges, 2U);
  EXPECT_TRUE(loops.pending.value().is_abandoned);
}

/// What it says of a doubt is left out, and so is what waited for the end of one.
TEST_F(SavedMap, ReadsWhereALostRobotOfRelease1IsAndSearchesAnew) {
  const LocalizationState there = read_saved_map(map_of_1_0()).localization;
  EXPECT_EQ(there.active, 1U);
  ASSERT_EQ(there.components.size(), 1U);
  EXPECT_EQ(there.components[0].begin, 1.15);
  EXPECT_EQ(there.components[0].parent_from_component, (Pose2{4.0, 5.0, 0.75}));
  EXPECT_EQ(there.components[0].last_inserted.at(0), (Pose2{0.1, 0.2, 0.3}));
  ASSERT_EQ(there.components[0].key_scans.size(), 1U);
  const PlacedScan& key = there.components[0].key_scans.all().front();
  EXPECT_FALSE(key.scan->measured()) << "of points, as maps of before 1.0 have them";
  EXPECT_EQ(key.scan->points()->points.front().moved, 0.25);
  ASSERT_EQ(there.pending.size(), 1U);
  EXPECT_EQ(there.pending[0].component, 1U);
  EXPECT_EQ(there.pending[0].scan.map_from_base, (Pose2{1.0, 0.5, 0.25}));
  EXPECT_FALSE(there.hypotheses.fork);
  EXPECT_TRUE(there.search.hypotheses.empty());
  EXPECT_EQ(there.search.stamp, 0.0);
}

TEST_F(SavedMap, GoesOnFromWhatRelease1WroteAndSavesItAsOfToday) {
  const EngineState start = read_saved_map(map_of_1_0());
  write(to_saved_map(start));
  const EngineState again = read_saved_map(path_);
  EXPECT_TRUE(to_saved_map(again) == to_saved_map(start));
  EngineOptions options;
  options.map.resolution = start.map.field.geometry().resolution();
  SlamEngine engine(options, std::make_shared<OlsonMatcher>(), 1);
  engine.start_from(start);
  ScanInput next;
  next.scan = start.key_scans.all().back().scan->measured()->scan;
  next.scan.stamp = 1.3;
  const ScanOutcome outcome = engine.process(next);
  EXPECT_TRUE(outcome.map_from_base.is_finite());
  EXPECT_EQ(engine.snapshot().scan_count, 4U);
}

TEST_F(SavedMap, RefusesWhatRelease1WroteWithoutItsEndOrBeyondIt) {
  const std::string bytes = decompress(read_file(map_of_1_0()), map_of_1_0());
  for (std::size_t size = 40; size < bytes.size(); size += 61) {
    write(compress(bytes.substr(0, size)));
    const std::string text = error();
    EXPECT_TRUE(contains(text, "is cut off") || contains(text, "announces more than it holds"))
        << size << ": " << text;
  }
  write(compress(bytes + "x"));
  EXPECT_TRUE(contains(error(), "is damaged: it goes on after its end")) << error();
}

TEST_F(SavedMap, KeepsHowALaserWasTilted) {
  EngineState start = mapped();
  MeasuredScan measured = *start.key_scans.all().back().scan->measured();
  measured.laser_motion.translation().z() = 0.01;
  measured.laser_motion.rotate(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitY()));
  measured.options.max_drop = 0.3;
  start.key_scans.add(measured, 0, {});
  write(to_saved_map(start));
  const MeasuredScan again = *read_saved_map(path_).key_scans.all().back().scan->measured();
  EXPECT_EQ(again.laser_motion.matrix(), measured.laser_motion.matrix());
  EXPECT_EQ(again.options.max_drop, 0.3);
}

TEST_F(SavedMap, KeepsWhichKeyScansAreOfAnImage) {
  EngineState start = mapped();
  MeasuredScan view = *start.key_scans.all().back().scan->measured();
  view.is_of_image = true;
  view.scan.stamp = -3.0;
  start.key_scans.add(view, 0, {});
  write(to_saved_map(start));
  const EngineState again = read_saved_map(path_);
  for (const PlacedScan& key : again.key_scans.all()) {
    EXPECT_EQ(key.scan->is_of_image(), &key == &again.key_scans.all().back());
  }
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

/// Bytes of what follows the motion and the lasers' number, and of what follows the key scans, when
/// there are no lasers and nothing is in doubt: see write_localization, transfer_motion.
constexpr std::size_t kSearchBytes = (1 + 1 + 1 + 1) * 8 + 2 * 4;
constexpr std::size_t kLocalizationBytes = (1 + 1 + 1 + 1 + 72 + 1) * 8 + 1 + kSearchBytes;
constexpr std::size_t kLoopBytes = (1 + 1 + 1 + 1 + 1 + 1) * 8 + 5;
constexpr std::size_t kLaserBytes = 4 + 4 + 8 + 8;
constexpr std::size_t kCalibrationBytes = (3 + 9 + 2 + 1 + 3 + 3 + 3) * 8 + 1;
/// After what the motion learned of odometry.
constexpr std::size_t kAfterMotionBytes = 8 + 8 + kLocalizationBytes + kLoopBytes + kLaserBytes;
constexpr std::size_t kStateBytes =
    (3 + 9 + 9 + 1 + 3 + 4 + 3 + 1 + 2) * 8 + 4 + 4 + kCalibrationBytes + kAfterMotionBytes;

/// A map of two known cells and one wall, the last cells of both lists there; without compression.
std::string map_with_cells_at(const Cell& known, const Cell& wall) {
  SlamMap map(MapOptions{}, LikelihoodFieldOptions{});
  map.occupancy.restore({0, 0}, 1);
  map.occupancy.restore({2, 0}, 1);
  map.field.update({{{0.01, 0.01}, {1.0, 0.0}}}, {});
  std::string bytes = decompress(to_saved_map({map, {}, {}, {}, 0}), "map");
  // Behind four numbers of 8 bytes.
  const std::size_t first_cell = std::string("matchbox_slam map, version 17\n").size() + 32;
  for (const auto& [at, cell] :
       {std::make_pair(first_cell + 14, known), std::make_pair(first_cell + 36, wall)}) {
    const std::array<std::int32_t, 2> image = {cell.x, cell.y};
    std::memcpy(bytes.data() + at, image.data(), sizeof image);
  }
  return bytes;
}

/// Nothing is wrong with it, so nobody may take it for a ruin.
TEST_F(SavedMap, AMapOfAnotherVersionIsRefusedAndNotDamaged) {
  const std::string head = "matchbox_slam map, version ";
  const std::string bytes = map_with_cells_at({2, 0}, {0, 0});
  const auto write_as = [&](const std::string& version) {
    write(compress(head + version + bytes.substr(head.size() + 2)));
  };
  const auto is_damaged = [&] {
    try {
      (void)read_saved_map(path_);
    } catch (const DamagedFile&) {
      return true;
    } catch (const FileError&) {
    }
    return false;
  };
  const std::string read = "; this program reads 7, as of 1.0, and 17: ";
  for (const std::string version : {"1", "6", "8", "16"}) {
    write_as(version);
    EXPECT_EQ(error(), "'" + path_ + "' is a saved map of version " + version + read +
                           "map the recording again, or use the commit that has saved it");
    EXPECT_FALSE(is_damaged()) << version;
  }
  write(compress(head + "1"));
  EXPECT_TRUE(is_damaged()) << "cut off within the number";
  write_as("18");
  EXPECT_EQ(error(), "'" + path_ + "' is a saved map of version 18" + read +
                         "use the newer one that has saved it");
  EXPECT_FALSE(is_damaged());
  for (const char* version : {"0", "x", "", "07", "017", "99999999999999999999"}) {
    write_as(version);
    EXPECT_TRUE(is_damaged()) << version;
  }
  write_as("17");
  EXPECT_EQ(error(), "(no error)");
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
  EXPECT_THROW((void)read_engine_state(path_, options), FileError);
  options.map.max_cells = 1e9;
  EXPECT_NO_THROW((void)read_engine_state(path_, options));
  write(compress(map_with_cells_at({(1 << 24) + 1, 0}, near)));
  EXPECT_TRUE(contains(error(), "is damaged: a cell lies at 16777217, 0")) << error();
  write(compress(map_with_cells_at({0, std::numeric_limits<int>::min()}, near)));
  EXPECT_TRUE(contains(error(), "is damaged: a cell lies at 0, -2147483648")) << error();
}

TEST_F(SavedMap, RefusesRowsOfCellsThatAreNone) {
  std::string bytes = map_with_cells_at({2, 0}, {0, 0});
  // Behind four numbers of 8 bytes and two of 4.
  const std::size_t count = std::string("matchbox_slam map, version 17\n").size() + 40;
  for (const auto& [cells, text] :
       {std::make_pair(std::uint32_t{0}, "is damaged: 0 cells of a row are known from 0, 0 on"),
        std::make_pair(std::uint32_t{0xffffffff}, "is damaged: 4294967295 cells of a row"),
        std::make_pair(std::uint32_t{1} << 24U, "or its map is too large"),
        std::make_pair(std::uint32_t{10'000}, "is cut off")}) {
    std::memcpy(bytes.data() + count, &cells, sizeof cells);
    write(compress(bytes));
    EXPECT_TRUE(contains(error(), text)) << cells << ": " << error();
  }
}

TEST_F(SavedMap, RefusesNumbersThatNoMapHolds) {
  std::string bytes = map_with_cells_at({2, 0}, {0, 0});
  const std::size_t head = std::string("matchbox_slam map, version 17\n").size();
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
  const std::size_t pose = bytes.size() - kStateBytes;
  EXPECT_TRUE(contains(error_with(1e300, pose), "it holds the number 1e+300 where at most"));
  EXPECT_TRUE(contains(error_with(std::nan(""), pose), "it holds the number"));
  EXPECT_TRUE(contains(error_with(-1.0, pose + 3 * sizeof(double)), "covariance of its pose"));
  const std::size_t calibration = pose + kStateBytes - kAfterMotionBytes - kCalibrationBytes;
  EXPECT_TRUE(contains(error_with(-1.0, calibration - 24), "its last motion took -1.0 s"));
  for (const double share : {0.0, 1.5, std::nan("")}) {
    EXPECT_TRUE(contains(error_with(share, calibration - 16), "is damaged")) << share;
  }
  EXPECT_TRUE(
      contains(error_with(-1.1, calibration), "it holds the number -1.1 where at most 1.0"));
  EXPECT_TRUE(contains(error_with(-1.0, calibration + 24), "covariance of what odometry misses"));
  EXPECT_TRUE(contains(error_with(0.0, calibration + 96), "the noise of odometry is 0.0"));
  EXPECT_EQ(error_with(1.0, pose), "(no error)");
}

// --- images ---

/// The robot drives through a map that is an image, from the first scan that it was mapped from on.
class InAnImage : public SavedMap {
 protected:
  /// @param image_from_map  by which the image's frame is another than the one it was drawn in.
  EngineState read_image(MapImage image, const Pose2& image_from_map = {}) {
    image.origin = image_from_map * image.origin;
    write_map(folder_ / "image", image);
    return read_engine_state(folder_ / "image.yaml", options());
  }

  static EngineOptions options() {
    EngineOptions options;
    options.slam.update_map = false;
    return options;
  }

  /// Root mean square distance from the truth [m] once it is not lost; the scan since which is
  /// told.
  static double error_in(SlamEngine& engine, const Pose2& image_from_map, std::size_t& found) {
    double squares = 0.0;
    std::size_t count = 0;
    for (std::size_t i = 0; i < kMapped; ++i) {
      const ScanOutcome outcome = engine.process(scan_input(drive(), i));
      if (outcome.state == TrackingState::kLost) {
        continue;
      }
      found = count == 0 ? i : found;
      ++count;
      squares += (outcome.map_from_base.inverse() * image_from_map * drive().world_from_base[i])
                     .translation()
                     .squaredNorm();
    }
    return count > 0 ? std::sqrt(squares / static_cast<double>(count)) : 1e9;
  }

  /// The same of a robot that is told where it begins; fails where it is lost there.
  double error_of_told(EngineState start) {
    SlamEngine engine(options(), std::make_shared<OlsonMatcher>(), 1);
    start.begin_anew(drive().world_from_base.front(), Eigen::Vector3d(0.1, 0.1, 0.03).asDiagonal());
    engine.start_from(start);
    std::size_t found = kMapped;
    const double error = error_in(engine, {}, found);
    EXPECT_EQ(found, 0U);
    return error;
  }
};

/// A loaded image has no more than half a cell to say where a wall is; the line through its pixels
/// says more.
TEST_F(InAnImage, ARobotFindsItsWay) {
  EngineState start = read_image(make_map_image(mapped().map.occupancy));
  SlamEngine engine(options(), std::make_shared<OlsonMatcher>(), 1);
  start.begin_anew(drive().world_from_base.front() * Pose2{0.2, 0.1, -0.1},
                   Eigen::Vector3d(0.1, 0.1, 0.03).asDiagonal());
  engine.start_from(start);
  std::size_t found = kMapped;
  EXPECT_LT(error_in(engine, {}, found), 0.02);
  EXPECT_EQ(found, 0U);
}

/// An image is seen from its free ground, so that nobody has to say where the robot is; whatever
/// way the image is turned.
TEST_F(InAnImage, ARobotIsFoundWithoutAWord) {
  const MapImage image = make_map_image(mapped().map.occupancy);
  for (const Pose2& image_from_map : {Pose2{}, Pose2{3.0, -7.012, 0.6}}) {
    EngineState start = read_image(image, image_from_map);
    SlamEngine engine(options(), std::make_shared<OlsonMatcher>(), 1);
    start.begin_anew({}, Eigen::Vector3d(0.1, 0.1, 0.03).asDiagonal());
    engine.start_from(start);
    engine.begin_component(drive().scans.front().stamp);
    std::size_t found = kMapped;
    EXPECT_LT(error_in(engine, image_from_map, found), 0.02) << image_from_map.theta;
    EXPECT_LT(found, 150U) << image_from_map.theta;
    const CellBox known = engine.map().occupancy.known_bounds();
    const CellBox before = start.map.occupancy.known_bounds();
    EXPECT_TRUE(known.min == before.min && known.max == before.max) << "it stays as it is";
  }
}

/// Each pixel four: the walls are where they were, in cells that are as large as before.
TEST_F(InAnImage, PixelsMayBeSmallerThanCells) {
  const MapImage image = make_map_image(mapped().map.occupancy);
  MapImage finer = image;
  finer.width *= 2;
  finer.height *= 2;
  finer.resolution *= 0.5;
  finer.pixels.clear();
  for (int y = finer.height - 1; y >= 0; --y) {
    for (int x = 0; x < finer.width; ++x) {
      finer.pixels.push_back(image.pixel({x / 2, y / 2}));
    }
  }
  const EngineState wanted = read_image(image);
  const EngineState made = read_image(finer);
  EXPECT_TRUE(make_map_image(made.map.occupancy).pixels ==
              make_map_image(wanted.map.occupancy).pixels);
  EXPECT_LT(error_of_told(made), 0.02);
}

/// One pixel of four is kept, if any of them is wall: the walls have no gaps.
TEST_F(InAnImage, PixelsMayBeLargerThanCells) {
  const MapImage image = make_map_image(mapped().map.occupancy);
  MapImage coarser = image;
  coarser.width /= 2;
  coarser.height /= 2;
  coarser.resolution *= 2.0;
  coarser.pixels.clear();
  for (int y = coarser.height - 1; y >= 0; --y) {
    for (int x = 0; x < coarser.width; ++x) {
      std::uint8_t pixel = image.pixel({2 * x, 2 * y});
      for (const Cell& other :
           {Cell{2 * x + 1, 2 * y}, Cell{2 * x, 2 * y + 1}, Cell{2 * x + 1, 2 * y + 1}}) {
        pixel = std::min(pixel, image.pixel(other));
      }
      coarser.pixels.push_back(pixel);
    }
  }
  const EngineState start = read_image(coarser);
  // Of walls that are twice as thick in pixels, and drawn as thin: without gaps some nine in ten.
  EXPECT_GT(10 * start.map.field.surface_cells().size(),
            8 * read_image(image).map.field.surface_cells().size());
  EXPECT_LT(error_of_told(start), 0.06);
}

TEST_F(InAnImage, SaysWhyAnImageIsNotTaken) {
  MapImage image = make_map_image(mapped().map.occupancy);
  EngineOptions options;
  const auto text = [&] {
    write_map(folder_ / "image", image);
    try {
      (void)read_engine_state(folder_ / "image.yaml", options);
    } catch (const std::exception& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(text(), "");
  options.map.max_cells = 100.0;
  EXPECT_TRUE(contains(text(), "cells; allowed: 100.0 in all")) << text();
  options.map.max_cells = 1e6;
  EXPECT_EQ(text(), "");
  image.resolution = 50.0;
  EXPECT_TRUE(contains(text(), "has the resolution 50.0; allowed: 0.001 to 1.0, in metres a pixel"))
      << text();
  image.resolution = 0.05;
  image.origin = {500000.0, 5400000.0, 0.0};  // as of UTM
  EXPECT_TRUE(contains(text(), "lies too far from 0, 0: its origin is 500000.0, 5400000.0"))
      << text();
  image.origin = {};
  std::fill(image.pixels.begin(), image.pixels.end(), MapImage::kFreePixel);
  EXPECT_TRUE(contains(text(), "has no occupied pixel")) << text();
  EXPECT_TRUE(contains(text(), "set negate: 1")) << text();
}

TEST(ReadEngineState, SaysWhatToGiveInPlaceOfWhatIsNoMap) {
  const auto error = [](const std::string& path) {
    return error_text<ConfigurationError>([&] { (void)read_engine_state(path, EngineOptions{}); });
  };
  const TemporaryFolder folder;
  EXPECT_EQ(error(folder / ""), "'" + (folder / "") + "' is a folder; give the map in it, as '" +
                                    (folder / "map.slam") + "'");
  EXPECT_EQ(error("my.bag"),
            "'my.bag' is a recording; map_bag 'my.bag' --out DIR makes a map of it, DIR/map.slam");
  EXPECT_EQ(
      error("map.png"),
      "'map.png' is the image of a map; give the .slam that was saved beside it, or the .yaml "
      "that names the image and says where it lies");
  EXPECT_EQ(error("map.txt"),
            "'map.txt' is not read as a map; allowed: a .slam file of map_bag or ~save_map, or a "
            ".yaml file as of map_server");
}

}  // namespace
}  // namespace matchbox_slam
