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

// What is written and what is read are one function each, given a Writer and something constant or
// a Reader and something to fill.

/// Numbers in the order of their bytes, the lowest first, on every machine.
class Writer {
 public:
  static constexpr bool kReads = false;

  template <typename Integer>
  void integer(Integer value) {
    auto rest = static_cast<std::make_unsigned_t<Integer>>(value);
    for (std::size_t i = 0; i < sizeof(Integer); ++i) {
      bytes.push_back(static_cast<char>(rest & 0xFFU));
      rest = static_cast<std::make_unsigned_t<Integer>>(rest >> 8U);
    }
  }

  /// The bits of a number.
  template <typename Integer, typename Number>
  void image(Number value) {
    Integer image = 0;
    std::memcpy(&image, &value, sizeof image);
    integer(image);
  }

  void number(double value, double /*largest*/ = 0.0) { image<std::uint64_t>(value); }
  void flag(bool value) { integer(std::uint8_t{value}); }

  template <typename Items>
  void size(const Items& items, std::size_t /*bytes_each*/, std::size_t /*most*/,
            const std::string& /*name*/) {
    integer(std::uint64_t{items.size()});
  }

  void cell(const Cell& cell) {
    integer(std::int32_t{cell.x});
    integer(std::int32_t{cell.y});
  }

  std::string bytes;
};

class Reader {
 public:
  static constexpr bool kReads = true;

  Reader(const std::string& bytes, const std::string& path, double max_cells)
      : bytes_(bytes), path_(path), max_cells_(max_cells) {}

  [[noreturn]] void fail(const std::string& text) const {
    throw FileError("'" + path_ + "' " + text);
  }

  [[nodiscard]] bool begins_with(const std::string& head) {
    const bool does = bytes_.compare(position_, head.size(), head) == 0;
    position_ += does ? head.size() : 0;
    return does;
  }

