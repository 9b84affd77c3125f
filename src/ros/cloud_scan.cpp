// Points of a cloud as a scan of one plane.

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <boost/make_shared.hpp>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "ros/scan_message.hpp"

namespace matchbox_slam {
namespace {

using sensor_msgs::PointField;

/// Why a cloud cannot be read, for people.
class CloudDefect : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct NumberType {
  const char* name;
  std::size_t bytes;
};

/// By the datatype of a field; the first is none.
constexpr std::array<NumberType, 9> kNumberTypes = {{{"", 0},
                                                     {"INT8", 1},
                                                     {"UINT8", 1},
                                                     {"INT16", 2},
                                                     {"UINT16", 2},
                                                     {"INT32", 4},
                                                     {"UINT32", 4},
                                                     {"FLOAT32", 4},
                                                     {"FLOAT64", 8}}};

bool is_number_type(unsigned datatype) { return datatype > 0 && datatype < kNumberTypes.size(); }

bool is_real(unsigned datatype) {
  return datatype == PointField::FLOAT32 || datatype == PointField::FLOAT64;
}

template <typename Number>
double number_at(const std::uint8_t* bytes) {
  Number number{};
  std::memcpy(&number, bytes, sizeof(Number));
  return static_cast<double>(number);
}

/// One number of each point.
class PointNumber {
 public:
  PointNumber(std::size_t offset, unsigned datatype) : offset_(offset), datatype_(datatype) {}

  [[nodiscard]] double of(const std::uint8_t* point) const {
    const std::uint8_t* bytes = point + offset_;
    switch (datatype_) {
      case PointField::INT8:
        return number_at<std::int8_t>(bytes);
      case PointField::UINT8:
        return number_at<std::uint8_t>(bytes);
      case PointField::INT16:
        return number_at<std::int16_t>(bytes);
      case PointField::UINT16:
        return number_at<std::uint16_t>(bytes);
      case PointField::INT32:
        return number_at<std::int32_t>(bytes);
      case PointField::UINT32:
        return number_at<std::uint32_t>(bytes);
      case PointField::FLOAT32:
        return number_at<float>(bytes);
      default:
        return number_at<double>(bytes);
    }
  }

 private:
  std::size_t offset_;
  unsigned datatype_;
};

std::string names_of_fields(const sensor_msgs::PointCloud2& cloud) {
  std::string names;
  for (const PointField& field : cloud.fields) {
    names += (names.empty() ? "" : ", ") + field.name;
  }
  return names.empty() ? "none" : names;
}

/// Finds a field and makes sure that every point has room for it.
PointNumber find_number(const sensor_msgs::PointCloud2& cloud, const std::string& name,
                        bool has_to_be_real, const std::string& advice) {
  const auto field = std::find_if(cloud.fields.begin(), cloud.fields.end(),
                                  [&](const PointField& one) { return one.name == name; });
  if (field == cloud.fields.end()) {
    throw CloudDefect(fmt::format("its points have no field {}; they have: {}{}", name,
                                  names_of_fields(cloud), advice));
  }
  const unsigned datatype = field->datatype;
  if (!is_number_type(datatype) || is_real(datatype) != has_to_be_real) {
    throw CloudDefect(fmt::format(
        "its field {} has the datatype {}{}; allowed: {}", name, datatype,
        is_number_type(datatype) ? fmt::format(" ({})", kNumberTypes.at(datatype).name) : "",
        has_to_be_real ? "7 (FLOAT32), 8 (FLOAT64)" : "1 to 6, whole numbers"));
  }
  const std::uint64_t end = std::uint64_t{field->offset} + kNumberTypes.at(datatype).bytes;
  if (end > cloud.point_step) {
    throw CloudDefect(fmt::format("its field {} ends at byte {} of a point; its point_step is {}",
                                  name, end, cloud.point_step));
  }
  return {field->offset, datatype};
}

/// Makes sure that all points that are announced are there.
void check_size(const sensor_msgs::PointCloud2& cloud) {
  if (cloud.is_bigendian != 0) {
    throw CloudDefect(
        fmt::format("it is big-endian (is_bigendian {}); allowed: 0; let its driver, or a node "
                    "between, send it little-endian, as this computer has it",
                    unsigned{cloud.is_bigendian}));
  }
  const std::uint64_t row = std::uint64_t{cloud.width} * cloud.point_step;
  if (row > cloud.row_step) {
    throw CloudDefect(
        fmt::format("its row_step {} is too short for its width {} of points of point_step {}",
                    cloud.row_step, cloud.width, cloud.point_step));
  }
  const std::uint64_t bytes = std::uint64_t{cloud.height} * cloud.row_step;
  if (bytes > cloud.data.size()) {
    throw CloudDefect(fmt::format("its data has {} bytes; height x row_step, {} x {}, are {}",
                                  cloud.data.size(), cloud.height, cloud.row_step, bytes));
  }
}

/// Which points are taken: by a ring or by their height.
class PointChoice {
 public:
  PointChoice(const sensor_msgs::PointCloud2& cloud, const CloudOptions& options)
      : options_(options),
        by_ring_(options.ring >= 0),
        number_(by_ring_ ? find_number(cloud, "ring", false,
                                       "; to take a band of heights leave cloud/ring out")
                         : find_number(cloud, "z", true, "")) {}

