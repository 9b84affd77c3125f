#include "matchbox_slam/io/saved_map.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

#include "io/gzip.hpp"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/matching/scan_matcher.hpp"

namespace matchbox_slam {
namespace {

const std::string kHead = "matchbox_slam map, version ";
const std::string kVersion1 = kHead + "1\n";
const std::string kVersion2 = kHead + "2\n";

// A cell farther away than any scan of a robot: the file is damaged.
constexpr std::int32_t kFarthestCell = 1 << 24;

// As of messages: farther than around the Earth [m], more readings than a laser has.
constexpr double kFarthest = 1e8;
constexpr std::size_t kMostPoints = 100'000;

constexpr double kLongestNormal = 1.0 + 1e-6;  // rounded

// Stamps [s] and covariances [m^2].
constexpr double kLargest = kFarthest * kFarthest;

constexpr double kMostReachCells = 120.0;         // as LikelihoodField allows
constexpr std::size_t kMostKeyScans = 1'000'000;  // of 300 km
constexpr std::size_t kMostAngles = 10'000;       // that bound masked sectors
constexpr std::size_t kMostLasers = 1000;
constexpr double kLeastInterval = 1e-9;  // [s] between stamps of messages
constexpr double kInfinity = std::numeric_limits<double>::infinity();

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

  void flag(bool value) { integer(std::uint8_t{value}); }

  void count(std::size_t items) { integer(std::uint64_t{items}); }

  void pose(const Pose2& pose) {
    number(pose.x);
    number(pose.y);
    number(pose.theta);
  }

  void matrix(const Eigen::Matrix3d& matrix) {
    for (Eigen::Index i = 0; i < matrix.size(); ++i) {
      number(matrix(i));
    }
  }

  std::string bytes;
};

class Reader {
 public:
  Reader(const std::string& bytes, const std::string& path, double max_cells)
      : bytes_(bytes), path_(path), max_cells_(max_cells) {}

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

  /// One that is at most as large as this, with either sign.
  double number(double largest = kFarthest) {
    const auto image = integer<std::uint64_t>();
    double value = 0.0;
    std::memcpy(&value, &image, sizeof value);
    if (!(std::abs(value) <= largest)) {
      fail("is damaged: it holds the number " + to_string(value) + " where at most " +
           to_string(largest) + " is allowed");
    }
    return value;
  }

  Eigen::Vector2d numbers(double largest = kFarthest) {
    const double x = number(largest);
    return {x, number(largest)};
  }

  Pose2 pose() {
    const double x = number();
    const double y = number();
    return {x, y, number()};
  }

  bool flag() { return integer<std::uint8_t>() != 0; }

  Eigen::Matrix3d matrix() {
    Eigen::Matrix3d matrix;
    for (Eigen::Index i = 0; i < matrix.size(); ++i) {
      matrix(i) = number(kLargest);
    }
    return matrix;
  }

  Eigen::Matrix3d covariance() {
    const Eigen::Matrix3d matrix = this->matrix();
    if (!is_covariance(matrix)) {
      fail("is damaged: the covariance of its pose is none");
    }
    return matrix;
  }

