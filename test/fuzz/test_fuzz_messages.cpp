// Scans, transforms and initial poses that nobody should send, through the queue and the engine
// with each matcher. Whatever comes, nothing throws, every scan is accounted for, and poses are
// numbers.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <string>

#include "fuzz/fuzz.hpp"
#include "matchbox_slam/io/map_file.hpp"
#include "matchbox_slam/io/yaml_parameters.hpp"
#include "ros/matcher_loader.hpp"
#include "ros/message_conversion.hpp"
#include "ros/messages.hpp"
#include "ros/queue_settings.hpp"
#include "ros/scan_queue.hpp"
#include "ros/scan_types.hpp"
#include "run/slam_run.hpp"

namespace matchbox_slam {
namespace {

constexpr std::uint64_t kMessagesPerRun = 100;
constexpr std::size_t kMostBytes = std::size_t{1} << 30U;  // of a map

std::string odd_frame(Random& random) {
  static const std::vector<std::string> kFrames = {"",         "/",
                                                   "//",       "map",
                                                   "/map",     "odom",
                                                   "/odom",    "base",
                                                   "laser",    "/laser",
                                                   "a/b",      " ",
                                                   "base\n",   std::string("ba\0se", 5),
                                                   "\xff\xfe", std::string(100000, 'x')};
  return one_of(kFrames, random);
}

/// Also those that no constructor makes, as messages are read without one.
ros::Time odd_stamp(Random& random) {
  static const std::vector<std::uint32_t> kSeconds = {
      0, 1, 999, 1000, 2147483647U, 2147483648U, 4000000000U, 4000000001U, 4294967295U};
  static const std::vector<std::uint32_t> kNanoseconds = {0, 1, 999999999U, 1000000000U,
                                                          4294967295U};
  ros::Time stamp;
  stamp.sec = one_of(kSeconds, random);
  stamp.nsec = one_of(kNanoseconds, random);
  return stamp;
}

float odd_float(Random& random) {
  const double number = odd_number(random);
  constexpr double kLargest = std::numeric_limits<float>::max();
  return std::isfinite(number) ? static_cast<float>(std::clamp(number, -kLargest, kLargest))
                               : static_cast<float>(number);
}

void damage(sensor_msgs::LaserScan& scan, Random& random) {
  switch (below(12, random)) {
    case 0:
      scan.header.stamp = odd_stamp(random);
      break;
    case 1:
      scan.header.frame_id = odd_frame(random);
      break;
    case 2:
      scan.angle_min = odd_float(random);
      break;
    case 3:
      scan.angle_increment = odd_float(random);
      break;
    case 4:
      scan.time_increment = odd_float(random);
      break;
    case 5:
      scan.range_min = odd_float(random);
      break;
    case 6:
      scan.range_max = odd_float(random);
      break;
    case 7:
      scan.ranges.resize(below(3, random));
      break;
    case 8:
      scan.ranges.resize(one_of<std::size_t>({1000, 5000, 100001}, random), odd_float(random));
      break;
    case 9:
      std::fill(scan.ranges.begin(), scan.ranges.end(), odd_float(random));
      break;
    case 10:
      scan.angle_increment = -scan.angle_increment;
      break;
    default:
      for (float& range : scan.ranges) {
        range = happens(0.3, random) ? odd_float(random) : range;
      }
      break;
  }
}

/// A number that is as good as any, or one that is not.
std::uint32_t odd_count(Random& random) {
  return one_of<std::uint32_t>({0, 1, 3, 24, 90, 1000, 4294967295U}, random);
}

void damage(sensor_msgs::PointCloud2& cloud, Random& random) {
  sensor_msgs::PointField& field = cloud.fields[below(cloud.fields.size(), random)];
  switch (below(8, random)) {
    case 0:
      cloud.width = odd_count(random);
      break;
    case 1:
      cloud.height = odd_count(random);
      break;
    case 2:
      cloud.point_step = odd_count(random);
      break;
    case 3:
      cloud.row_step = odd_count(random);
      break;
    case 4:
      field.offset = odd_count(random);
      break;
    case 5:
      field.datatype = static_cast<std::uint8_t>(below(256, random));
      break;
    case 6:
      cloud.data.resize(below(cloud.data.size() + 100, random));
      break;
    default:
      for (std::uint8_t& byte : cloud.data) {
        byte = happens(0.1, random) ? static_cast<std::uint8_t>(below(256, random)) : byte;
      }
      break;
  }
}

void damage(geometry_msgs::TransformStamped& link, Random& random) {
  geometry_msgs::Transform& transform = link.transform;
  switch (below(7, random)) {
    case 0:
      link.header.stamp = odd_stamp(random);
      break;
    case 1:
      link.header.frame_id = odd_frame(random);
      break;
    case 2:
      link.child_frame_id = odd_frame(random);
      break;
    case 3:
      one_of<double*>(
          {&transform.translation.x, &transform.translation.y, &transform.translation.z},
          random)[0] = odd_number(random);
      break;
    case 4:
      one_of<double*>({&transform.rotation.x, &transform.rotation.y, &transform.rotation.z,
                       &transform.rotation.w},
                      random)[0] = odd_number(random);
      break;
    case 5:
      transform.translation.x = random.uniform(-1e5, 1e5);
      transform.translation.y = random.uniform(-1e5, 1e5);
      break;
    default: {
      const double angle = random.uniform(-4.0, 4.0);  // a laser or a robot that has tipped over
      transform.rotation.x = std::sin(angle);
      transform.rotation.w = std::cos(angle);
      transform.rotation.z = 0.0;
      break;
    }
  }
}

void damage(sensor_msgs::Imu& message, Random& random) {
  switch (below(4, random)) {
    case 0:
      message.header.stamp = odd_stamp(random);
      break;
    case 1:
      message.header.frame_id = odd_frame(random);
      break;
    case 2:
      message.orientation_covariance[0] = odd_number(random);
      break;
    default:
      one_of<double*>({&message.orientation.x, &message.orientation.y, &message.orientation.z,
                       &message.orientation.w},
                      random)[0] = odd_number(random);
      break;
  }
}

/// One robot with its queue and engine, and what is sent to it.
class Fuzzed {
 public:
  Fuzzed(const LiveConfiguration& configuration, std::uint64_t number)
      : random_(mix_seed(21, number)),
        run_(configuration),
        queue_(queue_settings(configuration.setup().run, configuration.setup().engine.scan,
                              configuration.setup().timing, 0.0)) {}

