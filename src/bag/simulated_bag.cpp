#include "bag/simulated_bag.hpp"

#include <fmt/core.h>
#include <geometry_msgs/TransformStamped.h>
#include <ros/time.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/LaserScan.h>
#include <std_msgs/String.h>
#include <tf2_eigen/tf2_eigen.h>
#include <tf2_msgs/TFMessage.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "common/interrupted.hpp"

namespace matchbox_slam {
namespace {

constexpr const char* kOdometryFrame = "odom_combined";
constexpr const char* kFootprintFrame = "base_footprint";
constexpr const char* kBaseFrame = "base_link";
constexpr const char* kLaserFrame = "base_laser_link";
constexpr const char* kSecondLaserFrame = "second_laser_link";
constexpr const char* kImuFrame = "imu_link";
// [s] from the end of a measurement until it is recorded.
constexpr double kScanLatency = 0.012;
constexpr double kOdometryLatency = 0.004;
constexpr double kLinksLatency = 0.002;

ros::Time to_time(double stamp) { return ros::Time().fromSec(stamp); }

/// Makes messages in the frames of the recording.
class MessageMaker {
 public:
  MessageMaker(SimulatedBagOptions options, LaserOptions laser)
      : options_(std::move(options)), laser_(std::move(laser)) {}

  [[nodiscard]] sensor_msgs::LaserScan scan(const LaserScan& scan,
                                            const std::string& frame_name) const {
    sensor_msgs::LaserScan message;
    message.header.stamp = to_time(scan.stamp - options_.clock_offset);
    message.header.frame_id = frame(frame_name);
    message.angle_min = static_cast<float>(scan.angle_min);
    message.angle_max = static_cast<float>(
        scan.angle_min + scan.angle_increment * static_cast<double>(scan.ranges.size() - 1));
    message.angle_increment = static_cast<float>(scan.angle_increment);
    message.time_increment =
        static_cast<float>(told(laser_.sent_time_increment, scan.time_increment));
    message.scan_time =
        static_cast<float>(told(laser_.sent_scan_time, 1.0 / (laser_.scan_rate * laser_.parts)));
    message.range_min = static_cast<float>(scan.range_min);
    message.range_max = static_cast<float>(scan.range_max);
    message.ranges = scan.ranges;
    return message;
  }

  [[nodiscard]] tf2_msgs::TFMessage odometry(const OdometryReading& reading) const {
    const Pose2& pose = reading.odom_from_base;
    const Eigen::Isometry3d odom_from_base =
        Eigen::Translation3d(pose.x, pose.y, 0.0) *
        Eigen::AngleAxisd(pose.theta, Eigen::Vector3d::UnitZ()) *
        (options_.imu ? Eigen::Isometry3d::Identity() : laser_.rocked(reading.stamp));
    tf2_msgs::TFMessage message;
    message.transforms = {
        transform(reading.stamp, kOdometryFrame, kFootprintFrame, odom_from_base)};
    return message;
  }

  [[nodiscard]] sensor_msgs::Imu imu(const OdometryReading& reading) const {
    constexpr double kNorth = 2.0;  // rad
    const Eigen::Isometry3d north_from_imu =
        Eigen::AngleAxisd(kNorth + reading.odom_from_base.theta, Eigen::Vector3d::UnitZ()) *
        laser_.rocked(reading.stamp) * base_from_imu();
    sensor_msgs::Imu message;
    message.header.stamp = to_time(reading.stamp);
    message.header.frame_id = frame(kImuFrame);
    message.orientation = tf2::toMsg(Eigen::Quaterniond(north_from_imu.linear()));
    return message;
  }

  [[nodiscard]] tf2_msgs::TFMessage links(double stamp, const SimulatedRun& run) const {
    Eigen::Isometry3d footprint_from_base = Eigen::Isometry3d::Identity();
    footprint_from_base.translation().z() = kBaseHeight;
    tf2_msgs::TFMessage message;
    message.transforms = {
        transform(stamp, kFootprintFrame, kBaseFrame, footprint_from_base),
        transform(stamp, kBaseFrame, kLaserFrame, run.base_from_laser * laser_.nodded(stamp))};
    if (options_.imu) {
      message.transforms.push_back(transform(stamp, kBaseFrame, kImuFrame, base_from_imu()));
    }
    if (!run.second_scans.empty()) {
      message.transforms.push_back(transform(stamp, kBaseFrame, kSecondLaserFrame,
                                             run.base_from_second * laser_.nodded(stamp)));
    }
    return message;
  }

