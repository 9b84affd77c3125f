// Of ros/scan_message.hpp: laser scans, the first echoes of several, and clouds of the same points
// give the same map.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "common/error_text.hpp"
#include "evaluation/absolute_trajectory_error.hpp"
#include "io/real_data.hpp"
#include "io/temporary_folder.hpp"
#include "io/tum.hpp"
#include "matchbox_slam/common/parameters.hpp"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/map_file.hpp"
#include "ros/messages.hpp"
#include "ros/scan_types.hpp"
#include "tools/run_command.hpp"

namespace matchbox_slam {
namespace {

/// How far two maps are from being the same.
struct Difference {
  double position = 0.0;  ///< [m], of the pose that differs most
  double heading = 0.0;   ///< [rad]
  int cells = 0;          ///< whose pixels differ; all where the maps are not of the same size
};

/// Options with which a cloud of the scan's points has its beams.
std::string beams_of(const sensor_msgs::LaserScan& scan) {
  const auto first = static_cast<double>(scan.angle_min);
  const auto step = static_cast<double>(scan.angle_increment);
  const auto set = [](const std::string& name, double value) {
    return " --set cloud/" + name + "=" + to_string(ParameterValue(value));
  };
  return set("angle_min", first) +
         set("angle_max", first + step * static_cast<double>(scan.ranges.size() - 1)) +
         set("angle_increment", step) + set("range_min", static_cast<double>(scan.range_min)) +
         set("range_max", static_cast<double>(scan.range_max));
}

class ScanTypes : public testing::Test {
 protected:
  void map(const std::string& bag, const std::string& out, const std::string& arguments = "") {
    const Outcome mapped =
        run_command(MATCHBOX_MAP_BAG, bag + " --quiet --out " + (folder_ / out) + " " + arguments);
    ASSERT_EQ(mapped.exit_code, 0) << mapped.output;
  }

  void expect_same_bytes(const std::string& a, const std::string& b) {
    for (const std::string file : {"trajectory.tum", "map.pgm", "map.yaml"}) {
      EXPECT_TRUE(read_file(folder_ / (a + "/" + file)) == read_file(folder_ / (b + "/" + file)))
          << file;
    }
  }

  /// Of a map from the one of the laser scans.
  Difference difference_of(const std::string& out) {
    Difference worst;
    const Trajectory expected = read_tum(folder_ / "scans/trajectory.tum");
    const Trajectory found = read_tum(folder_ / (out + "/trajectory.tum"));
    EXPECT_EQ(found.size(), expected.size());
    for (std::size_t i = 0; i < std::min(found.size(), expected.size()); ++i) {
      EXPECT_EQ(found.poses()[i].stamp, expected.poses()[i].stamp);
      const Pose2 error = expected.poses()[i].pose.inverse() * found.poses()[i].pose;
      worst.position = std::max(worst.position, error.translation().norm());
      worst.heading = std::max(worst.heading, std::abs(error.theta));
    }
    worst.cells = different_cells(read_map(folder_ / "scans/map.yaml"),
                                  read_map(folder_ / (out + "/map.yaml")));
    RecordProperty(out + "_position", to_string(ParameterValue(worst.position)));
    RecordProperty(out + "_heading", to_string(ParameterValue(worst.heading)));
    RecordProperty(out + "_cells", worst.cells);
    return worst;
  }

  TemporaryFolder folder_;

