#include <limits>
#include <optional>
#include <type_traits>
#include <utility>

#include "io/image_views.hpp"
#include "io/saved_parts.hpp"

namespace matchbox_slam {
namespace {

constexpr std::size_t kMostPoints = 100'000;      // more than a laser has
constexpr std::size_t kMostKeyScans = 1'000'000;  // of 300 km
constexpr std::size_t kMostAngles = 10'000;       // that bound masked sectors
constexpr double kLongestNormal = 1.0 + 1e-6;     // rounded
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// An option, which is held to what is allowed.
template <typename Archive, typename Value>
void transfer_option(Archive& archive, Value& value, const char* name, const Allowed& allowed) {
  if constexpr (std::is_same_v<std::decay_t<Value>, bool>) {
    archive.flag(value);
  } else if constexpr (std::is_same_v<std::decay_t<Value>, double>) {
    archive.number(value);
    if constexpr (Archive::kReads) {
      check_limits(value, name, allowed, archive);
    }
  } else {
    archive.size(value, 8, kMostAngles, name);
    for (auto& element : value) {
      transfer_option(archive, element, name, allowed);
    }
  }
}

template <typename Archive, typename Pose>
void transfer_laser(Archive& archive, Pose& pose) {
  for (Eigen::Index i = 0; i < 12; ++i) {
    archive.number(pose.matrix()(i % 3, i / 3));
  }
}

/// What is seen in an image its stamp tells.
template <typename Archive, typename Measured>
void transfer_measured(Archive& archive, Measured& measured) {
  constexpr double kLargestFloat = 3.5e38;
  auto& scan = measured.scan;
  archive.number(scan.stamp, kLargest);
  if constexpr (Archive::kReads) {
    measured.is_of_image = is_image_stamp(scan.stamp);
  }
  for (auto* value : {&scan.angle_min, &scan.angle_increment, &scan.time_increment}) {
    archive.number(*value, kLargestFloat);
  }
  archive.number(scan.range_min, kInfinity);
  archive.number(scan.range_max, kInfinity);
  archive.size(scan.ranges, 4, kMostPoints, "ranges in a key scan");
  for (auto& range : scan.ranges) {  // of any bits, as a laser sends them
    archive.template image<std::uint32_t>(range);
  }
  transfer_laser(archive, measured.base_from_laser);
  transfer_pose(archive, measured.motion);
  ProjectionOptions::visit(
      measured.options,
      [&](auto& value, const char* name, const Allowed& allowed, const char* /*unit*/,
          const char* /*meaning*/) { transfer_option(archive, value, name, allowed); });
  transfer_laser(archive, measured.laser_motion);
  if constexpr (Archive::kReads) {
    if (!measured.laser_motion.linear().isUnitary(1e-3)) {
      archive.fail("is damaged: what a laser turned in a scan is no rotation");
    }
  }
}

template <typename Archive, typename Scan>
void transfer_points(Archive& archive, Scan& scan) {
  archive.number(scan.stamp, kLargest);
  archive.size(scan.points, 65, kMostPoints, "points in a key scan");
  for (auto& point : scan.points) {
    transfer_vector(archive, point.position);
    transfer_vector(archive, point.origin);
    transfer_vector(archive, point.normal, kLongestNormal);
    archive.number(point.weight);
    if constexpr (Archive::kReads) {
      if (point.weight < 0.0) {
        archive.fail("is damaged: a point weighs " + to_string(point.weight));
      }
    }
    archive.flag(point.joined_to_next);
    archive.number(point.moved);
  }
  archive.size(scan.free_rays, 32, kMostPoints, "free rays in a key scan");
  for (auto& ray : scan.free_rays) {
    transfer_vector(archive, ray.origin);
    transfer_vector(archive, ray.end);
  }
}

}  // namespace

void write_key_scans(const KeyScans& key_scans, MapWriter& writer) {
  writer.integer(std::uint64_t{key_scans.size()});
  for (const PlacedScan& key : key_scans.all()) {
    transfer_pose(writer, key.map_from_base);
    writer.integer(std::int32_t{key.scan->laser()});
    const std::optional<MeasuredScan> measured = key.scan->measured();
    writer.flag(measured.has_value());
    if (measured) {
      transfer_measured(writer, *measured);
    } else {
      transfer_points(writer, *key.scan->points());
    }
  }
}

KeyScans read_key_scans(MapReader& reader) {
  KeyScans key_scans;
  for (std::size_t left = reader.count(53, kMostKeyScans, "key scans"); left > 0; --left) {
    Pose2 map_from_base;
    std::int32_t laser = 0;
    bool is_measured = false;
    transfer_pose(reader, map_from_base);
    reader.integer(laser);
    reader.flag(is_measured);
    if (is_measured) {
      MeasuredScan measured;
      transfer_measured(reader, measured);
      key_scans.add(std::move(measured), laser, map_from_base);
    } else {
      PointScan points;
      transfer_points(reader, points);
      key_scans.add(std::move(points), laser, map_from_base);
    }
  }
  return key_scans;
}

void write_last_inserted(const std::map<int, Pose2>& last_inserted, MapWriter& writer) {
  writer.integer(std::uint64_t{last_inserted.size()});
  for (const auto& [laser, map_from_base] : last_inserted) {
    writer.integer(std::int32_t{laser});
    transfer_pose(writer, map_from_base);
  }
}

std::map<int, Pose2> read_last_inserted(MapReader& reader) {
  std::map<int, Pose2> last_inserted;
  for (std::size_t left = reader.count(28, kMostLasers, "lasers"); left > 0; --left) {
    int laser = 0;
    reader.integer(laser);
    transfer_pose(reader, last_inserted[laser]);
  }
  return last_inserted;
}

}  // namespace matchbox_slam
