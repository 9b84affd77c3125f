#include "matchbox_slam/sensor/point_scan.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>

#include "matchbox_slam/geometry/transform2.hpp"
#include "sensor/point_surfaces.hpp"
#include "sensor/straight_walls.hpp"

namespace matchbox_slam {
namespace {

enum class Reading { kIgnored, kNoReturn, kHit };

Reading classify(double range, double min_range, double max_range) {
  if (std::isnan(range) || range <= 0.0 || range < min_range) {
    return Reading::kIgnored;
  }
  return range >= max_range ? Reading::kNoReturn : Reading::kHit;
}

/// Readings nearer than this [m] count for nothing. Where most beams end closer to the laser than a
/// robot comes to walls, something covers it: that moves along, and would hold the robot where it
/// is.
double least_range(const LaserScan& scan, const ProjectionOptions& options) {
  constexpr double kCover = 0.2;            // [m]
  constexpr std::size_t kMinReadings = 10;  // a guess: half and double were not tried
  const double least = std::max(options.min_range, scan.range_min);
  std::size_t read = 0;
  std::size_t near = 0;
  for (const float range : scan.ranges) {
    const bool is_read = classify(range, least, options.max_range) != Reading::kIgnored;
    read += is_read ? 1 : 0;
    near += is_read && range < kCover ? 1 : 0;
  }
  return read >= kMinReadings && 2 * near > read ? std::max(least, kCover) : least;
}

/// Pose of the laser after a fraction of the scan.
Eigen::Isometry3d laser_at(double fraction, const Eigen::Isometry3d& base_from_laser,
                           const Eigen::Isometry3d& laser_motion) {
  const Eigen::Quaterniond turn(laser_motion.linear());
  return base_from_laser * Eigen::Translation3d(fraction * laser_motion.translation()) *
         Eigen::Quaterniond::Identity().slerp(fraction, turn);
}

/// Unit vectors at angles of even steps [rad], by turning on some from few, since a cosine and a
/// sine take much longer than a product. Off by less than 1e-15.
void find_directions(double first, double step, std::size_t count,
                     std::vector<Eigen::Vector2d>& directions) {
  constexpr std::size_t kBlockSize = 32;
  const auto direction = [](double angle) {
    return Eigen::Vector2d(std::cos(angle), std::sin(angle));
  };
  std::array<Eigen::Vector2d, kBlockSize> turns;
  for (std::size_t i = 0; i < kBlockSize; ++i) {
    turns[i] = direction(static_cast<double>(i) * step);
  }
  directions.resize(count);
  for (std::size_t k = 0; k < count; k += kBlockSize) {
    const Eigen::Vector2d begin = direction(first + static_cast<double>(k) * step);
    for (std::size_t i = 0; i < std::min(kBlockSize, count - k); ++i) {
      directions[k + i] = {begin.x() * turns[i].x() - begin.y() * turns[i].y(),
                           begin.y() * turns[i].x() + begin.x() * turns[i].y()};
    }
  }
}

/// Unit vectors along the beams of a laser, in its plane.
class BeamDirections {
 public:
  const std::vector<Eigen::Vector2d>& of(const LaserScan& scan) {
    const std::size_t count = scan.ranges.size();
    if (count == beams_.size() && scan.angle_min == angle_min_ &&
        scan.angle_increment == angle_increment_) {
      return beams_;
    }
    angle_min_ = scan.angle_min;
    angle_increment_ = scan.angle_increment;
    find_directions(scan.angle_min, scan.angle_increment, count, beams_);
    return beams_;
  }