  void send_messages() {
    for (std::uint64_t k = 0; k < kMessagesPerRun; ++k) {
      stamp_ += happens(0.02, random_) ? random_.uniform(-5.0, 20.0) : 0.05;
      send_one();
      process_ready();
      check_account();
    }
    queue_.finish();
    process_ready();
    check_account();
    EXPECT_EQ(queue_.waiting(), 0U);
    check_results();
  }

 private:
  [[nodiscard]] ros::Time now() {
    return happens(0.01, random_) ? ros::Time(odd_stamp(random_).sec, 0)
                                  : ros::Time(std::max(1.0, stamp_ + 0.01));
  }

  void send_one() {
    if (queue_.settings().use_imu && happens(0.5, random_)) {
      send_imu();
    }
    const double x = 0.1 * (stamp_ - 1000.0);
    switch (below(happens(0.1, random_) ? 4 : 3, random_)) {
      case 0:
        return send_scan();
      case 1:
        return send_links({make_transform(std::max(0.0, stamp_), "odom", "base", x, 0.1 * x)},
                          false);
      case 2:
        return send_links({make_transform(std::max(0.0, stamp_), "odom", "base", x, 0.1 * x),
                           make_transform(std::max(0.0, stamp_), "base", "laser", 0.2)},
                          happens(0.1, random_));
      default:
        return send_pose();
    }
  }

  void send_scan() {
    sensor_msgs::LaserScan scan = make_scan(std::max(0.0, stamp_ - 0.02));
    while (happens(0.3, random_)) {
      damage(scan, random_);
    }
    if (happens(0.7, random_)) {
      queue_.add_scan(scan, now());
    } else {
      send_cloud(scan);
    }
  }

  void send_cloud(sensor_msgs::LaserScan scan) {
    scan.ranges.resize(std::min<std::size_t>(scan.ranges.size(), 5000));
    sensor_msgs::PointCloud2 cloud = to_cloud(scan);
    while (happens(0.3, random_)) {
      damage(cloud, random_);
    }
    CloudOptions options;
    options.ring = happens(0.5, random_) ? 3 : -1;
    queue_.add_scan(to_scan(cloud, options), now());
  }

