#include "matchbox_slam/io/saved_map.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

#include "io/gzip.hpp"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/matching/scan_matcher.hpp"

namespace matchbox_slam {
namespace {

const std::string kHead = "matchbox_slam map, version 1\n";

// A cell farther away than any scan of a robot: the file is damaged.
constexpr std::int32_t kFarthestCell = 1 << 24;

// As of messages: farther than around the Earth [m], more readings than a laser has.
constexpr double kFarthest = 1e8;
constexpr std::size_t kMostPoints = 100'000;

constexpr double kLongestNormal = 1.0 + 1e-6;  // rounded

// Stamps [s] and covariances [m^2].
constexpr double kLargest = kFarthest * kFarthest;

constexpr double kMostReachCells = 120.0;  // as LikelihoodField allows

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
template <typename Options>
void check_limits(const Options& options, const Reader& reader) {
  Options::visit(options, [&reader](double value, const char* name, const Allowed& allowed,
                                    const char* /*unit*/, const char* /*meaning*/) {
    if (!(value >= allowed.low && value <= allowed.high)) {
      reader.fail(std::string("is damaged: its ") + name + " is " + to_string(value) +
                  "; allowed: " + allowed.text());
    }
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

void write_key_scan(const PlacedScan& key, Writer& writer) {
  const std::shared_ptr<const PointScan> scan = key.scan->points();
  writer.pose(key.map_from_base);
  writer.number(scan->stamp);
  writer.integer(std::uint64_t{scan->points.size()});
  for (const ScanPoint& point : scan->points) {
    writer.numbers(point.position);
    writer.numbers(point.origin);
    writer.numbers(point.normal);
    writer.number(point.weight);
    writer.integer(std::uint8_t{point.joined_to_next});
  }
}

void read_key_scan(Reader& reader, KeyScans& key_scans) {
  const Pose2 map_from_base = reader.pose();
  PointScan scan;
  scan.stamp = reader.number(kLargest);
  scan.points.resize(reader.count(57, kMostPoints, "points in a key scan"));
  for (ScanPoint& point : scan.points) {
    point.position = reader.numbers();
    point.origin = reader.numbers();
    point.normal = reader.numbers(kLongestNormal);
    point.weight = reader.number();
    if (point.weight < 0.0) {
      reader.fail("is damaged: a point weighs " + to_string(point.weight));
    }
    point.joined_to_next = reader.integer<std::uint8_t>() != 0;
  }
  key_scans.add(std::move(scan), 0, map_from_base);
}

}  // namespace

std::string to_saved_map(const MapStart& map) {
  Writer writer;
  writer.bytes = kHead;
  write_grids(map.map, writer);
  writer.integer(std::uint64_t{map.key_scans.size()});
  for (const PlacedScan& key : map.key_scans.all()) {
    write_key_scan(key, writer);
  }
  writer.pose(map.map_from_base);
  for (Eigen::Index i = 0; i < 9; ++i) {
    writer.number(map.covariance(i));
  }
  return compress(writer.bytes);
}

MapStart read_saved_map(const std::string& path, double max_cells) {
  const std::string bytes = decompress(read_file(path), path);
  Reader reader(bytes, path, max_cells);
  if (bytes.compare(0, kHead.size(), kHead) != 0) {
    reader.fail("is no saved map that this version reads; it should begin with '" +
                kHead.substr(0, kHead.size() - 1) + "'");
  }
  reader.skip(kHead.size());
  MapStart start{read_grids(reader), {}, {}};
  for (std::size_t left = reader.count(40); left > 0; --left) {
    read_key_scan(reader, start.key_scans);
  }
  start.map_from_base = reader.pose();
  for (Eigen::Index i = 0; i < 9; ++i) {
    start.covariance(i) = reader.number(kLargest);
  }
  if (!is_covariance(start.covariance)) {
    reader.fail("is damaged: the covariance of its pose is none");
  }
  if (!reader.at_end()) {
    reader.fail("is damaged: it goes on after its end");
  }
  return start;
}

}  // namespace matchbox_slam