 private:
  double angle_min_ = 0.0;  ///< [rad]
  double angle_increment_ = 0.0;
  std::vector<Eigen::Vector2d> beams_;
};

/// Straightens walls where there is noise, but not so much that it may be shape.
void take_noise_out(const ProjectionOptions& options, HitRows& hits, WallMemory& memory,
                    std::vector<ScanPoint>& points) {
  constexpr double kMinNoise = 5e-4;  // [m]; ranges rounded to 1 mm alone have 0.3 mm
  // [m], a cell by default. With a range noise of 3 cm half of it makes the median error of pairs
  // in rooms 3.5 mm instead of 2.4.
  constexpr double kMaxNoise = 0.05;
  hits.assign(points, options.max_wall_gap);
  const double noise = range_noise(hits, memory);
  if (noise >= kMinNoise && noise <= kMaxNoise) {
    straighten_walls(hits, noise, memory, points);
  }
}

/// The base during a scan, in its frame at the first beam: it moves evenly.
class MovingBase {
 public:
  /// @param turns  for the directions that it faces.
  MovingBase(const Pose2& motion, std::size_t beams, std::vector<Eigen::Vector2d>& turns)
      : is_moving_(motion != Pose2{} && beams > 1), turns_(turns) {
    if (is_moving_) {
      const auto steps = static_cast<double>(beams - 1);
      per_beam_ = motion.translation() / steps;
      find_directions(0.0, wrap_angle(motion.theta) / steps, beams, turns_);
    }
  }

  /// @param point  as seen by the base at this beam.
  [[nodiscard]] Eigen::Vector2d at_first(std::size_t beam, const Eigen::Vector2d& point) const {
    if (!is_moving_) {
      return point;
    }
    const Eigen::Vector2d& turn = turns_[beam];
    return static_cast<double>(beam) * per_beam_ +
           Eigen::Vector2d(turn.x() * point.x() - turn.y() * point.y(),
                           turn.y() * point.x() + turn.x() * point.y());
  }