  template <typename Integer>
  void integer(Integer& value) {
    require(sizeof(Integer));
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < sizeof(Integer); ++i) {
      sum |= std::uint64_t{static_cast<unsigned char>(bytes_[position_ + i])} << 8U * i;
    }
    position_ += sizeof(Integer);
    value = static_cast<Integer>(sum);
  }

  template <typename Integer, typename Number>
  void image(Number& value) {
    Integer image = 0;
    integer(image);
    std::memcpy(&value, &image, sizeof value);
  }

  /// One that is at most as large as this, with either sign.
  void number(double& value, double largest = kFarthest) {
    image<std::uint64_t>(value);
    if (!(std::abs(value) <= largest)) {
      fail("is damaged: it holds the number " + to_string(value) + " where at most " +
           to_string(largest) + " is allowed");
    }
  }

  void flag(bool& value) {
    std::uint8_t byte = 0;
    integer(byte);
    value = byte != 0;
  }

  void cell(Cell& cell) {
    integer(cell.x);
    integer(cell.y);
    // The lowest integer has no absolute value.
    if (std::min(cell.x, cell.y) < -kFarthestCell || std::max(cell.x, cell.y) > kFarthestCell) {
      fail("is damaged: a cell lies at " + std::to_string(cell.x) + ", " + std::to_string(cell.y));
    }
    include(cell);
  }

  /// How many items of at least `bytes_each` follow.
  std::size_t count(std::size_t bytes_each, std::size_t most, const std::string& name) {
    std::uint64_t number = 0;
    integer(number);
    if (number > (bytes_.size() - position_) / bytes_each) {
      fail("is damaged: it announces more than it holds");
    }
    if (number > most) {
      fail("is damaged: it has " + std::to_string(number) + " " + name + "; allowed: up to " +
           std::to_string(most));
    }
    return static_cast<std::size_t>(number);
  }

  template <typename Items>
  void size(Items& items, std::size_t bytes_each, std::size_t most, const std::string& name) {
    items.resize(count(bytes_each, most, name));
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

template <typename Archive, typename Vector>
void transfer_vector(Archive& archive, Vector& vector, double largest = kFarthest) {
  archive.number(vector.x(), largest);
  archive.number(vector.y(), largest);
}

template <typename Archive, typename Pose>
void transfer_pose(Archive& archive, Pose& pose) {
  archive.number(pose.x);
  archive.number(pose.y);
  archive.number(pose.theta);
}

template <typename Archive, typename Matrix>
void transfer_matrix(Archive& archive, Matrix& matrix) {
  for (Eigen::Index i = 0; i < matrix.size(); ++i) {
    archive.number(matrix(i), kLargest);
  }
}

template <typename Archive, typename Matrix>
void transfer_covariance(Archive& archive, Matrix& matrix) {
  transfer_matrix(archive, matrix);
  if constexpr (Archive::kReads) {
    if (!is_covariance(matrix)) {
      archive.fail("is damaged: the covariance of its pose is none");
    }
  }
}

// --- grids ---

template <typename Archive, typename Surface>
void transfer_wall(Archive& archive, Surface& surface) {
  archive.integer(surface.hits);
  for (auto* value :
       {&surface.offset_x, &surface.offset_y, &surface.mean_double_angle_x,
        &surface.mean_double_angle_y, &surface.double_angle_x, &surface.double_angle_y}) {
    archive.integer(*value);
  }
}

void write_grids(const SlamMap& map, Writer& writer) {
  writer.number(map.field.geometry().resolution());
  writer.number(map.field.options().sigma);
  writer.number(map.field.options().reach);
  const std::vector<Cell> known = known_cells(map.occupancy);
  writer.integer(std::uint64_t{known.size()});
  for (const Cell& cell : known) {
    writer.cell(cell);
    writer.integer(map.occupancy.stored(cell));
  }
  const std::vector<Cell> walls = map.field.surface_cells();
  writer.integer(std::uint64_t{walls.size()});
  for (const Cell& cell : walls) {
    writer.cell(cell);
    transfer_wall(writer, map.field.stored_surface(cell));
  }
}

SlamMap read_grids(Reader& reader) {
  constexpr std::size_t kAnyCount = std::numeric_limits<std::size_t>::max();
  MapOptions map_options;
  LikelihoodFieldOptions field_options;
  for (double* value : {&map_options.resolution, &field_options.sigma, &field_options.reach}) {
    reader.number(*value);
  }
  check_limits(map_options, reader);
  check_limits(field_options, reader);
  if (field_options.reach / map_options.resolution > kMostReachCells) {
    reader.fail("is damaged: its reach is " + to_string(field_options.reach) + " m with cells of " +
                to_string(map_options.resolution) + " m; allowed: at most 120 cells");
  }
  SlamMap map(map_options, field_options);
  Cell cell;
  for (std::size_t left = reader.count(10, kAnyCount, "cells"); left > 0; --left) {
    reader.cell(cell);
    OccupancyGrid::Stored stored{};
    reader.integer(stored);
    map.occupancy.restore(cell, stored);
  }
  std::vector<std::pair<Cell, LikelihoodField::StoredSurface>> walls;
  reader.size(walls, 22, kAnyCount, "walls");
  for (auto& [wall, surface] : walls) {
    reader.cell(wall);
    transfer_wall(reader, surface);
  }
  map.field.restore(walls);
  return map;
}

// --- key scans ---

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

template <typename Archive, typename Measured>
void transfer_measured(Archive& archive, Measured& measured) {
  constexpr double kLargestFloat = 3.5e38;
  auto& scan = measured.scan;
  archive.number(scan.stamp, kLargest);
  for (auto* value : {&scan.angle_min, &scan.angle_increment, &scan.time_increment}) {
    archive.number(*value, kLargestFloat);
  }
  archive.number(scan.range_min, kInfinity);
  archive.number(scan.range_max, kInfinity);
  archive.size(scan.ranges, 4, kMostPoints, "ranges in a key scan");
  for (auto& range : scan.ranges) {  // of any bits, as a laser sends them
    archive.template image<std::uint32_t>(range);
  }
  for (Eigen::Index i = 0; i < 12; ++i) {
    archive.number(measured.base_from_laser.matrix()(i % 3, i / 3));
  }
  transfer_pose(archive, measured.motion);
  ProjectionOptions::visit(
      measured.options,
      [&](auto& value, const char* name, const Allowed& allowed, const char* /*unit*/,
          const char* /*meaning*/) { transfer_option(archive, value, name, allowed); });
}

/// Version 1 has no `moved` and no free rays.
template <typename Archive, typename Scan>
void transfer_points(Archive& archive, bool version_1, Scan& scan) {
  archive.number(scan.stamp, kLargest);
  archive.size(scan.points, version_1 ? 57 : 65, kMostPoints, "points in a key scan");
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
    if (!version_1) {
      archive.number(point.moved);
    }
  }
  if (!version_1) {
    archive.size(scan.free_rays, 32, kMostPoints, "free rays in a key scan");
    for (auto& ray : scan.free_rays) {
      transfer_vector(archive, ray.origin);
      transfer_vector(archive, ray.end);
    }
  }
}

