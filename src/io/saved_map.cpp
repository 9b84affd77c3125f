#include "matchbox_slam/io/saved_map.hpp"

#include <fmt/core.h>

#include "io/gzip.hpp"
#include "io/map_changes.hpp"
#include "io/saved_parts.hpp"

namespace matchbox_slam {
namespace {

const std::string kHead = "matchbox_slam map, version ";
std::string head_of(int version) { return fmt::format("{}{}\n", kHead, version); }
constexpr double kMostMissing = 1.0;     // of what odometry tells
constexpr double kLeastInterval = 1e-9;  // [s] between stamps of messages

/// What may be missing: whether it is there, then its value or a default one.
template <typename Archive, typename Optional, typename Transfer>
void transfer_optional(Archive& archive, Optional& optional, const Transfer& transfer) {
  bool has_value = optional.has_value();
  auto value = optional.value_or(typename Optional::value_type{});
  archive.flag(has_value);
  transfer(archive, value);
  if constexpr (Archive::kReads) {
    optional.reset();
    if (has_value) {
      optional = value;
    }
  }
}

template <typename Archive, typename Scale>
void transfer_noise_scale(Archive& archive, Scale& scale) {
  for (auto* share : {&scale.translation, &scale.rotation}) {
    archive.number(*share);
    if constexpr (Archive::kReads) {
      if (!(*share > 0.0 && *share <= 1.0)) {
        archive.fail(
            fmt::format("is damaged: the errors of odometry are {} of what the options say",
                        to_string(*share)));
      }
    }
  }
}

template <typename Archive, typename Calibration>
void transfer_calibration(Archive& archive, Calibration& calibration) {
  for (int i = 0; i < 3; ++i) {
    archive.number(calibration.missing[i], kMostMissing);
  }
  transfer_covariance(archive, "what odometry misses", calibration.covariance);
  for (int i = 0; i < 2; ++i) {
    archive.number(calibration.noise[i]);
    if constexpr (Archive::kReads) {
      if (!(calibration.noise[i] > 0.0)) {
        archive.fail("is damaged: the noise of odometry is " + to_string(calibration.noise[i]));
      }
    }
  }
  transfer_optional(archive, calibration.stretch,
                    [](Archive& to, OdometryCalibration::Stretch& stretch) {
                      to.number(stretch.stamp, kLargest);
                      transfer_pose(to, stretch.fixed_from_first);
                      transfer_pose(to, stretch.first_from_newest);
                      to.number(stretch.forward);
                      to.number(stretch.turn);
                      to.number(stretch.length);
                    });
}

template <typename Archive, typename Motion>
void transfer_motion(Archive& archive, Motion& motion) {
  transfer_pose(archive, motion.fixed_from_base);
  transfer_covariance(archive, "its pose", motion.covariance);
  transfer_matrix(archive, motion.by_velocity);
  transfer_optional(archive, motion.stamp,
                    [](Archive& to, double& stamp) { to.number(stamp, kLargest); });
  archive.integer(motion.laser);
  archive.flag(motion.matched);
  transfer_optional(archive, motion.odom_from_base,
                    [](Archive& to, Pose2& pose) { transfer_pose(to, pose); });
  transfer_optional(archive, motion.fix, [](Archive& to, MotionState::Fix& fix) {
    to.number(fix.stamp, kLargest);
    transfer_pose(to, fix.fixed_from_base);
  });
  transfer_pose(archive, motion.motion);
  archive.number(motion.interval);
  if constexpr (Archive::kReads) {
    if (motion.interval != 0.0 && !(motion.interval >= kLeastInterval)) {
      archive.fail(
          fmt::format("is damaged: its last motion took {} s", to_string(motion.interval)));
    }
  }
  transfer_noise_scale(archive, motion.noise_scale);
  if (!archive.is_of_1_0()) {  // which learned no systematic errors of odometry
    transfer_calibration(archive, motion.calibration);
  }
}

/// What its head says, where that is a number above 0; else 0.
int version_of(const std::string& bytes) {
  if (bytes.compare(0, kHead.size(), kHead) != 0) {
    return 0;
  }
  const std::size_t end = bytes.find('\n');
  if (end == std::string::npos) {
    return 0;  // cut off, maybe within the number
  }
  const std::string version = bytes.substr(kHead.size(), end - kHead.size());
  const bool is_number = !version.empty() && version.size() < 10 &&
                         version.find_first_not_of("0123456789") == std::string::npos;
  return is_number ? std::stoi(version) : 0;
}

/// Nothing is wrong with a map of another version, so that it is refused, but not as damaged.
void read_head(const std::string& bytes, MapReader& reader) {
  for (const int version : {kSavedVersion, kVersionOfRelease1}) {
    if (reader.begins_with_version(version, head_of(version))) {
      return;
    }
  }
  const int version = version_of(bytes);
  if (version == 0 || version == kVersionOfRelease1 || version == kSavedVersion) {
    reader.fail(fmt::format(
        "is no saved map that this version reads; it should begin with '{}' and {} or {}", kHead,
        kVersionOfRelease1, kSavedVersion));
  }
  reader.refuse(fmt::format(
      "is a saved map of version {}; this program reads {}, as of 1.0, and {}: {}", version,
      kVersionOfRelease1, kSavedVersion,
      version > kSavedVersion ? "use the newer one that has saved it"
                              : "map the recording again, or use the commit that has saved it"));
}

}  // namespace

void write_map_bytes(const EngineState& map, const ByteSink& sink) {
  MapWriter writer(sink);
  writer.text(head_of(kSavedVersion));
  write_grids(map.map, writer);
  write_key_scans(map.key_scans, writer);
  transfer_motion(writer, map.motion);
  write_last_inserted(map.last_inserted, writer);
  writer.integer(map.scan_count);
  write_localization(map.localization, writer);
  write_loops(map, writer);
  write_secondary_lasers(map.secondary_lasers, writer);
  writer.finish();
}

void write_saved_map(const EngineState& map, const ByteSink& sink) {
  Compressor compressor(sink);
  write_map_bytes(map, [&compressor](const std::string& bytes) { compressor.add(bytes); });
  compressor.finish();
}

std::string to_saved_map(const EngineState& map) {
  std::string saved;
  write_saved_map(map, [&saved](const std::string& piece) { saved += piece; });
  return saved;
}

EngineState read_saved_map(const std::string& path, double max_cells) {
  const std::string bytes = with_changes(decompress(read_file(path), path), path);
  MapReader reader(bytes, path, max_cells);
  read_head(bytes, reader);
  EngineState start{read_grids(reader), {}, {}, {}, 0};
  start.key_scans = read_key_scans(reader);
  transfer_motion(reader, start.motion);
  start.last_inserted = read_last_inserted(reader);
  reader.integer(start.scan_count);
  start.localization = read_localization(start.key_scans, reader);
  read_loops(reader, start);
  start.secondary_lasers = read_secondary_lasers(reader);
  if (!reader.at_end()) {
    reader.fail("is damaged: it goes on after its end");
  }
  return start;
}

}  // namespace matchbox_slam