 private:
  bool is_moving_;
  Eigen::Vector2d per_beam_ = Eigen::Vector2d::Zero();  ///< [m]
  std::vector<Eigen::Vector2d>& turns_;
};

/// Where each beam ends, or what it says to be free, in the frame of the base at the first beam.
/// @param beams      directions in the laser's plane.
/// @param turns      of the base, on the way.
/// @param cut_after  points that a beam follows which was cut at the band of heights.
void place_beams(const LaserScan& scan, const std::vector<Eigen::Vector2d>& beams,
                 const Eigen::Isometry3d& base_from_laser, const Pose2& motion,
                 const ProjectionOptions& options, const Eigen::Isometry3d& laser_motion,
                 std::vector<Eigen::Vector2d>& turns, std::vector<std::size_t>& cut_after,
                 PointScan& result) {
  const double min_range = least_range(scan, options);
  const double max_range = std::min(options.max_range, scan.range_max);
  const double free_range = std::min(options.free_range, max_range);
  const std::size_t count = scan.ranges.size();
  const bool swaying = laser_motion.matrix() != Eigen::Matrix4d::Identity() && count > 1;
  const MovingBase base(motion, count, turns);
  Eigen::Isometry3d laser = base_from_laser;
  cut_after.clear();
  result.stamp = scan.stamp;
  result.points.clear();
  result.points.reserve(count);
  result.free_rays.clear();
  result.free_rays.reserve(count);
  for (std::size_t k = 0; k < count; ++k) {
    const auto range = static_cast<double>(scan.ranges[k]);
    Reading reading = classify(range, min_range, max_range);
    const double angle = scan.angle_min + static_cast<double>(k) * scan.angle_increment;
    if (reading == Reading::kIgnored || is_masked(angle, options.masked_angles)) {
      continue;
    }
    if (swaying) {
      const double fraction = static_cast<double>(k) / static_cast<double>(count - 1);
      laser = laser_at(fraction, base_from_laser, laser_motion);
    }
    double length = reading == Reading::kHit ? range : free_range;
    const Eigen::Vector2d& beam = beams[k];
    const double rise = laser.linear().row(2).head<2>().dot(beam);
    const double band = rise < 0.0 ? options.max_drop : options.max_rise;
    if (std::abs(rise) * length > band) {
      if (!result.points.empty()) {
        cut_after.push_back(result.points.size() - 1);
      }
      reading = Reading::kNoReturn;
      length = std::min(free_range, band / std::abs(rise));
    }
    if (length <= 0.0) {
      continue;
    }
    const Eigen::Vector2d here = laser.translation().head<2>();
    const Eigen::Vector2d ahead = laser.linear().topLeftCorner<2, 2>() * (length * beam);
    const Eigen::Vector2d origin = base.at_first(k, here);
    const Eigen::Vector2d end = base.at_first(k, here + ahead);
    if (reading == Reading::kNoReturn) {
      result.free_rays.push_back({origin, end});
    } else {
      result.points.push_back({end, origin, Eigen::Vector2d::Zero(), 0.0, false});
    }
  }
}

}  // namespace

bool is_masked(double angle, const std::vector<double>& sectors) {
  const auto turn = [](double from, double to) {
    const double turned = std::fmod(to - from, 2.0 * kPi);
    return turned < 0.0 ? turned + 2.0 * kPi : turned;
  };
  for (std::size_t i = 0; i + 1 < sectors.size(); i += 2) {
    if (turn(sectors[i], angle) <= turn(sectors[i], sectors[i + 1])) {
      return true;
    }
  }
  return false;
}

void check_projection_options(const ProjectionOptions& options) {
  if (options.min_range >= options.max_range) {
    throw ConfigurationError("scan/min_range: " + to_string(options.min_range) +
                             " m is not allowed with a scan/max_range of " +
                             to_string(options.max_range) +
                             " m, since no reading would be left; allowed: less than that");
  }
  if (options.masked_angles.size() % 2 != 0) {
    throw ConfigurationError("scan/masked_angles: " + std::to_string(options.masked_angles.size()) +
                             " angles are not allowed; allowed: pairs of from and to");
  }
  for (std::size_t i = 0; i < options.masked_angles.size(); i += 2) {
    const double from = options.masked_angles[i];
    const double to = options.masked_angles[i + 1];
    if (to - from >= 2.0 * kPi) {
      throw ConfigurationError("scan/masked_angles: from " + to_string(from) + " to " +
                               to_string(to) +
                               " rad is not allowed, since a whole turn leaves no reading; "
                               "allowed: sectors of less than 2 pi");
    }
  }
}

double tilt_of(const Eigen::Isometry3d& base_from_laser) {
  return std::acos(std::min(1.0, std::abs(base_from_laser.linear()(2, 2))));
}

struct ScanProjector::Memory {
  BeamDirections beams;
  std::vector<Eigen::Vector2d> turns;  ///< of the base during the scan
  std::vector<std::size_t> cut_after;  ///< points that a cut beam follows, where a door may be
  std::vector<double> gaps;
  RunningSums sums;
  HitRows hits;
  WallMemory walls;
};

ScanProjector::ScanProjector() : memory_(std::make_unique<Memory>()) {}
ScanProjector::ScanProjector(ScanProjector&& other) noexcept = default;
ScanProjector& ScanProjector::operator=(ScanProjector&& other) noexcept = default;
ScanProjector::~ScanProjector() = default;

void ScanProjector::project(const LaserScan& scan, const Eigen::Isometry3d& base_from_laser,
                            const Pose2& motion, const ProjectionOptions& options,
                            const Eigen::Isometry3d& laser_motion, PointScan& result) {
  std::vector<std::size_t>& cut_after = memory_->cut_after;
  place_beams(scan, memory_->beams.of(scan), base_from_laser, motion, options, laser_motion,
              memory_->turns, cut_after, result);
  if (options.straighten_walls) {
    take_noise_out(options, memory_->hits, memory_->walls, result.points);
  }
  std::vector<double>& gaps = memory_->gaps;
  find_gaps(result.points, gaps);
  add_surfaces(gaps, options, memory_->sums, result.points);
  add_facing_pairs(result.points);
  for (const std::size_t point : cut_after) {
    result.points[point].joined_to_next = false;
  }
  add_spacings(result.points);
  add_weights(gaps, options.max_point_weight, result.points);
}

PointScan project_scan(const LaserScan& scan, const Eigen::Isometry3d& base_from_laser,
                       const Pose2& motion, const ProjectionOptions& options,
                       const Eigen::Isometry3d& laser_motion) {
  PointScan result;
  ScanProjector().project(scan, base_from_laser, motion, options, laser_motion, result);
  return result;
}

void append(const PointScan& other, const Pose2& base_from_other, PointScan& scan) {
  const Transform2 moved(base_from_other);
  for (ScanPoint point : other.points) {
    point.position = moved * point.position;
    point.origin = moved * point.origin;
    point.normal = moved.turned(point.normal);
    scan.points.push_back(point);
  }
  for (const FreeRay& ray : other.free_rays) {
    scan.free_rays.push_back({moved * ray.origin, moved * ray.end});
  }
}

}  // namespace matchbox_slam