void write_key_scans(const KeyScans& key_scans, Writer& writer) {
  writer.integer(std::uint64_t{key_scans.size()});
  for (const PlacedScan& key : key_scans.all()) {
    transfer_pose(writer, key.map_from_base);
    writer.integer(std::int32_t{key.scan->laser()});
    const MeasuredScan* measured = key.scan->measured();
    writer.flag(measured != nullptr);
    if (measured != nullptr) {
      transfer_measured(writer, *measured);
    } else {
      transfer_points(writer, false, *key.scan->points());
    }
  }
}

KeyScans read_key_scans(bool version_1, Reader& reader) {
  KeyScans key_scans;
  for (std::size_t left = reader.count(40, kMostKeyScans, "key scans"); left > 0; --left) {
    Pose2 map_from_base;
    std::int32_t laser = 0;
    bool is_measured = false;
    transfer_pose(reader, map_from_base);
    if (!version_1) {
      reader.integer(laser);
      reader.flag(is_measured);
    }
    if (is_measured) {
      MeasuredScan measured;
      transfer_measured(reader, measured);
      key_scans.add(std::move(measured), laser, map_from_base);
    } else {
      PointScan points;
      transfer_points(reader, version_1, points);
      key_scans.add(std::move(points), laser, map_from_base);
    }
  }
  return key_scans;
}

// --- the engine's motion ---

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

template <typename Archive, typename Motion>
void transfer_motion(Archive& archive, Motion& motion) {
  transfer_pose(archive, motion.fixed_from_base);
  transfer_covariance(archive, motion.covariance);
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
      archive.fail("is damaged: its last motion took " + to_string(motion.interval) + " s");
    }
  }
}

void write_last_inserted(const std::map<int, Pose2>& last_inserted, Writer& writer) {
  writer.integer(std::uint64_t{last_inserted.size()});
  for (const auto& [laser, map_from_base] : last_inserted) {
    writer.integer(std::int32_t{laser});
    transfer_pose(writer, map_from_base);
  }
}

std::map<int, Pose2> read_last_inserted(Reader& reader) {
  std::map<int, Pose2> last_inserted;
  for (std::size_t left = reader.count(28, kMostLasers, "lasers"); left > 0; --left) {
    int laser = 0;
    reader.integer(laser);
    transfer_pose(reader, last_inserted[laser]);
  }
  return last_inserted;
}

// --- where the robot is ---

/// The number of a part of the map, of which there are so many.
template <typename Archive, typename Part>
void transfer_part(Archive& archive, Part& part, std::size_t parts) {
  std::uint64_t number = part;
  archive.integer(number);
  if constexpr (Archive::kReads) {
    if (number >= parts) {
      archive.fail("is damaged: it names part " + std::to_string(number) + " of a map of " +
                   std::to_string(parts));
    }
    part = static_cast<std::size_t>(number);
  }
}

void write_waiting(const std::vector<WaitingScan>& waiting, Writer& writer) {
  KeyScans scans;
  for (const WaitingScan& scan : waiting) {
    scans.add(scan.scan);
  }
  write_key_scans(scans, writer);
  for (const WaitingScan& scan : waiting) {
    transfer_part(writer, scan.part, 0);
  }
}

std::vector<WaitingScan> read_waiting(std::size_t parts, Reader& reader) {
  const KeyScans scans = read_key_scans(false, reader);
  std::vector<WaitingScan> waiting;
  for (const PlacedScan& scan : scans.all()) {
    waiting.push_back({0, scan});
    transfer_part(reader, waiting.back().part, parts);
  }
  return waiting;
}

/// How many scans there were of some kind.
template <typename Archive, typename Count>
void transfer_count(Archive& archive, Count& count) {
  constexpr int kMost = 1 << 30;
  archive.integer(count);
  if constexpr (Archive::kReads) {
    if (count < 0 || count > kMost) {
      archive.fail("is damaged: it counts " + std::to_string(count) + " scans");
    }
  }
}

template <typename Archive, typename Doubt>
void transfer_doubt(Archive& archive, Doubt& doubt) {
  archive.flag(doubt.doubts);
  archive.flag(doubt.is_provisional);
  archive.number(doubt.since, kLargest);
  archive.number(doubt.way);
  transfer_count(archive, doubt.doubtful);
  transfer_count(archive, doubt.contradictions);
  transfer_count(archive, doubt.confirmations);
  transfer_pose(archive, doubt.map_from_base);
}