  /// Never a point whose height is not a number.
  [[nodiscard]] bool takes(const std::uint8_t* point) const {
    const double number = number_.of(point);
    return by_ring_ ? number == options_.ring
                    : number >= options_.min_height && number <= options_.max_height;
  }

  [[nodiscard]] std::string text() const {
    return by_ring_ ? fmt::format("of cloud/ring {}", options_.ring)
                    : fmt::format("between cloud/min_height {} and cloud/max_height {} m",
                                  to_string(options_.min_height), to_string(options_.max_height));
  }

 private:
  const CloudOptions& options_;
  bool by_ring_;
  PointNumber number_;
};

/// How many beams there are from the first to the last one, or in a turn.
std::size_t beam_count(const CloudOptions& options) {
  constexpr double kSlack = 1e-6;  // of a beam: what is left of a turn by rounding is none
  const double step = options.angle_increment;
  const double sector = std::round((options.angle_max - options.angle_min) / step) + 1.0;
  const double turn = std::floor(2.0 * kPi / step + kSlack);
  return static_cast<std::size_t>(std::min(sector, turn));
}

/// The nearest point of each beam.
class Beams {
 public:
  explicit Beams(const CloudOptions& options)
      : options_(options),
        ranges_(beam_count(options), std::numeric_limits<float>::infinity()),
        has_too_near_(ranges_.size(), false) {}

  /// Returns whether the point is within reach.
  bool add(double x, double y) {
    const double range = std::hypot(x, y);
    const double step = options_.angle_increment;
    double angle = std::atan2(y, x) - options_.angle_min + 0.5 * step;
    angle -= 2.0 * kPi * std::floor(angle / (2.0 * kPi));
    const auto beam = static_cast<std::size_t>(angle < 2.0 * kPi ? angle / step : 0.0);  // rounded
    if (beam >= ranges_.size()) {
      return false;
    }
    if (!(range >= options_.range_min && range < options_.range_max)) {
      has_too_near_[beam] = has_too_near_[beam] || range < options_.range_min;
      return false;
    }
    ranges_[beam] = std::min(ranges_[beam], static_cast<float>(range));
    return true;
  }