  Cell cell() {
    const auto x = integer<std::int32_t>();
    const auto y = integer<std::int32_t>();
    // The lowest integer has no absolute value.
    if (std::min(x, y) < -kFarthestCell || std::max(x, y) > kFarthestCell) {
      fail("is damaged: a cell lies at " + std::to_string(x) + ", " + std::to_string(y));
    }
    include({x, y});
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

  /// The same, of which there are at most so many.
  std::size_t count(std::size_t bytes_each, std::size_t most, const std::string& name) {
    const std::size_t number = count(bytes_each);
    if (number > most) {
      fail("is damaged: it has " + std::to_string(number) + " " + name + "; allowed: up to " +
           std::to_string(most));
    }
    return number;
  }

  [[nodiscard]] bool at_end() const { return position_ == bytes_.size(); }

 private:
  void require(std::size_t count) const {
    if (bytes_.size() - position_ < count) {
      fail("is cut off");
    }
  }

  /// Before the cell is stored: all memory goes by the rectangle around the cells, in whole tiles.
  void include(const Cell& cell) {
    constexpr int kTileMargin = OccupancyGrid::Tiles::kTileSize - 1;
    const CellBox before = box_.empty() ? CellBox{cell, cell} : box_;
    box_.min = {std::min(before.min.x, cell.x), std::min(before.min.y, cell.y)};
    box_.max = {std::max(before.max.x, cell.x + 1), std::max(before.max.y, cell.y + 1)};
    const double cells = (box_.width() + double{kTileMargin}) * (box_.height() + kTileMargin);
    if (cells > max_cells_) {
      fail("is damaged, or its map is too large: its cells span " + std::to_string(box_.width()) +
           " x " + std::to_string(box_.height()) + " or more; allowed: " + to_string(max_cells_) +
           " in all; if it is as large as that, set map/max_cells higher");
    }
  }

  const std::string& bytes_;
  const std::string& path_;
  double max_cells_;
  std::size_t position_ = 0;
  CellBox box_;  ///< around all cells so far
};

/// What the options of a map may be holds for a file, too.
void check_limits(double value, const char* name, const Allowed& allowed, const Reader& reader) {
  if (!(value >= allowed.low && value <= allowed.high)) {
    reader.fail(std::string("is damaged: its ") + name + " is " + to_string(value) +
                "; allowed: " + allowed.text());
  }
}

template <typename Options>
void check_limits(const Options& options, const Reader& reader) {
  Options::visit(options, [&reader](double value, const char* name, const Allowed& allowed,
                                    const char* /*unit*/, const char* /*meaning*/) {
    check_limits(value, name, allowed, reader);
  });
}

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
  check_limits(map_options, reader);
  check_limits(field_options, reader);
  if (field_options.reach / map_options.resolution > kMostReachCells) {
    reader.fail("is damaged: its reach is " + to_string(field_options.reach) + " m with cells of " +
                to_string(map_options.resolution) + " m; allowed: at most 120 cells");
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

// --- key scans ---

/// Writes options one after another, in the order of their rows.
class OptionWriter {
 public:
  explicit OptionWriter(Writer& writer) : writer_(writer) {}

  void operator()(double value, const char* /*name*/, const Allowed& /*allowed*/,
                  const char* /*unit*/, const char* /*meaning*/) {
    writer_.number(value);
  }
  void operator()(bool value, const char* /*name*/, const Allowed& /*allowed*/,
                  const char* /*unit*/, const char* /*meaning*/) {
    writer_.flag(value);
  }
  void operator()(const std::vector<double>& values, const char* /*name*/,
                  const Allowed& /*allowed*/, const char* /*unit*/, const char* /*meaning*/) {
    writer_.count(values.size());
    for (const double value : values) {
      writer_.number(value);
    }
  }

 private:
  Writer& writer_;
};

/// Reads them again, and holds them to what is allowed.
class OptionReader {
 public:
  explicit OptionReader(Reader& reader) : reader_(reader) {}

  void operator()(double& value, const char* name, const Allowed& allowed, const char* /*unit*/,
                  const char* /*meaning*/) {
    value = reader_.number();
    check_limits(value, name, allowed, reader_);
  }
  void operator()(bool& value, const char* /*name*/, const Allowed& /*allowed*/,
                  const char* /*unit*/, const char* /*meaning*/) {
    value = reader_.flag();
  }
  void operator()(std::vector<double>& values, const char* name, const Allowed& allowed,
                  const char* unit, const char* meaning) {
    values.resize(reader_.count(8, kMostAngles, name));
    for (double& value : values) {
      (*this)(value, name, allowed, unit, meaning);
    }
  }

 private:
  Reader& reader_;
};

void write_measured(const MeasuredScan& measured, Writer& writer) {
  const LaserScan& scan = measured.scan;
  for (const double value : {scan.stamp, scan.angle_min, scan.angle_increment, scan.time_increment,
                             scan.range_min, scan.range_max}) {
    writer.number(value);
  }
  writer.count(scan.ranges.size());
  for (const float range : scan.ranges) {
    std::uint32_t image = 0;
    std::memcpy(&image, &range, sizeof image);
    writer.integer(image);
  }
  for (Eigen::Index i = 0; i < 12; ++i) {
    writer.number(measured.base_from_laser.matrix()(i % 3, i / 3));
  }
  writer.pose(measured.motion);
  ProjectionOptions::visit(measured.options, OptionWriter(writer));
}

MeasuredScan read_measured(Reader& reader) {
  constexpr double kLargestFloat = 3.5e38;
  MeasuredScan measured;
  LaserScan& scan = measured.scan;
  scan.stamp = reader.number(kLargest);
  for (double* value : {&scan.angle_min, &scan.angle_increment, &scan.time_increment}) {
    *value = reader.number(kLargestFloat);
  }
  scan.range_min = reader.number(kInfinity);
  scan.range_max = reader.number(kInfinity);
  scan.ranges.resize(reader.count(4, kMostPoints, "ranges in a key scan"));
  for (float& range : scan.ranges) {  // of any bits, as a laser sends them
    const auto image = reader.integer<std::uint32_t>();
    std::memcpy(&range, &image, sizeof range);
  }
  for (Eigen::Index i = 0; i < 12; ++i) {
    measured.base_from_laser.matrix()(i % 3, i / 3) = reader.number();
  }
  measured.motion = reader.pose();
  ProjectionOptions::visit(measured.options, OptionReader(reader));
  return measured;
}

void write_points(const PointScan& scan, Writer& writer) {
  writer.number(scan.stamp);
  writer.count(scan.points.size());
  for (const ScanPoint& point : scan.points) {
    writer.numbers(point.position);
    writer.numbers(point.origin);
    writer.numbers(point.normal);
    writer.number(point.weight);
    writer.flag(point.joined_to_next);
    writer.number(point.moved);
  }
  writer.count(scan.free_rays.size());
  for (const FreeRay& ray : scan.free_rays) {
    writer.numbers(ray.origin);
    writer.numbers(ray.end);
  }
}

/// Version 1 has no `moved` and no free rays.
PointScan read_points(bool version_1, Reader& reader) {
  PointScan scan;
  scan.stamp = reader.number(kLargest);
  scan.points.resize(reader.count(version_1 ? 57 : 65, kMostPoints, "points in a key scan"));
  for (ScanPoint& point : scan.points) {
    point.position = reader.numbers();
    point.origin = reader.numbers();
    point.normal = reader.numbers(kLongestNormal);
    point.weight = reader.number();
    if (point.weight < 0.0) {
      reader.fail("is damaged: a point weighs " + to_string(point.weight));
    }
    point.joined_to_next = reader.flag();
    point.moved = version_1 ? 0.0 : reader.number();
  }
  scan.free_rays.resize(version_1 ? 0 : reader.count(32, kMostPoints, "free rays in a key scan"));
  for (FreeRay& ray : scan.free_rays) {
    ray.origin = reader.numbers();
    ray.end = reader.numbers();
  }
  return scan;
}

void write_key_scans(const KeyScans& key_scans, Writer& writer) {
  writer.count(key_scans.size());
  for (const PlacedScan& key : key_scans.all()) {
    writer.pose(key.map_from_base);
    writer.integer(std::int32_t{key.scan->laser()});
    const MeasuredScan* measured = key.scan->measured();
    writer.flag(measured != nullptr);
    if (measured != nullptr) {
      write_measured(*measured, writer);
    } else {
      write_points(*key.scan->points(), writer);
    }
  }
}

KeyScans read_key_scans(bool version_1, Reader& reader) {
  KeyScans key_scans;
  for (std::size_t left = reader.count(40, kMostKeyScans, "key scans"); left > 0; --left) {
    const Pose2 map_from_base = reader.pose();
    const int laser = version_1 ? 0 : reader.integer<std::int32_t>();
    if (!version_1 && reader.flag()) {
      key_scans.add(read_measured(reader), laser, map_from_base);
    } else {
      key_scans.add(read_points(version_1, reader), laser, map_from_base);
    }
  }
  return key_scans;
}

// --- the engine's motion ---

void write_motion(const MotionState& motion, Writer& writer) {
  writer.pose(motion.fixed_from_base);
  writer.matrix(motion.covariance);
  writer.matrix(motion.by_velocity);
  writer.flag(motion.stamp.has_value());
  writer.number(motion.stamp.value_or(0.0));
  writer.integer(std::int32_t{motion.laser});
  writer.flag(motion.matched);
  writer.flag(motion.odom_from_base.has_value());
  writer.pose(motion.odom_from_base.value_or(Pose2{}));
  writer.flag(motion.fix.has_value());
  const MotionState::Fix fix = motion.fix.value_or(MotionState::Fix{});
  writer.number(fix.stamp);
  writer.pose(fix.fixed_from_base);
  writer.pose(motion.motion);
  writer.number(motion.interval);
}

MotionState read_motion(Reader& reader) {
  MotionState motion;
  motion.fixed_from_base = reader.pose();
  motion.covariance = reader.covariance();
  motion.by_velocity = reader.matrix();
  const bool has_stamp = reader.flag();
  motion.stamp = reader.number(kLargest);
  motion.laser = reader.integer<std::int32_t>();
  motion.matched = reader.flag();
  const bool has_odometry = reader.flag();
  motion.odom_from_base = reader.pose();
  const bool has_fix = reader.flag();
  const double fix_stamp = reader.number(kLargest);
  motion.fix = MotionState::Fix{fix_stamp, reader.pose()};
  motion.motion = reader.pose();
  motion.interval = reader.number();
  if (!has_stamp) {
    motion.stamp.reset();
  }
  if (!has_odometry) {
    motion.odom_from_base.reset();
  }
  if (!has_fix) {
    motion.fix.reset();
  }
  if (motion.interval != 0.0 && !(motion.interval >= kLeastInterval)) {
    reader.fail("is damaged: its last motion took " + to_string(motion.interval) + " s");
  }
  return motion;
}

}  // namespace

std::string to_saved_map(const MapStart& map) {
  Writer writer;
  writer.bytes = kVersion2;
  write_grids(map.map, writer);
  write_key_scans(map.key_scans, writer);
  write_motion(map.motion, writer);
  writer.count(map.last_inserted.size());
  for (const auto& [laser, map_from_base] : map.last_inserted) {
    writer.integer(std::int32_t{laser});
    writer.pose(map_from_base);
  }
  writer.integer(map.scan_count);
  return compress(writer.bytes);
}

MapStart read_saved_map(const std::string& path, double max_cells) {
  const std::string bytes = decompress(read_file(path), path);
  Reader reader(bytes, path, max_cells);
  const bool version_1 = bytes.compare(0, kVersion1.size(), kVersion1) == 0;
  if (!version_1 && bytes.compare(0, kVersion2.size(), kVersion2) != 0) {
    reader.fail("is no saved map that this version reads; it should begin with '" + kHead +
                "1' or '" + kHead + "2'");
  }
  reader.skip(kVersion2.size());
  MapStart start{read_grids(reader), {}, {}, {}, 0};
  start.key_scans = read_key_scans(version_1, reader);
  if (version_1) {
    start.motion.fixed_from_base = reader.pose();
    start.motion.covariance = reader.covariance();
  } else {
    start.motion = read_motion(reader);
    for (std::size_t left = reader.count(28, kMostLasers, "lasers"); left > 0; --left) {
      const auto laser = reader.integer<std::int32_t>();
      start.last_inserted[laser] = reader.pose();
    }
    start.scan_count = reader.integer<std::uint64_t>();
  }
  if (!reader.at_end()) {
    reader.fail("is damaged: it goes on after its end");
  }
  return start;
}

}  // namespace matchbox_slam