template <typename Archive, typename Search>
void transfer_search(Archive& archive, Search& search, std::size_t parts) {
  constexpr std::size_t kMostHypotheses = 1000;
  std::uint64_t next = search.next;
  archive.integer(next);
  archive.flag(search.complete);
  archive.number(search.stamp, kLargest);
  archive.size(search.hypotheses, 60, kMostHypotheses, "places where the robot may be");
  for (auto& hypothesis : search.hypotheses) {
    transfer_part(archive, hypothesis.part, parts);
    transfer_pose(archive, hypothesis.part_from_apart);
    transfer_count(archive, hypothesis.confirmations);
    transfer_pose(archive, hypothesis.apart_from_base);
  }
  if constexpr (Archive::kReads) {
    search.next = static_cast<std::size_t>(next);
  }
}

void write_whereabouts(const Whereabouts& whereabouts, Writer& writer) {
  const std::size_t parts = whereabouts.apart.size() + 1;
  writer.integer(std::uint64_t{whereabouts.apart.size()});
  for (const MapPart& part : whereabouts.apart) {
    write_grids(part.map, writer);
    write_key_scans(part.key_scans, writer);
    write_last_inserted(part.last_inserted, writer);
    writer.number(part.begin);
  }
  transfer_part(writer, whereabouts.here, parts);
  transfer_doubt(writer, whereabouts.doubt);
  writer.number(whereabouts.usual_score);
  write_waiting(whereabouts.held, writer);
  write_waiting(whereabouts.pending, writer);
  transfer_search(writer, whereabouts.search, parts);
}

Whereabouts read_whereabouts(Reader& reader) {
  constexpr std::size_t kMostApart = 10'000;
  Whereabouts whereabouts;
  for (std::size_t left = reader.count(60, kMostApart, "maps apart"); left > 0; --left) {
    MapPart part{read_grids(reader), read_key_scans(false, reader), read_last_inserted(reader), 0};
    reader.number(part.begin, kLargest);
    whereabouts.apart.push_back(std::move(part));
  }
  const std::size_t parts = whereabouts.apart.size() + 1;
  transfer_part(reader, whereabouts.here, parts);
  transfer_doubt(reader, whereabouts.doubt);
  reader.number(whereabouts.usual_score);
  whereabouts.held = read_waiting(parts, reader);
  whereabouts.pending = read_waiting(parts, reader);
  transfer_search(reader, whereabouts.search, parts);
  for (const PlaceHypothesis& hypothesis : whereabouts.search.hypotheses) {
    if (hypothesis.part == whereabouts.here) {
      reader.fail("is damaged: it looks for part " + std::to_string(whereabouts.here) +
                  " of the map in itself");
    }
  }
  return whereabouts;
}

}  // namespace

std::string to_saved_map(const MapStart& map) {
  Writer writer;
  writer.bytes = kVersion2;
  write_grids(map.map, writer);
  write_key_scans(map.key_scans, writer);
  transfer_motion(writer, map.motion);
  write_last_inserted(map.last_inserted, writer);
  writer.integer(map.scan_count);
  write_whereabouts(map.whereabouts, writer);
  return compress(writer.bytes);
}

MapStart read_saved_map(const std::string& path, double max_cells) {
  const std::string bytes = decompress(read_file(path), path);
  Reader reader(bytes, path, max_cells);
  const bool version_1 = reader.begins_with(kVersion1);
  if (!version_1 && !reader.begins_with(kVersion2)) {
    reader.fail("is no saved map that this version reads; it should begin with '" + kHead +
                "1' or '" + kHead + "2'");
  }
  MapStart start{read_grids(reader), {}, {}, {}, 0};
  start.key_scans = read_key_scans(version_1, reader);
  if (version_1) {
    transfer_pose(reader, start.motion.fixed_from_base);
    transfer_covariance(reader, start.motion.covariance);
  } else {
    transfer_motion(reader, start.motion);
    start.last_inserted = read_last_inserted(reader);
    reader.integer(start.scan_count);
    start.whereabouts = read_whereabouts(reader);
  }
  if (!reader.at_end()) {
    reader.fail("is damaged: it goes on after its end");
  }
  return start;
}

}  // namespace matchbox_slam