 private:
  static int different_cells(const MapImage& a, const MapImage& b) {
    int count = 0;
    const bool same_size = a.width == b.width && a.height == b.height;
    for (std::size_t i = 0; i < a.pixels.size(); ++i) {
      count += same_size && a.pixels[i] == b.pixels[i] ? 0 : 1;
    }
    return count;
  }
};

TEST_F(ScanTypes, GiveTheSameMapOfASimulatedRoom) {
  const std::string bag = folder_ / "scans.bag";
  const Outcome simulated =
      run_command(MATCHBOX_SIMULATE, "--world rooms --seed 4 --duration 20 --beams 521 --bag " +
                                         bag + " --truth " + (folder_ / "truth.tum"));
  ASSERT_EQ(simulated.exit_code, 0) << simulated.output;
  convert_bag(bag, folder_ / "echoes.bag", "/base_scan", "/echoes", to_multi_echo);
  std::string beams;
  convert_bag(bag, folder_ / "clouds.bag", "/base_scan", "/points",
              [&](const sensor_msgs::LaserScan& scan) {
                beams = beams_of(scan);
                return to_cloud(scan);
              });
  map(bag, "scans");
  map(folder_ / "echoes.bag", "echoes");
  expect_same_bytes("scans", "echoes");
  map(folder_ / "clouds.bag", "band", beams);
  const Difference band = difference_of("band");
  EXPECT_LT(band.position, 3.2e-7);  // 2.2e-7 is measured: x and y are of 32 bits
  EXPECT_LT(band.heading, 8.7e-8);   // 5.8e-8
  EXPECT_EQ(band.cells, 0);
  map(folder_ / "clouds.bag", "ring", beams + " --set cloud/ring=3");
  expect_same_bytes("band", "ring");
}

TEST_F(ScanTypes, GiveTheSameMapOfJarvis) {
  const std::string bag = real_data("jarvis_circular.bag");
  MATCHBOX_SKIP_WITHOUT(bag);
  const std::string topic = "/driver_laser_security/laser_scan";
  convert_bag(bag, folder_ / "echoes.bag", topic, "/echoes", to_multi_echo);
  convert_bag(bag, folder_ / "clouds.bag", topic, "/points", to_cloud);
  map(bag, "scans", "--scan-topic " + topic);
  map(folder_ / "echoes.bag", "echoes");
  expect_same_bytes("scans", "echoes");
  const Trajectory truth = read_tum(real_data("jarvis_circular.truth.tum"));
  const auto error = [&](const std::string& out) {
    return absolute_trajectory_error(read_tum(folder_ / (out + "/trajectory.tum")), truth)
        .translation.rmse;
  };
  // By default there is a beam every quarter of a degree, as this laser has it.
  map(folder_ / "clouds.bag", "clouds");
  const Difference clouds = difference_of("clouds");
  // Of some pairs of beams it is a matter of rounding whether they are a piece of wall.
  EXPECT_LT(clouds.position, 3.3e-4);  // 2.2e-4 is measured
  EXPECT_LT(clouds.heading, 8.5e-5);   // 5.7e-5
  EXPECT_LE(clouds.cells, 4);          // 3
  EXPECT_NEAR(error("clouds"), error("scans"), 3.7e-6);
  map(folder_ / "clouds.bag", "ring", "--set cloud/ring=3");
  expect_same_bytes("clouds", "ring");
}

TEST_F(ScanTypes, SaysWhyCloudsAreSkippedAndMapsTheOthers) {
  SmallBag recipe;
  write_small_bag(folder_ / "scans.bag", recipe);
  int number = 0;
  convert_bag(folder_ / "scans.bag", folder_ / "clouds.bag", "/scan", "/points",
              [&](const sensor_msgs::LaserScan& scan) {
                sensor_msgs::PointCloud2 cloud = to_cloud(scan);
                switch (number++) {
                  case 10:
                    cloud.fields[0].name = "range";
                    break;
                  case 11:
                    cloud.data.resize(100);
                    break;
                  case 12:
                    cloud.is_bigendian = 1;
                    break;
                  case 13:
                    cloud = make_cloud(scan.header, {});
                    break;
                  default:
                    break;
                }
                return cloud;
              });
  const Outcome mapped =
      run_command(MATCHBOX_MAP_BAG, (folder_ / "clouds.bag") + " --out " + (folder_ / "out"));
  EXPECT_EQ(mapped.exit_code, 0) << mapped.output;
  EXPECT_TRUE(contains(mapped.output, "scan topic /points (sensor_msgs/PointCloud2)"))
      << mapped.output;
  EXPECT_TRUE(contains(mapped.output,
                       "skipped (invalid): its points have no field x; they have: range, y, z, "
                       "ring"))
      << mapped.output;
  EXPECT_TRUE(contains(mapped.output, "skipped (empty): it has no points")) << mapped.output;
  const auto report = nlohmann::json::parse(read_file(folder_ / "out/report.json"));
  EXPECT_EQ(report.at("scans").at("received"), 50);
  EXPECT_EQ(report.at("scans").at("used"), 46);
  EXPECT_EQ(report.at("scans").at("skipped").at("invalid"), 3);
  EXPECT_EQ(report.at("scans").at("skipped").at("empty"), 1);
  const Outcome without =
      run_command(MATCHBOX_MAP_BAG, (folder_ / "clouds.bag") + " --out " + (folder_ / "out") +
                                        " --set cloud/min_height=2");
  EXPECT_EQ(without.exit_code, 2) << without.output;
  EXPECT_TRUE(contains(without.output,
                       "cloud/min_height: 2.0 is not allowed; allowed: less than "
                       "cloud/max_height, 0.2"))
      << without.output;
}

}  // namespace
}  // namespace matchbox_slam
