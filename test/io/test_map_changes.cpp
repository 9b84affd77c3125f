#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "common/error_text.hpp"
#include "io/map_changes.hpp"
#include "io/temporary_folder.hpp"
#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/io/saved_map.hpp"
#include "matchbox_slam/matching/olson/olson_matcher.hpp"
#include "simulation/make_world.hpp"
#include "simulation/simulated_run.hpp"
#include "simulation/simulation_support.hpp"

namespace matchbox_slam {
namespace {

std::vector<std::string> pieces_of(const std::string& bytes) {
  std::vector<std::string> pieces;
  PieceCutter cutter([&pieces](const std::string& piece) { pieces.push_back(piece); });
  cutter.add(bytes.substr(0, bytes.size() / 3));
  cutter.add(bytes.substr(bytes.size() / 3));
  cutter.finish();
  return pieces;
}

TEST(PieceCutter, CutsWhatComesAgainInTheSamePlaces) {
  Random random(1);
  std::string bytes;
  for (int i = 0; i < 400000; ++i) {
    bytes += static_cast<char>(256.0 * random.uniform());
  }
  const std::vector<std::string> pieces = pieces_of(bytes);
  std::string whole;
  for (const std::string& piece : pieces) {
    whole += piece;
  }
  EXPECT_TRUE(whole == bytes);
  EXPECT_GT(pieces.size(), 400000U / 3500U);
  EXPECT_LT(pieces.size(), 400000U / 1500U);
  const std::vector<std::string> moved = pieces_of("some more" + bytes);
  EXPECT_EQ(std::vector<std::string>(moved.end() - 100, moved.end()),
            std::vector<std::string>(pieces.end() - 100, pieces.end()));
}

class MapChanges : public testing::Test {
 protected:
  static SimulatedRun drive() {
    SimulationOptions options;
    options.time.duration = 30.0;
    const World world = make_world("rooms", 5);
    return simulate_run(world, world.route(), options, 5);
  }

  void drive_on(std::size_t scans) {
    for (std::size_t i = 0; i < scans; ++i) {
      engine_.process(scan_input(run_, next_++));
    }
  }

  /// Returns what it is made of.
  MapPieces save() const {
    std::string bytes;
    MapPieces pieces =
        write_map_in_pieces(engine_now(), [&bytes](const std::string& more) { bytes += more; });
    replace_file(path_, bytes);
    return pieces;
  }

  [[nodiscard]] EngineState engine_now() const { return engine_.snapshot(); }

  [[nodiscard]] std::string read() const { return to_saved_map(read_saved_map(path_)); }

  const SimulatedRun run_ = drive();
  mutable SlamEngine engine_{EngineOptions{}, std::make_shared<OlsonMatcher>(), 1};
  std::size_t next_ = 0;
  TemporaryFolder folder_;
  const std::string path_ = folder_ / "map.slam";
};

TEST_F(MapChanges, TheMapComesBackWithThemBitByBitAndTheyAreSmall) {
  drive_on(400);
  const MapPieces saved = save();
  const std::string before = to_saved_map(engine_now());
  EXPECT_TRUE(read_file(path_) == before) << "pieces or not";
  drive_on(1);
  replace_file(path_of_changes(path_), changes_since(saved, engine_now()));
  EXPECT_TRUE(read() == to_saved_map(engine_now()));
  EXPECT_LT(std::filesystem::file_size(path_of_changes(path_)), before.size() / 20);
  drive_on(100);
  replace_file(path_of_changes(path_), changes_since(saved, engine_now()));
  EXPECT_TRUE(read() == to_saved_map(engine_now()));
  // It explores, and of what was there before the cells have changed: 0.58 is measured.
  EXPECT_LT(static_cast<double>(std::filesystem::file_size(path_of_changes(path_))),
            0.65 * static_cast<double>(to_saved_map(engine_now()).size()));
}

TEST_F(MapChanges, OfAnotherMapAreLeftAlone) {
  drive_on(100);
  const MapPieces first = save();
  drive_on(100);
  replace_file(path_of_changes(path_), changes_since(first, engine_now()));
  drive_on(10);
  save();  // as a program that was ended before it could remove them
  EXPECT_TRUE(read() == to_saved_map(engine_now()));
}

TEST_F(MapChanges, DamagedOnesAreToldAndTheMapBeforeIsWhole) {
  drive_on(100);
  const MapPieces saved = save();
  const std::string before = to_saved_map(engine_now());
  drive_on(100);
  const std::string changes = changes_since(saved, engine_now());
  const std::string path = path_of_changes(path_);
  std::string damaged = changes;
  damaged[changes.size() / 2] ^= 1;
  for (const std::string& bytes : {changes.substr(0, changes.size() / 2), damaged, std::string()}) {
    replace_file(path, bytes);
    const std::string told = error_text<DamagedChanges>([&] { (void)read_saved_map(path_); });
    EXPECT_TRUE(contains(told, "'" + path + "' is")) << told;
    EXPECT_TRUE(contains(told, "to go on with that, rm " + path)) << told;
  }
  std::filesystem::remove(path);
  EXPECT_TRUE(read() == before);
}

TEST_F(MapChanges, ACopyThatIsKeptIsReadLikeTheFile) {
  drive_on(50);
  save();
  keep_as(path_, path_ + ".1");
  keep_as(path_of_changes(path_), path_of_changes(path_ + ".1"));
  EXPECT_FALSE(std::filesystem::exists(path_of_changes(path_ + ".1")));
  const std::string before = to_saved_map(engine_now());
  drive_on(50);
  save();
  EXPECT_TRUE(to_saved_map(read_engine_state(path_ + ".1", {})) == before);
}

}  // namespace
}  // namespace matchbox_slam
