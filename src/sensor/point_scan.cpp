#include "matchbox_slam/sensor/point_scan.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>

#include "matchbox_slam/geometry/transform2.hpp"
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
  constexpr double kCover = 0.2;  // [m]
  constexpr std::size_t kFewest = 10;
  const double least = std::max(options.min_range, scan.range_min);
  std::size_t read = 0;
  std::size_t near = 0;
  for (const float range : scan.ranges) {
    const bool is_read = classify(range, least, options.max_range) != Reading::kIgnored;
    read += is_read ? 1 : 0;
    near += is_read && range < kCover ? 1 : 0;
  }
  return read >= kFewest && 2 * near > read ? std::max(least, kCover) : least;
}

/// Pose of the laser after a fraction of the scan.
Eigen::Isometry3d laser_at(double fraction, const Eigen::Isometry3d& base_from_laser,
                           const Eigen::Isometry3d& laser_motion) {
  const Eigen::Quaterniond turn(laser_motion.linear());
  return base_from_laser * Eigen::Translation3d(fraction * laser_motion.translation()) *
         Eigen::Quaterniond::Identity().slerp(fraction, turn);
}

/// Unit vectors along the beams of a laser, in its plane.
class BeamDirections {
 public:
  /// By turning on some from few, since a cosine and a sine take much longer than a product. Off by
  /// less than 1e-15.
  const std::vector<Eigen::Vector2d>& of(const LaserScan& scan) {
    constexpr std::size_t kFew = 32;
    const std::size_t count = scan.ranges.size();
    if (count == beams_.size() && scan.angle_min == angle_min_ &&
        scan.angle_increment == angle_increment_) {
      return beams_;
    }
    angle_min_ = scan.angle_min;
    angle_increment_ = scan.angle_increment;
    const auto direction = [](double angle) {
      return Eigen::Vector2d(std::cos(angle), std::sin(angle));
    };
    std::array<Eigen::Vector2d, kFew> turns;
    for (std::size_t i = 0; i < kFew; ++i) {
      turns[i] = direction(static_cast<double>(i) * scan.angle_increment);
    }
    beams_.resize(count);
    for (std::size_t k = 0; k < count; k += kFew) {
      const Eigen::Vector2d first =
          direction(scan.angle_min + static_cast<double>(k) * scan.angle_increment);
      for (std::size_t i = 0; i < std::min(kFew, count - k); ++i) {
        beams_[k + i] = {first.x() * turns[i].x() - first.y() * turns[i].y(),
                         first.y() * turns[i].x() + first.x() * turns[i].y()};
      }
    }
    return beams_;
  }

 private:
  double angle_min_ = 0.0;  ///< [rad]
  double angle_increment_ = 0.0;
  std::vector<Eigen::Vector2d> beams_;
};

/// Whether the angle lies in one of the sectors: pairs of from and to, counter-clockwise, each less
/// than a turn.
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

/// Sums over the first points of a scan, so that a line through any run of them is fitted in
/// constant time.
class RunningSums {
 public:
  void assign(const std::vector<ScanPoint>& points) {
    sums_.clear();
    sums_.reserve(points.size() + 1);
    sums_.emplace_back();
    for (const ScanPoint& point : points) {
      const double x = point.position.x();
      const double y = point.position.y();
      const Sums& last = sums_.back();
      sums_.push_back({last.x + x, last.y + y, last.xx + x * x, last.xy + x * y, last.yy + y * y});
    }
  }

  /// Second moments of a run of points about their mean [m^2].
  struct Spread {
    double xx = 0.0;
    double xy = 0.0;
    double yy = 0.0;
    double smallest = 0.0;  ///< eigenvalue: squared rms distance from the best line
    double largest = 0.0;   ///< eigenvalue: squared rms extent along it

    /// Unit normal of the line of total least squares.
    [[nodiscard]] Eigen::Vector2d normal() const {
      const Eigen::Vector2d a(xy, smallest - xx);
      const Eigen::Vector2d b(smallest - yy, xy);
      return (a.squaredNorm() > b.squaredNorm() ? a : b).normalized();
    }
  };

  /// Of the points first...last, both included.
  [[nodiscard]] Spread spread(std::size_t first, std::size_t last) const {
    const Sums& a = sums_[first];
    const Sums& b = sums_[last + 1];
    const double share = 1.0 / static_cast<double>(last + 1 - first);
    const double mean_x = (b.x - a.x) * share;
    const double mean_y = (b.y - a.y) * share;
    const double xx = (b.xx - a.xx) * share - mean_x * mean_x;
    const double xy = (b.xy - a.xy) * share - mean_x * mean_y;
    const double yy = (b.yy - a.yy) * share - mean_y * mean_y;
    const double half_difference = 0.5 * (xx - yy);
    const double half_spread = std::sqrt(half_difference * half_difference + xy * xy);
    const double middle = 0.5 * (xx + yy);
    return {xx, xy, yy, std::max(0.0, middle - half_spread), middle + half_spread};
  }

