#include "matchbox_slam/io/saved_map.hpp"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/gzip.hpp"

namespace matchbox_slam {
namespace {

const std::string kHead = "matchbox_slam map, version 1\n";

// A cell farther away than any scan of a robot: the file is damaged.
constexpr std::int32_t kFarthestCell = 1 << 24;

/// Numbers in the order of their bytes, the lowest first, on every machine.
class Writer {
 public:
  template <typename Integer>
  void integer(Integer value) {
    auto rest = static_cast<std::make_unsigned_t<Integer>>(value);
    for (std::size_t i = 0; i < sizeof(Integer); ++i) {
      bytes.push_back(static_cast<char>(rest & 0xFFU));
      rest = static_cast<std::make_unsigned_t<Integer>>(rest >> 8U);
    }
  }

  void number(double value) {
    std::uint64_t image = 0;
    std::memcpy(&image, &value, sizeof image);
    integer(image);
  }

  void numbers(const Eigen::Vector2d& values) {
    number(values.x());
    number(values.y());
  }

  void pose(const Pose2& pose) {
    number(pose.x);
    number(pose.y);
    number(pose.theta);
  }

  std::string bytes;
};

class Reader {
 public:
  Reader(const std::string& bytes, const std::string& path) : bytes_(bytes), path_(path) {}

  [[noreturn]] void fail(const std::string& text) const {
    throw FileError("'" + path_ + "' " + text);
  }

  void skip(std::size_t count) {
    require(count);
    position_ += count;
  }

  template <typename Integer>
  Integer integer() {
    require(sizeof(Integer));
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < sizeof(Integer); ++i) {
      value |= std::uint64_t{static_cast<unsigned char>(bytes_[position_ + i])} << 8U * i;
    }
    position_ += sizeof(Integer);
    return static_cast<Integer>(value);
  }

  double number() {
    const auto image = integer<std::uint64_t>();
    double value = 0.0;
    std::memcpy(&value, &image, sizeof value);
    if (!std::isfinite(value)) {
      fail("is damaged: it holds a number that is none");
    }
    return value;
  }

  Eigen::Vector2d numbers() {
    const double x = number();
    return {x, number()};
  }

  Pose2 pose() {
    const double x = number();
    const double y = number();
    return {x, y, number()};
  }

  Cell cell() {
    const auto x = integer<std::int32_t>();
    const auto y = integer<std::int32_t>();
    if (std::abs(x) > kFarthestCell || std::abs(y) > kFarthestCell) {
      fail("is damaged: a cell lies at " + std::to_string(x) + ", " + std::to_string(y));
    }
    return {x, y};
  }

  /// How many items of at least `bytes_each` follow.
  std::size_t count(std::size_t bytes_each) {
    const auto number = integer<std::uint64_t>();
    if (number > (bytes_.size() - position_) / bytes_each) {
      fail("is damaged: it announces more than it holds");
    }
    return static_cast<std::size_t>(number);
  }

  [[nodiscard]] bool at_end() const { return position_ == bytes_.size(); }

 private:
  void require(std::size_t count) const {
    if (bytes_.size() - position_ < count) {
      fail("is cut off");
    }
  }

