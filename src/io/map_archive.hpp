#pragma once

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>
#include <utility>

#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/map/occupancy_grid.hpp"

namespace matchbox_slam {

// As of messages: farther than around the Earth [m]; and stamps [s] and covariances [m^2].
constexpr double kFarthest = 1e8;
constexpr double kLargest = kFarthest * kFarthest;

// A cell farther away than any scan of a robot: the file is damaged.
constexpr std::int32_t kFarthestCell = 1 << 24;

// What is written and what is read are one function each, given a MapWriter and something constant
// or a MapReader and something to fill.

/// Of the format that is written.
constexpr int kSavedVersion = 17;
/// Of what release 1.0 wrote, which is read, too. No other version is.
constexpr int kVersionOfRelease1 = 7;

/// Numbers in the order of their bytes, the lowest first, on every machine.
class MapWriter {
 public:
  static constexpr bool kReads = false;
  static constexpr bool is_of_1_0() { return false; }

  /// @param sink  gets what is written, piece by piece.
  explicit MapWriter(ByteSink sink) : sink_(std::move(sink)) {}

  template <typename Integer>
  void integer(Integer value) {
    auto rest = static_cast<std::make_unsigned_t<Integer>>(value);
    for (std::size_t i = 0; i < sizeof(Integer); ++i) {
      bytes_.push_back(static_cast<char>(rest & 0xFFU));
      rest = static_cast<std::make_unsigned_t<Integer>>(rest >> 8U);
    }
    if (bytes_.size() >= kPiece) {
      sink_(bytes_);
      bytes_.clear();
    }
  }

  void text(const std::string& text) { bytes_ += text; }

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

  /// So many cells of a row.
  void run(const Cell& first, std::uint32_t count) {
    cell(first);
    integer(count);
  }

  /// To be called once, at the end.
  void finish() {
    sink_(bytes_);
    bytes_.clear();
  }

 private:
  static constexpr std::size_t kPiece = std::size_t{1} << 16;

  std::string bytes_;  ///< that are not given on yet: all of them would double a map's memory
  ByteSink sink_;
};

class MapReader {
 public:
  static constexpr bool kReads = true;

  MapReader(const std::string& bytes, const std::string& path, double max_cells)
      : bytes_(bytes), path_(path), max_cells_(max_cells) {}

  /// Whether release 1.0 wrote it, which knew less.
  [[nodiscard]] bool is_of_1_0() const { return is_of_1_0_; }

  /// Reads the head of that version, if it is there.
  [[nodiscard]] bool begins_with_version(int version, const std::string& head) {
    is_of_1_0_ = version == kVersionOfRelease1;
    return begins_with(head);
  }

  [[noreturn]] void fail(const std::string& text) const {
    throw DamagedFile(fmt::format("'{}' {}", path_, text));
  }

  /// Of a file that is whole, but not for this program as it is.
  [[noreturn]] void refuse(const std::string& text) const {
    throw FileError(fmt::format("'{}' {}", path_, text));
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
      fail(fmt::format("is damaged: it holds the number {} where at most {} is allowed",
                       to_string(value), to_string(largest)));
    }
  }

  /// So many more, to the end of a text.
  void bytes(std::uint64_t count, std::string& text) {
    if (bytes_.size() - position_ < count) {
      fail("is cut off");
    }
    text.append(bytes_, position_, count);
    position_ += count;
  }

  void flag(bool& value) {
    std::uint8_t byte = 0;
    integer(byte);
    value = byte != 0;
  }

  /// The cells of each map have a frame of their own.
  void begin_map() { box_ = {}; }

  void cell(Cell& cell) {
    integer(cell.x);
    integer(cell.y);
    include(cell);
  }

  void run(Cell& first, std::uint32_t& count) {
    cell(first);
    integer(count);
    if (count == 0 || count > kFarthestCell) {
      fail(fmt::format("is damaged: {} cells of a row are known from {}, {} on", count, first.x,
                       first.y));
    }
    include({first.x + static_cast<std::int32_t>(count) - 1, first.y});
  }

  /// How many items of at least `bytes_each` follow.
  std::size_t count(std::size_t bytes_each, std::size_t most, const std::string& name) {
    std::uint64_t number = 0;
    integer(number);
    if (number > (bytes_.size() - position_) / bytes_each) {
      fail("is damaged: it announces more than it holds");
    }
    if (number > most) {
      fail(fmt::format("is damaged: it has {} {}; allowed: up to {}", number, name, most));
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
    // The lowest integer has no absolute value.
    if (std::min(cell.x, cell.y) < -kFarthestCell || std::max(cell.x, cell.y) > kFarthestCell) {
      fail(fmt::format("is damaged: a cell lies at {}, {}", cell.x, cell.y));
    }
    constexpr int kTileMargin = OccupancyGrid::Tiles::kTileSize - 1;
    const CellBox before = box_.empty() ? CellBox{cell, cell} : box_;
    box_.min = {std::min(before.min.x, cell.x), std::min(before.min.y, cell.y)};
    box_.max = {std::max(before.max.x, cell.x + 1), std::max(before.max.y, cell.y + 1)};
    const double cells = (box_.width() + double{kTileMargin}) * (box_.height() + kTileMargin);
    if (cells > max_cells_) {
      refuse(
          fmt::format("is damaged, or its map is too large: its cells span {} x {} or more; "
                      "allowed: {} in all; if it is as large as that, set map/max_cells higher",
                      box_.width(), box_.height(), to_string(max_cells_)));
    }
  }

  const std::string& bytes_;
  const std::string& path_;
  double max_cells_;
  bool is_of_1_0_ = false;
  std::size_t position_ = 0;
  CellBox box_;  ///< around all cells of a map so far
};

/// What the options of a map may be holds for a file, too.
inline void check_limits(double value, const char* name, const Allowed& allowed,
                         const MapReader& reader) {
  if (!(value >= allowed.low && value <= allowed.high)) {
    reader.fail(fmt::format("is damaged: its {} is {}; allowed: {}", name, to_string(value),
                            allowed.text()));
  }
}

template <typename Options>
void check_limits(const Options& options, const MapReader& reader) {
  Options::visit(options, [&reader](double value, const char* name, const Allowed& allowed,
                                    const char* /*unit*/, const char* /*meaning*/) {
    check_limits(value, name, allowed, reader);
  });
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

}  // namespace matchbox_slam
