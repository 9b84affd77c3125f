#include "sensor/point_surfaces.hpp"

#include <algorithm>
#include <cmath>

namespace matchbox_slam {
namespace {

/// The points around one that may lie on the same surface.
struct Neighbourhood {
  std::size_t first = 0;
  std::size_t last = 0;
  bool sparse = false;  ///< far and grazing: wider than the radius, since the beams are far apart
};

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
  constexpr double kMaxResidualRatio = 0.04;
  // [m], three times a usual noise of 1 cm: sparse points are so far apart that their extent alone
  // would let nearly any three be a line. Half or double: by up to 1 %, and 2 %.
  constexpr double kSparseResidual = 0.03;
  const std::size_t fewest = around.sparse ? 5 : 3;
  RunningSums::Spread best;
  double best_ratio = kMaxResidualRatio;
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
  constexpr double kMaxStepSine = 0.05;  // sine of the angle between step and surface, 3 degrees
  constexpr double kMinNormalCosine = 0.95;  // cosine of the angle between the normals, 18 degrees
  constexpr double kNoise = 0.02;            // [m], two deviations of a usual noise of 1 cm
  const Eigen::Vector2d step = b.position - a.position;
  const double limit = kMaxStepSine * gap + kNoise;
  return a.normal.dot(b.normal) >= kMinNormalCosine && std::abs(a.normal.dot(step)) <= limit &&
         std::abs(b.normal.dot(step)) <= limit;
}

/// Whether a point without a normal lies on the line of a wall that its beam grazes, and whose
/// direction neighbouring beams tell. When they were chosen, with pairs of beams as far apart as
/// they liked, three drives of 250 s through campuses with ten times the noise of odometry, and 32
/// through corridors, ended with 0.006 and 0.023 m in the mean; with half and double of
/// kMaxGrazingCosine 0.004 and 0.006, 0.023 both, with double of kBeamsAside 0.005 and 0.025,
/// with half 0.09 and 0.024: then points on the walls beside are taken for others.
bool lies_on_wall_beside(const std::vector<ScanPoint>& points, std::size_t index) {
  constexpr std::size_t kBeamsAside = 30;    // beams to either side
  constexpr double kMaxGrazingCosine = 0.2;  // cosine of the incidence
  // [m], two deviations of a usual noise, and what the wall's direction is off. With 3 cm, and 3 mm
  // in a metre, the crack of a corner is taken for the wall beside it: one of the three drives ends
  // with 0.23 m.
  constexpr double kNoise = 0.02;
  constexpr double kBend = 0.001;  // [m] in a metre
  const ScanPoint& point = points[index];
  const Eigen::Vector2d beam = (point.position - point.origin).normalized();
  const std::size_t first = index - std::min(index, kBeamsAside);
  const std::size_t last = std::min(index + kBeamsAside, points.size() - 1);
  for (std::size_t other = first; other <= last; ++other) {
    const Eigen::Vector2d& normal = points[other].normal;
    const Eigen::Vector2d apart = point.position - points[other].position;
    if (!normal.isZero() && std::abs(normal.dot(beam)) < kMaxGrazingCosine &&
        std::abs(normal.dot(apart)) < kNoise + kBend * apart.norm()) {
      return true;
    }
  }
  return false;
}

/// The normal of a piece of wall between two points that faces the beams, else zero.
Eigen::Vector2d facing_normal(const ScanPoint& a, const ScanPoint& b) {
  constexpr double kMinGap = 0.04;  // [m]: a usual noise of 1 cm turns such a piece by 20 degrees
  constexpr double kMaxGap = 0.3;   // [m], of neighbours on one wall; 0.6 is as good
  // [rad] between the beams: where they are half a degree apart or more, two of them meet
  // different things. Without this limit aces and infinite_corridor, of such lasers, end with 0.096
  // and 0.56 m in place of 0.094 and 0.52, and drives of 360 beams through corridors get no better.
  constexpr double kMaxBeamAngle = 0.008;
  constexpr double kMaxBeamCosine = 0.4;  // cosine of the angle between the piece and the beam
  const Eigen::Vector2d step = b.position - a.position;
  const double gap = step.norm();
  const Eigen::Vector2d beam = (a.position - a.origin).normalized();
  if (gap < kMinGap || gap > kMaxGap || gap > kMaxBeamAngle * (a.position - a.origin).norm() ||
      std::abs(step.dot(beam)) > kMaxBeamCosine * gap) {
    return Eigen::Vector2d::Zero();
  }
  const Eigen::Vector2d normal(-step.y() / gap, step.x() / gap);
  return normal.dot(beam) > 0.0 ? Eigen::Vector2d(-normal) : normal;
}

}  // namespace

void find_gaps(const std::vector<ScanPoint>& points, std::vector<double>& gaps) {
  gaps.clear();
  gaps.reserve(points.size());
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    gaps.push_back((points[i + 1].position - points[i].position).norm());
  }
}

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

void add_facing_pairs(std::vector<ScanPoint>& points) {
  bool was_blunt = false;  // the point before, and on no wall beside it
  for (std::size_t i = 0; i < points.size(); ++i) {
    const bool is_blunt = points[i].normal.isZero() && !lies_on_wall_beside(points, i);
    if (is_blunt && was_blunt) {
      if (const Eigen::Vector2d normal = facing_normal(points[i - 1], points[i]);
          !normal.isZero()) {
        points[i - 1].normal = normal;
        points[i].normal = normal;
      }
    }
    was_blunt = is_blunt;
  }
}

void add_spacings(std::vector<ScanPoint>& points) {
  Eigen::Vector2d before = Eigen::Vector2d::Zero();
  double before_range = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d here = points[i].position - points[i].origin;
    const double range = here.norm();
    points[i].spacing = range;
    if (i > 0) {
      const double across = std::abs(here.x() * before.y() - here.y() * before.x());
      points[i - 1].spacing = std::min(points[i - 1].spacing, across / range);
      points[i].spacing = std::min(range, across / before_range);
    }
    before = here;
    before_range = range;
  }
}

void add_weights(const std::vector<double>& gaps, double cap, std::vector<ScanPoint>& points) {
  double before = cap;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double after = i < gaps.size() ? std::min(cap, gaps[i]) : cap;
    // Coincident points would otherwise count nothing at all.
    points[i].weight = std::max(0.5 * (before + after), 1e-3 * cap);
    before = after;
  }
}

}  // namespace matchbox_slam