 private:
  struct Sums {
    double x = 0.0;
    double y = 0.0;
    double xx = 0.0;
    double xy = 0.0;
    double yy = 0.0;
  };
  std::vector<Sums> sums_;
};

/// The points around one that may lie on the same surface.
struct Neighbourhood {
  std::size_t first = 0;
  std::size_t last = 0;
  bool sparse = false;  ///< far and grazing: wider than the radius, since the beams are far apart
};

/// Distance from each point to the one after it; one element less than points.
void find_gaps(const std::vector<ScanPoint>& points, std::vector<double>& gaps) {
  gaps.clear();
  gaps.reserve(points.size());
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    gaps.push_back((points[i + 1].position - points[i].position).norm());
  }
}

Neighbourhood neighbourhood(const std::vector<ScanPoint>& points, const std::vector<double>& gaps,
                            std::size_t index, const ProjectionOptions& options) {
  // On a straight wall the gaps grow slowly from beam to beam, with beams 1 degree apart to 2.5
  // times only beyond 87 degrees of incidence; at its end they jump. Half or double of it
  // changes the median error of pairs by less than 1 %.
  constexpr double kJump = 2.5;
  // Gaps: three neighbours on either side, of which one may lack. Half or double of it changes the
  // median error of pairs by up to 2 %, that of the heading by up to 7 %.
  constexpr double kSparseReach = 3.5;
  const double before = index > 0 ? gaps[index - 1] : options.max_wall_gap;
  const double after = index < gaps.size() ? gaps[index] : options.max_wall_gap;
  const double spacing = std::min({before, after, options.max_wall_gap});
  const double radius = std::max(options.surface_radius, kSparseReach * spacing);
  const double widest_gap = std::max(options.surface_radius, kJump * spacing);
  const Eigen::Vector2d& here = points[index].position;
  const auto in_reach = [&](std::size_t other, double gap) {
    return gap <= widest_gap && (points[other].position - here).squaredNorm() <= radius * radius;
  };
  // On either side; more would take a scan of very many readings close by forever, for nothing.
  constexpr std::size_t kMostNeighbours = 2000;
  Neighbourhood result{index, index, radius > options.surface_radius};
  while (result.first > 0 && index - result.first < kMostNeighbours &&
         in_reach(result.first - 1, gaps[result.first - 1])) {
    --result.first;
  }
  while (result.last < gaps.size() && result.last - index < kMostNeighbours &&
         in_reach(result.last + 1, gaps[result.last])) {
    ++result.last;
  }
  return result;
}

/// The normal of the line through a point's neighbourhood, or zero. Of the neighbours on the left,
/// on the right and on both sides, those that lie best on a line are taken, so that corners stay
/// sharp.
Eigen::Vector2d surface_normal(const RunningSums& sums, std::size_t index,
                               const Neighbourhood& around) {
  // Squared residual over squared extent of a line, that is one fifth as thick as long. Half or
  // double of it changes the median error of pairs by up to 1 %, that of the heading by up to 4 %.
  constexpr double kStraight = 0.04;
  // [m], three times a usual noise of 1 cm: sparse points are so far apart that their extent alone
  // would let nearly any three be a line. Half or double: by up to 1 %, and 2 %.
  constexpr double kSparseResidual = 0.03;
  const std::size_t fewest = around.sparse ? 5 : 3;
  RunningSums::Spread best;
  double best_ratio = kStraight;
  const auto consider = [&](std::size_t from, std::size_t to, double handicap) {
    if (to + 1 - from < fewest) {
      return;
    }
    const RunningSums::Spread spread = sums.spread(from, to);
    if (around.sparse && spread.smallest > kSparseResidual * kSparseResidual) {
      return;
    }
    if (handicap * spread.smallest < best_ratio * spread.largest) {
      best = spread;
      best_ratio = handicap * spread.smallest / spread.largest;
    }
  };
  consider(around.first, around.last, 1.0);
  // One side alone has half the points, so it must be clearly straighter to be believed.
  consider(around.first, index, 4.0);
  consider(index, around.last, 4.0);
  return best.largest > 0.0 ? best.normal() : Eigen::Vector2d::Zero();
}

/// Whether the step from one point to the next runs along the surfaces of both. Half or double of
/// any limit changes the hough matcher's errors of pairs by up to 1 %, its mean relation in intel
/// by 3 to 10 %.
bool on_one_wall(const ScanPoint& a, const ScanPoint& b, double gap) {
  constexpr double kAcross = 0.05;  // sine of the angle between step and surface, 3 degrees
  constexpr double kAgree = 0.95;   // cosine of the angle between the normals, 18 degrees
  constexpr double kNoise = 0.02;   // [m], two deviations of a usual noise of 1 cm
  const Eigen::Vector2d step = b.position - a.position;
  const double limit = kAcross * gap + kNoise;
  return a.normal.dot(b.normal) >= kAgree && std::abs(a.normal.dot(step)) <= limit &&
         std::abs(b.normal.dot(step)) <= limit;
}