 private:
  /// What a message says, which may be another than the truth.
  [[nodiscard]] static double told(double sent, double truth) { return sent < 0.0 ? truth : sent; }

  [[nodiscard]] static Eigen::Isometry3d base_from_imu() {
    return Eigen::Translation3d(-0.1, 0.05, 0.3) *
           Eigen::AngleAxisd(0.5 * kPi, Eigen::Vector3d::UnitX());
  }

  [[nodiscard]] std::string frame(const std::string& name) const {
    return (options_.leading_slashes ? "/" : "") + name;
  }

  [[nodiscard]] geometry_msgs::TransformStamped transform(
      double stamp, const std::string& parent, const std::string& child,
      const Eigen::Isometry3d& parent_from_child) const {
    geometry_msgs::TransformStamped message = tf2::eigenToTransform(parent_from_child);
    message.header.stamp = to_time(stamp);
    message.header.frame_id = frame(parent);
    message.child_frame_id = frame(child);
    return message;
  }

  SimulatedBagOptions options_;
  LaserOptions laser_;
};

rosbag::CompressionType compression_type(const std::string& name) {
  if (name == "bz2") {
    return rosbag::compression::BZ2;
  }
  return name == "lz4" ? rosbag::compression::LZ4 : rosbag::compression::Uncompressed;
}

void check_stamps(const SimulatedRun& run, double clock_offset) {
  for (const LaserScan& scan : run.scans) {
    if (!(scan.stamp - clock_offset > 0.0)) {
      throw ConfigurationError(fmt::format(
          "clock_offset: {:f} s is not allowed; allowed: less than the first stamp, {:f} s",
          clock_offset, run.scans.front().stamp));
    }
  }
}

void write_record(const SimulationRecord& record, double record_time, rosbag::Bag& bag) {
  std_msgs::String message;
  message.data = to_yaml(record);
  bag.write(kSimulationTopic, to_time(record_time), message);
}

void write_messages(const SimulatedRun& run, const SimulatedBagOptions& options,
                    const LaserOptions& laser, const std::function<bool()>& is_interrupted,
                    rosbag::Bag& bag) {
  const MessageMaker make(options, laser);
  // Messages are made only when it is their turn.
  std::vector<std::pair<double, std::function<void(const ros::Time&)>>> writes;
  const auto write_scans = [&](const std::vector<LaserScan>& scans, const char* topic,
                               const char* frame) {
    for (const LaserScan& scan : scans) {
      writes.emplace_back(scan.stamp + scan.duration() + kScanLatency,
                          [&bag, &make, &scan, topic, frame](const ros::Time& time) {
                            bag.write(topic, time, make.scan(scan, frame));
                          });
    }
  };
  write_scans(run.scans, "/base_scan", kLaserFrame);
  write_scans(run.second_scans, "/second_scan", kSecondLaserFrame);
  for (const OdometryReading& reading : run.odometry) {
    writes.emplace_back(reading.stamp + kLinksLatency, [&](const ros::Time& time) {
      bag.write("/tf", time, make.links(reading.stamp, run));
    });
    if (options.imu) {
      writes.emplace_back(reading.stamp + kOdometryLatency, [&](const ros::Time& time) {
        bag.write("/imu", time, make.imu(reading));
      });
    }
    if (!options.no_odometry) {
      writes.emplace_back(reading.stamp + kOdometryLatency, [&](const ros::Time& time) {
        bag.write("/tf", time, make.odometry(reading));
      });
    }
  }
  std::stable_sort(writes.begin(), writes.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  for (const auto& [record_time, write] : writes) {
    if (is_interrupted && is_interrupted()) {
      throw Interrupted("interrupted; nothing is written");
    }
    write(to_time(record_time));
  }
}

}  // namespace

SimulatedBagWriter::SimulatedBagWriter(std::string path, SimulatedBagOptions options)
    : options_(std::move(options)), bag_(std::move(path), compression_type(options_.compression)) {}

void SimulatedBagWriter::write(const SimulatedRun& run, const SimulationRecord& record,
                               const std::function<bool()>& is_interrupted) {
  check_stamps(run, options_.clock_offset);
  bag_.write([&](rosbag::Bag& bag) {
    write_record(record, run.odometry.front().stamp + kLinksLatency, bag);
    write_messages(run, options_, record.laser, is_interrupted, bag);
  });
}

}  // namespace matchbox_slam