  const std::string& bytes_;
  const std::string& path_;
  std::size_t position_ = 0;
};

std::vector<Cell> known_cells(const OccupancyGrid& grid) {
  const CellBox bounds = grid.known_bounds();
  std::vector<Cell> cells;
  for (int y = bounds.min.y; y < bounds.max.y; ++y) {
    for (int x = bounds.min.x; x < bounds.max.x; ++x) {
      if (grid.is_known({x, y})) {
        cells.push_back({x, y});
      }
    }
  }
  return cells;
}

void write_cell(const Cell& cell, Writer& writer) {
  writer.integer(static_cast<std::int32_t>(cell.x));
  writer.integer(static_cast<std::int32_t>(cell.y));
}

void write_grids(const SlamMap& map, Writer& writer) {
  writer.number(map.field.geometry().resolution());
  writer.number(map.field.options().sigma);
  writer.number(map.field.options().reach);
  const std::vector<Cell> known = known_cells(map.occupancy);
  writer.integer(std::uint64_t{known.size()});
  for (const Cell& cell : known) {
    write_cell(cell, writer);
    writer.integer(map.occupancy.stored(cell));
  }
  const std::vector<Cell> walls = map.field.surface_cells();
  writer.integer(std::uint64_t{walls.size()});
  for (const Cell& cell : walls) {
    write_cell(cell, writer);
    const LikelihoodField::StoredSurface& surface = map.field.stored_surface(cell);
    writer.integer(surface.hits);
    for (const std::int16_t value :
         {surface.offset_x, surface.offset_y, surface.mean_double_angle_x,
          surface.mean_double_angle_y, surface.double_angle_x, surface.double_angle_y}) {
      writer.integer(value);
    }
  }
}

SlamMap read_grids(Reader& reader) {
  MapOptions map_options;
  LikelihoodFieldOptions field_options;
  map_options.resolution = reader.number();
  field_options.sigma = reader.number();
  field_options.reach = reader.number();
  if (!(map_options.resolution >= 0.005 && field_options.sigma > 0.0 && field_options.reach > 0.0 &&
        field_options.reach <= 120.0 * map_options.resolution)) {
    reader.fail("is damaged: its resolution is " + std::to_string(map_options.resolution) + " m");
  }
  SlamMap map(map_options, field_options);
  for (std::size_t left = reader.count(10); left > 0; --left) {
    const Cell cell = reader.cell();
    map.occupancy.restore(cell, reader.integer<OccupancyGrid::Stored>());
  }
  std::vector<std::pair<Cell, LikelihoodField::StoredSurface>> walls(reader.count(22));
  for (auto& [cell, surface] : walls) {
    cell = reader.cell();
    surface.hits = reader.integer<std::uint16_t>();
    for (std::int16_t* value :
         {&surface.offset_x, &surface.offset_y, &surface.mean_double_angle_x,
          &surface.mean_double_angle_y, &surface.double_angle_x, &surface.double_angle_y}) {
      *value = reader.integer<std::int16_t>();
    }
  }
  map.field.restore(walls);
  return map;
}

void write_key_scan(const KeyScan& key, Writer& writer) {
  writer.pose(key.map_from_base);
  writer.number(key.scan.stamp);
  writer.integer(std::uint64_t{key.scan.points.size()});
  for (const ScanPoint& point : key.scan.points) {
    writer.numbers(point.position);
    writer.numbers(point.origin);
    writer.numbers(point.normal);
    writer.number(point.weight);
    writer.integer(std::uint8_t{point.joined_to_next});
  }
}

std::shared_ptr<const KeyScan> read_key_scan(Reader& reader) {
  const Pose2 map_from_base = reader.pose();
  PointScan scan;
  scan.stamp = reader.number();
  scan.points.resize(reader.count(57));
  for (ScanPoint& point : scan.points) {
    point.position = reader.numbers();
    point.origin = reader.numbers();
    point.normal = reader.numbers();
    point.weight = reader.number();
    point.joined_to_next = reader.integer<std::uint8_t>() != 0;
  }
  return std::make_shared<const KeyScan>(std::move(scan), map_from_base);
}

}  // namespace

std::string to_saved_map(const MapStart& map) {
  Writer writer;
  writer.bytes = kHead;
  write_grids(map.map, writer);
  writer.integer(std::uint64_t{map.key_scans.size()});
  for (const std::shared_ptr<const KeyScan>& key : map.key_scans) {
    write_key_scan(*key, writer);
  }
  writer.pose(map.map_from_base);
  for (Eigen::Index i = 0; i < 9; ++i) {
    writer.number(map.covariance(i));
  }
  return compress(writer.bytes);
}

MapStart read_saved_map(const std::string& path) {
  const std::string bytes = decompress(read_file(path), path);
  Reader reader(bytes, path);
  if (bytes.compare(0, kHead.size(), kHead) != 0) {
    reader.fail("is no saved map that this version reads; it should begin with '" +
                kHead.substr(0, kHead.size() - 1) + "'");
  }
  reader.skip(kHead.size());
  MapStart start{read_grids(reader), {}, {}};
  for (std::size_t left = reader.count(40); left > 0; --left) {
    start.key_scans.push_back(read_key_scan(reader));
  }
  start.map_from_base = reader.pose();
  for (Eigen::Index i = 0; i < 9; ++i) {
    start.covariance(i) = reader.number();
  }
  if (!reader.at_end()) {
    reader.fail("is damaged: it goes on after its end");
  }
  return start;
}

}  // namespace matchbox_slam