  void send_links(std::vector<geometry_msgs::TransformStamped> links, bool is_static) {
    while (happens(0.2, random_)) {
      damage(links[below(links.size(), random_)], random_);
    }
    queue_.add_transforms(make_transforms(links), is_static, now());
  }

  void send_imu() {
    sensor_msgs::Imu message;
    message.header.stamp = ros::Time(std::max(0.0, stamp_));
    message.header.frame_id = "base";
    message.orientation.x = 0.05 * std::sin(stamp_);
    message.orientation.w = 1.0;
    while (happens(0.2, random_)) {
      damage(message, random_);
    }
    (void)queue_.add_imu(message, now());
  }

  void send_pose() {
    geometry_msgs::PoseWithCovariance message;
    message.pose.position.x = odd_number(random_);
    message.pose.orientation.w = odd_number(random_);
    message.pose.orientation.z = odd_number(random_);
    for (double& entry : message.covariance) {
      entry = happens(0.5, random_) ? odd_number(random_) : 0.0;
    }
    if (find_defect(message).empty()) {
      queue_.add_event(SetPose{to_pose2(message.pose), plane_covariance(message)});
    }
  }

  void process_ready() {
    while (const std::optional<ScanQueue::Item> item = queue_.next()) {
      if (const auto* scan = std::get_if<ReadyScan>(&*item)) {
        const ScanOutcome outcome = run_.process(scan->input).value();
        ASSERT_TRUE(outcome.map_from_base.is_finite());
        ASSERT_TRUE(outcome.covariance.allFinite());
        ASSERT_GE(outcome.covariance.diagonal().minCoeff(), 0.0);
        ASSERT_LE(run_.drawn_map().occupancy.bytes() + run_.drawn_map().field.bytes(), kMostBytes);
      } else if (const auto* event = std::get_if<RunEvent>(&*item)) {
        run_.apply(*event);
      } else {
        run_.jump_back();
      }
    }
    for (const SkippedScan& skipped : queue_.take_skipped()) {
      ASSERT_FALSE(skipped.text.empty());
    }
  }

  void check_account() const {
    const ScanAccount& account = queue_.account();
    ASSERT_EQ(account.received, account.delivered + account.skipped_total() + queue_.waiting());
  }

  /// What becomes of them at the end of map_bag.
  void check_results() const {
    const Trajectory trajectory(run_.trajectory());
    const MapImage image = make_map_image(run_.drawn_map().occupancy);
    ASSERT_LE(image.pixels.size(), kMostBytes);
  }

  Random random_;
  SlamRun run_;
  ScanQueue queue_;
  double stamp_ = 1000.0;
};

class FuzzMessages : public testing::TestWithParam<const char*> {};

TEST_P(FuzzMessages, NeverBreakTheMapping) {
  const MatcherLoader loader;
  Parameters parameters =
      parse_yaml_parameters(std::string("base_frame: base\nqueue_size: 20\nmap/resolution: 0.1\n"
                                        "slam/insert_distance: 0\nmatcher: ") +
                                GetParam(),
                            "fuzz");
  const LiveConfiguration with_odometry(parameters, loader);
  Parameters imu = parameters;
  imu.set("imu_topic", "imu");
  const LiveConfiguration with_imu(imu, loader);
  parameters.set("use_odometry", false);
  parameters.set("base_frame", "laser");
  const LiveConfiguration laser_alone(parameters, loader);
  const std::uint64_t first = first_fuzz_input() / kMessagesPerRun;
  const std::uint64_t runs = std::max<std::uint64_t>(1, fuzz_inputs(1000) / kMessagesPerRun);
  for (std::uint64_t number = first; number < first + runs; ++number) {
    SCOPED_TRACE("MATCHBOX_FUZZ_FIRST=" + std::to_string(number * kMessagesPerRun));
    try {
      const LiveConfiguration& configuration = number % 4 == 3   ? laser_alone
                                               : number % 4 == 1 ? with_imu
                                                                 : with_odometry;
      Fuzzed(configuration, number).send_messages();
    } catch (const std::exception& error) {
      ADD_FAILURE() << error.what();
    }
    if (HasFailure()) {
      return;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(EachMatcher, FuzzMessages,
                         testing::Values("olson", "hough", "monte_carlo", "odometry_only"),
                         [](const auto& matcher) { return std::string(matcher.param); });

}  // namespace
}  // namespace matchbox_slam