/// @param gaps  of find_gaps.
/// @param sums  on the way.
void add_surfaces(const std::vector<double>& gaps, const ProjectionOptions& options,
                  RunningSums& sums, std::vector<ScanPoint>& points) {
  sums.assign(points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].normal.isZero()) {
      continue;
    }
    Eigen::Vector2d normal = surface_normal(sums, i, neighbourhood(points, gaps, i, options));
    if (normal.dot(points[i].origin - points[i].position) < 0.0) {
      normal = -normal;
    }
    points[i].normal = normal;
  }
  for (std::size_t i = 0; i < gaps.size(); ++i) {
    points[i].joined_to_next =
        gaps[i] <= options.max_wall_gap && on_one_wall(points[i], points[i + 1], gaps[i]);
  }
}

/// Straightens walls where there is noise, but not so much that it may be shape.
void take_noise_out(const ProjectionOptions& options, HitRows& hits, WallMemory& memory,
                    std::vector<ScanPoint>& points) {
  constexpr double kLeast = 5e-4;  // [m]; ranges rounded to 1 mm alone have 0.3 mm
  // [m], a cell by default. With a range noise of 3 cm half of it makes the median error of pairs
  // in rooms 3.5 mm instead of 2.4.
  constexpr double kMost = 0.05;
  hits.assign(points, options.max_wall_gap);
  const double noise = range_noise(hits, memory);
  if (noise >= kLeast && noise <= kMost) {
    straighten_walls(hits, noise, memory, points);
  }
}

/// Each point stands for half the way to its neighbours on both sides.
/// @param gaps  of find_gaps.
void add_weights(const std::vector<double>& gaps, double cap, std::vector<ScanPoint>& points) {
  double before = cap;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double after = i < gaps.size() ? std::min(cap, gaps[i]) : cap;
    // Coincident points would otherwise count nothing at all.
    points[i].weight = std::max(0.5 * (before + after), 1e-3 * cap);
    before = after;
  }
}

/// Where each beam ends, or what it says to be free, in the frame of the base at the first beam.
/// @param beams      directions in the laser's plane.
/// @param cut_after  points that a beam follows which was cut at the band of heights.
void place_beams(const LaserScan& scan, const std::vector<Eigen::Vector2d>& beams,
                 const Eigen::Isometry3d& base_from_laser, const Pose2& motion,
                 const ProjectionOptions& options, const Eigen::Isometry3d& laser_motion,
                 std::vector<std::size_t>& cut_after, PointScan& result) {
  const double min_range = least_range(scan, options);
  const double max_range = std::min(options.max_range, scan.range_max);
  const double free_range = std::min(options.free_range, max_range);
  const std::size_t count = scan.ranges.size();
  const bool moving = motion != Pose2{} && count > 1;
  const bool swaying = laser_motion.matrix() != Eigen::Matrix4d::Identity() && count > 1;
  Eigen::Isometry3d laser = base_from_laser;
  cut_after.clear();
  result.stamp = scan.stamp;
  result.points.clear();
  result.points.reserve(count);
  result.free_rays.clear();
  result.free_rays.reserve(count);
  for (std::size_t k = 0; k < count; ++k) {
    const auto range = static_cast<double>(scan.ranges[k]);
    const double fraction = static_cast<double>(k) / static_cast<double>(count - 1);
    Reading reading = classify(range, min_range, max_range);
    const double angle = scan.angle_min + static_cast<double>(k) * scan.angle_increment;
    if (reading == Reading::kIgnored || is_masked(angle, options.masked_angles)) {
      continue;
    }
    if (swaying) {
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
    Eigen::Vector2d origin = laser.translation().head<2>();
    Eigen::Vector2d end = origin + laser.linear().topLeftCorner<2, 2>() * (length * beam);
    if (moving) {
      const Transform2 first_from_here(interpolate(Pose2{}, motion, fraction));
      origin = first_from_here * origin;
      end = first_from_here * end;
    }
    if (reading == Reading::kNoReturn) {
      result.free_rays.push_back({origin, end});
    } else {
      result.points.push_back({end, origin, Eigen::Vector2d::Zero(), 0.0, false});
    }
  }
}

}  // namespace

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
              cut_after, result);
  if (options.straighten_walls) {
    take_noise_out(options, memory_->hits, memory_->walls, result.points);
  }
  std::vector<double>& gaps = memory_->gaps;
  find_gaps(result.points, gaps);
  add_surfaces(gaps, options, memory_->sums, result.points);
  for (const std::size_t point : cut_after) {
    result.points[point].joined_to_next = false;
  }
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