  /// Moves the beams into a scan.
  void give(sensor_msgs::LaserScan& scan) {
    for (std::size_t i = 0; i < ranges_.size(); ++i) {
      // What is too near, say of the robot itself, hides what is behind it: nothing is known there.
      // What is too far is no return, as with lasers.
      if (std::isinf(ranges_[i]) && (!options_.clear_empty || has_too_near_[i])) {
        ranges_[i] = std::numeric_limits<float>::quiet_NaN();
      }
    }
    const double first = options_.angle_min;
    const auto steps = static_cast<double>(ranges_.size() - 1);
    const double last = first + steps * options_.angle_increment;
    const bool is_clockwise = options_.scan_time < 0.0;
    if (is_clockwise) {
      std::reverse(ranges_.begin(), ranges_.end());
    }
    scan.angle_min = static_cast<float>(is_clockwise ? last : first);
    scan.angle_max = static_cast<float>(is_clockwise ? first : last);
    scan.angle_increment =
        static_cast<float>(is_clockwise ? -options_.angle_increment : options_.angle_increment);
    scan.scan_time = static_cast<float>(std::abs(options_.scan_time));
    scan.time_increment =
        static_cast<float>(steps > 0.0 ? std::abs(options_.scan_time) / steps : 0.0);
    scan.range_min = static_cast<float>(options_.range_min);
    scan.range_max = static_cast<float>(options_.range_max);
    scan.ranges = std::move(ranges_);
  }

 private:
  const CloudOptions& options_;
  std::vector<float> ranges_;       ///< counterclockwise; infinite: none yet
  std::vector<bool> has_too_near_;  ///< whether there was a point nearer than range_min
};

/// What became of the points, to tell where none is left.
struct PointCount {
  std::size_t all = 0;
  std::size_t no_numbers = 0;
  std::size_t not_chosen = 0;
  std::size_t out_of_reach = 0;

  [[nodiscard]] bool is_any_left() const { return no_numbers + not_chosen + out_of_reach < all; }
};

PointCount add_points(const sensor_msgs::PointCloud2& cloud, const PointChoice& choice,
                      Beams& beams) {
  const PointNumber x = find_number(cloud, "x", true, "");
  const PointNumber y = find_number(cloud, "y", true, "");
  PointCount count;
  for (std::size_t row = 0; row < cloud.height; ++row) {
    const std::uint8_t* point = cloud.data.data() + row * cloud.row_step;
    for (std::size_t column = 0; column < cloud.width; ++column, point += cloud.point_step) {
      ++count.all;
      const double at_x = x.of(point);
      const double at_y = y.of(point);
      if (!std::isfinite(at_x) || !std::isfinite(at_y)) {
        ++count.no_numbers;
      } else if (!choice.takes(point)) {
        ++count.not_chosen;
      } else if (!beams.add(at_x, at_y)) {
        ++count.out_of_reach;
      }
    }
  }
  return count;
}

std::string text_of_none_left(const PointCount& count, const PointChoice& choice) {
  return fmt::format(
      "none of its {} points is left: {} are no numbers, {} not {}, {} outside of cloud/range_min "
      "to range_max or of cloud/angle_min to angle_max",
      count.all, count.no_numbers, count.not_chosen, choice.text(), count.out_of_reach);
}

}  // namespace

ScanMessage to_scan(const sensor_msgs::PointCloud2& message, const CloudOptions& options) {
  const auto scan = boost::make_shared<sensor_msgs::LaserScan>();
  scan->header = message.header;
  ScanMessage result{scan, {}, false, true};
  if (message.width == 0 || message.height == 0) {
    result.is_empty = true;
    result.defect = "it has no points";
    return result;
  }
  try {
    check_size(message);
    const PointChoice choice(message, options);
    Beams beams(options);
    const PointCount count = add_points(message, choice, beams);
    if (count.is_any_left() || options.clear_empty) {
      beams.give(*scan);
    } else {
      result.is_empty = true;
      result.defect = text_of_none_left(count, choice);
    }
  } catch (const CloudDefect& defect) {
    result.defect = defect.what();
  }
  return result;
}

}  // namespace matchbox_slam
