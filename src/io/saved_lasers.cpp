#include <optional>
#include <utility>

#include "io/saved_parts.hpp"

namespace matchbox_slam {
namespace {

template <typename Archive, typename Sample>
void transfer_sample(Archive& archive, Sample& sample) {
  constexpr double kLargestSample = 1e3;  // [m], [m/s], [rad], [rad/s]
  for (Eigen::Index i = 0; i < 3; ++i) {
    archive.number(sample.error(i), kLargestSample);
    archive.number(sample.velocity(i), kLargestSample);
  }
  transfer_covariance(archive, "a laser's sample", sample.covariance);
}

template <typename Archive, typename Primary>
void transfer_primary(Archive& archive, Primary& primary) {
  archive.integer(primary.laser);
  archive.integer(primary.others);
  archive.number(primary.silent_since, kLargest);
}

}  // namespace

void write_secondary_lasers(const SecondaryLasers& lasers, MapWriter& writer) {
  transfer_primary(writer, lasers.primary());
  writer.integer(std::uint64_t{lasers.all().size()});
  for (const auto& [number, laser] : lasers.all()) {
    writer.integer(std::int32_t{number});
    writer.integer(std::uint64_t{laser.mount.samples().size()});
    for (const ExtrinsicSample& sample : laser.mount.samples()) {
      transfer_sample(writer, sample);
    }
    writer.flag(laser.is_used);
    transfer_pose(writer, laser.base_from_laser);
    writer.flag(laser.newest_from_tried.has_value());
    const Pose2 tried = laser.newest_from_tried.value_or(Pose2{});
    transfer_pose(writer, tried);
    KeyScans waiting;
    if (laser.waiting) {
      waiting.add(laser.waiting->measured, number, laser.waiting->there_from_base);
    }
    write_key_scans(waiting, writer);
  }
}

SecondaryLasers read_secondary_lasers(MapReader& reader) {
  SecondaryLasers::Primary primary;
  transfer_primary(reader, primary);
  std::map<int, SecondaryLaser> lasers;
  for (std::size_t left = reader.count(70, kMostLasers, "lasers"); left > 0; --left) {
    std::int32_t number = 0;
    reader.integer(number);
    SecondaryLaser& laser = lasers[number];
    std::vector<ExtrinsicSample> samples(
        reader.count(120, ExtrinsicCalibration::kMostSamples, "samples of a laser"));
    for (ExtrinsicSample& sample : samples) {
      transfer_sample(reader, sample);
    }
    laser.mount = ExtrinsicCalibration(std::move(samples));
    reader.flag(laser.is_used);
    transfer_pose(reader, laser.base_from_laser);
    bool is_tried = false;
    Pose2 newest_from_tried;
    reader.flag(is_tried);
    transfer_pose(reader, newest_from_tried);
    if (is_tried) {
      laser.newest_from_tried = newest_from_tried;
    }
    const KeyScans waiting = read_key_scans(reader);
    if (!waiting.empty()) {
      const PlacedScan& scan = waiting.all().front();
      std::optional<MeasuredScan> measured = scan.scan->measured();
      if (!measured) {
        reader.fail("is damaged: a laser's scan that waits was not measured");
      }
      laser.waiting = SecondaryScan{std::move(*measured), scan.map_from_base};
    }
  }
  return {std::move(lasers), primary};
}

}  // namespace matchbox_slam
