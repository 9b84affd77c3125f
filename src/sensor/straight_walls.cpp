#include "sensor/straight_walls.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>

#include "common/simd.hpp"

namespace matchbox_slam {
namespace {

// Least cosine of incidence, 87 degrees. The range noise of a grazing beam moves its end along the
// wall and hardly across, so that it would weigh ever more; but real walls are rough. Half or
// double of it changes the median errors of pairs by up to 1 %.
constexpr double kLeastCosine = 0.05;

using Run = HitRows::Run;

// Sums are kept in this many interleaved parts, which are added in the same order by every
// instruction set.
constexpr std::size_t kLanes = 8;

std::size_t whole_lanes(std::size_t size) { return (size + kLanes - 1) / kLanes * kLanes; }

/// The distance from each point to the next.
MATCHBOX_SIMD_CLONES void find_gaps(const double* __restrict__ x, const double* __restrict__ y,
                                    std::size_t count, double* __restrict__ gaps) {
  for (std::size_t i = 0; i < count; ++i) {
    const double step_x = x[i + 1] - x[i];
    const double step_y = y[i + 1] - y[i];
    gaps[i] = std::sqrt(step_x * step_x + step_y * step_y);
  }
}

MATCHBOX_SIMD_CLONES void normalise(std::size_t count, double* __restrict__ x,
                                    double* __restrict__ y) {
  for (std::size_t i = 0; i < count; ++i) {
    const double square = x[i] * x[i] + y[i] * y[i];
    const double inverse = square > 0.0 ? 1.0 / std::sqrt(square) : 1.0;
    x[i] *= inverse;
    y[i] *= inverse;
  }
}

/// How far points, from the second to the last but one, lie along their beams from the lines
/// through their neighbours, over what they would if all three ranges had unit variance, squared.
/// NaN or infinite where beam and line do not meet.
MATCHBOX_SIMD_CLONES void find_squares_off_neighbours(
    const double* __restrict__ x, const double* __restrict__ y, const double* __restrict__ beam_x,
    const double* __restrict__ beam_y, std::size_t count, double* __restrict__ squares) {
  for (std::size_t i = 1; i + 1 < count; ++i) {
    const double wall_x = x[i + 1] - x[i - 1];
    const double wall_y = y[i + 1] - y[i - 1];
    const double here_x = x[i] - x[i - 1];
    const double here_y = y[i] - y[i - 1];
    const double inverse = 1.0 / (wall_x * beam_y[i] - wall_y * beam_x[i]);
    const double off = (wall_x * here_y - wall_y * here_x) * inverse;
    const double length_square = wall_x * wall_x + wall_y * wall_y;
    const double share =
        ((here_x - off * beam_x[i]) * wall_x + (here_y - off * beam_y[i]) * wall_y) /
        (length_square > 1e-12 ? length_square : 1e-12);
    const double from_a =
        (1.0 - share) * (wall_x * beam_y[i - 1] - wall_y * beam_x[i - 1]) * inverse;
    const double from_b = share * (wall_x * beam_y[i + 1] - wall_y * beam_x[i + 1]) * inverse;
    squares[i] = off * off / (1.0 + from_a * from_a + from_b * from_b);
  }
}

/// Of those up to a limit, sum and number.
MATCHBOX_SIMD_CLONES void add_up_to(const double* squares, std::size_t size, double limit,
                                    double* __restrict__ sums) {
  for (std::size_t i = 0; i < size; i += kLanes) {
    for (std::size_t k = 0; k < kLanes; ++k) {
      const bool counts = squares[i + k] <= limit;
      sums[k] += counts ? squares[i + k] : 0.0;
      sums[kLanes + k] += counts ? 1.0 : 0.0;
    }
  }
}

double sum_of(const double* lanes) { return std::accumulate(lanes, lanes + kLanes, 0.0); }

/// Runs of points that follow each other without a gap, in which alone there are walls.
void find_unbroken_runs(const double* gaps, std::size_t size, double max_wall_gap,
                        std::vector<Run>& runs) {
  // On a straight wall the gaps grow slowly from beam to beam, with beams 1 degree apart threefold
  // only beyond 87 degrees of incidence; at its end they jump. Half or double of it changes
  // the median error of pairs by up to 1 %.
  constexpr double kJump = 3.0;
  constexpr double kDenseSpacing = 0.15;  // [m], three cells by default: shorter gaps are no jump
  runs.clear();
  std::size_t first = 0;
  double before = max_wall_gap;
  for (std::size_t i = 0; i < size; ++i) {
    const double after = i + 2 < size ? gaps[i + 1] : max_wall_gap;
    const double widest =
        std::min(max_wall_gap, std::max(kDenseSpacing, kJump * std::min(before, after)));
    if (i + 1 == size || !(gaps[i] <= widest)) {
      runs.push_back({first, i});
      first = i + 1;
    }
    before = gaps[i];
  }
}

/// A straight wall q p = 1, p being relative to the laser.
struct Fit {
  Eigen::Vector2d q = Eigen::Vector2d::Zero();
  double squares = 0.0;  ///< sum of the squared range errors [m^2]
};

/// Sums over the first points of a run, so that a wall through any part of it is fitted in constant
/// time. Its reciprocal range is linear in the wall's parameters: with u the beam's direction,
/// 1 / r = q u, and the range's error is r^2 (1 / r - q u) = r (1 - q p).
class InverseRangeSums {
 public:
  /// @param memory  for the sums.
  explicit InverseRangeSums(std::vector<InverseRangeSum>& memory) : sums_(memory) {}

  /// Makes them those of another run.
  /// @param laser  from where it was measured.
  void assign(const HitRows& hits, const Run& run, const Eigen::Vector2d& laser) {
    first_ = run.first;
    laser_ = laser;
    sums_.assign(1, Sums());
    for (std::size_t i = run.first; i <= run.last; ++i) {
      const Eigen::Vector2d p = Eigen::Vector2d(hits.x[i], hits.y[i]) - laser_;
      const double w = p.squaredNorm();
      const Sums& last = sums_.back();
      sums_.push_back({last.w + w, last.x + w * p.x(), last.y + w * p.y(),
                       last.xx + w * p.x() * p.x(), last.xy + w * p.x() * p.y(),
                       last.yy + w * p.y() * p.y()});
    }
  }

  [[nodiscard]] Fit fit(const Run& part) const {
    const Sums sums = of(part);
    const double inverse = 1.0 / sums.determinant();
    return {Eigen::Vector2d(inverse * (sums.yy * sums.x - sums.xy * sums.y),
                            inverse * (sums.xx * sums.y - sums.xy * sums.x)),
            squares(part)};
  }

  /// Of the wall through a part, the sum of the squared range errors [m^2].
  [[nodiscard]] double squares(const Run& part) const {
    if (part.size() <= 2) {
      return 0.0;
    }
    const Sums sums = of(part);
    const double determinant = sums.determinant();
    const double explained =
        sums.yy * sums.x * sums.x - 2.0 * sums.xy * sums.x * sums.y + sums.xx * sums.y * sums.y;
    // Without a determinant all are on one beam.
    return determinant > 0.0 ? std::max(0.0, sums.w - explained / determinant)
                             : std::numeric_limits<double>::infinity();
  }

  [[nodiscard]] const Eigen::Vector2d& laser() const { return laser_; }

 private:
  using Sums = InverseRangeSum;

  [[nodiscard]] Sums of(const Run& part) const {
    const Sums& a = sums_[part.first - first_];
    const Sums& b = sums_[part.last + 1 - first_];
    return {b.w - a.w, b.x - a.x, b.y - a.y, b.xx - a.xx, b.xy - a.xy, b.yy - a.yy};
  }

  std::size_t first_ = 0;
  Eigen::Vector2d laser_ = Eigen::Vector2d::Zero();
  std::vector<Sums>& sums_;  ///< of the first hits of the run, from none of them on
};

/// Splits runs into straight pieces, and merges those that were split too often (split and merge:
/// Pavlidis and Horowitz, "Segmentation of plane curves", 1974).
class SplitAndMerge {
 public:
  static constexpr std::size_t kMinPoints = 3;  // two points are always on a line

  SplitAndMerge(const InverseRangeSums& sums, double noise, WallMemory& memory)
      : sums_(sums), variance_(noise * noise), open_(memory.open), pieces_(memory.pieces) {}

  /// Good until the next call.
  [[nodiscard]] const std::vector<Run>& pieces_of(const Run& run) {
    pieces_.clear();
    open_.assign(1, run);
    while (!open_.empty()) {
      const Run part = open_.back();
      open_.pop_back();
      if (part.size() >= kMinPoints) {
        const Split split = best_split(part, part.first, part.last - 1);
        if (is_worthwhile(split, sums_.squares(part))) {
          open_.push_back({split.at + 1, part.last});
          open_.push_back({part.first, split.at});
          continue;
        }
      }
      append(part);
    }
    return pieces_;
  }

  [[nodiscard]] bool is_straight(const Run& part, const Fit& fit) const {
    if (part.size() < kMinPoints) {
      return false;
    }
    const double freedom = static_cast<double>(part.size()) - 2.0;
    return fit.squares <=
           variance_ * freedom * (kMaxVarianceRatio + 3.0 * std::sqrt(2.0 / freedom));
  }

 private:
  // By how much a split, of two more parameters, must reduce the sum of squares, in variances: by
  // chance alone two reduce it by more than 12 once in 400 splits (chi-squared), and a wall has
  // many places to be split. With 6 the median error of pairs in rooms is 7 % larger, with 24 as
  // large.
  static constexpr double kGain = 12.0;
  // Mean square up to which a piece counts as straight, in variances: the noise is estimated over
  // the scan, and some walls have more. With 0.75 the median error of pairs in rooms is 3 % larger
  // and that of the heading 12 %, with 3 they stay within 2 %.
  static constexpr double kMaxVarianceRatio = 1.5;

  struct Split {
    std::size_t at = 0;  ///< last point of the first part
    double squares = 0.0;
  };

  [[nodiscard]] bool is_worthwhile(const Split& split, double whole) const {
    return whole - split.squares > kGain * variance_;
  }

  /// Of the splits after from...to, the best of some, then the best of those around it.
  [[nodiscard]] Split best_split(const Run& part, std::size_t from, std::size_t to) const {
    // At first: the sum of squares changes slowly with the place, so that few show its valley.
    constexpr std::size_t kSplitTrials = 12;
    Split best{from, squares_of(part, from)};
    std::size_t stride = std::max<std::size_t>(1, (to - from) / kSplitTrials);
    for (;;) {
      for (std::size_t at = from; at <= to; at += stride) {
        if (const double squares = squares_of(part, at); squares < best.squares) {
          best = {at, squares};
        }
      }
      if (stride == 1) {
        return best;
      }
      from = best.at - std::min(best.at - from, stride);
      to = std::min(to, best.at + stride);
      stride = std::max<std::size_t>(1, stride / 4);
    }
  }

  [[nodiscard]] double squares_of(const Run& part, std::size_t at) const {
    return sums_.squares({part.first, at}) + sums_.squares({at + 1, part.last});
  }

  /// The first splits are made while there are other bends in the parts, hence not quite where they
  /// are best: each is moved there, or taken back where it gains nothing any more.
  void append(Run piece) {
    // Points; with 4 or 16 the errors of pairs stay within 2 %.
    constexpr std::size_t kBendReach = 8;
    while (!pieces_.empty()) {
      const Run both{pieces_.back().first, piece.last};
      const std::size_t here = pieces_.back().last;
      const std::size_t from = here - std::min(here - both.first, kBendReach);
      const std::size_t to = std::min(here + kBendReach, both.last - 1);
      const Split split = best_split(both, from, to);
      if (is_worthwhile(split, sums_.squares(both))) {
        pieces_.back().last = split.at;
        piece.first = split.at + 1;
        break;
      }
      pieces_.pop_back();
      piece = both;
    }
    pieces_.push_back(piece);
  }

  const InverseRangeSums& sums_;
  double variance_;
  std::vector<Run>& open_;
  std::vector<Run>& pieces_;
};

/// A line through `middle`.
struct Line {
  Eigen::Vector2d middle;
  Eigen::Vector2d normal;
  double spread = 0.0;  ///< [m^2], the variance of a range over that of the line's direction
};

/// Sums over the hits that are not far off a line: of their weights, and these times where they are
/// along it (a) and across (b), a a and a b.
MATCHBOX_SIMD_CLONES void add_near_line(const double* x, const double* y, const double* beam_x,
                                        const double* beam_y, std::size_t count, const Line& line,
                                        double far, double* __restrict__ lanes) {
  const double middle_x = line.middle.x();
  const double middle_y = line.middle.y();
  const double normal_x = line.normal.x();
  const double normal_y = line.normal.y();
  for (std::size_t i = 0; i < count; i += kLanes) {
    for (std::size_t k = 0; k < kLanes; ++k) {
      const std::size_t j = i + k;
      const double facing = std::abs(normal_x * beam_x[j] + normal_y * beam_y[j]);
      const double cosine = facing > kLeastCosine ? facing : kLeastCosine;
      const double from_x = x[j] - middle_x;
      const double from_y = y[j] - middle_y;
      const double across = normal_x * from_x + normal_y * from_y;
      const double along = normal_x * from_y - normal_y * from_x;
      const bool counts = j < count && std::abs(across) <= far * cosine;
      const double w = counts ? 1.0 / (cosine * cosine) : 0.0;
      lanes[0 * kLanes + k] += w;
      lanes[1 * kLanes + k] += w * along;
      lanes[2 * kLanes + k] += w * across;
      lanes[3 * kLanes + k] += w * along * along;
      lanes[4 * kLanes + k] += w * along * across;
    }
  }
}

/// One step of least squares, without the points far off. The first fit has weights from noisy
/// ranges, which biases it a little.
Line improved(const HitRows& hits, const Run& part, const Line& line, double far) {
  std::array<double, 5 * kLanes> lanes{};
  add_near_line(&hits.x[part.first], &hits.y[part.first], &hits.beam_x[part.first],
                &hits.beam_y[part.first], part.size(), line, far, lanes.data());
  const double n = sum_of(lanes.data());
  const double along = sum_of(&lanes[kLanes]);
  const double across = sum_of(&lanes[2 * kLanes]);
  const double along_along = sum_of(&lanes[3 * kLanes]);
  const double along_across = sum_of(&lanes[4 * kLanes]);
  const double determinant = n * along_along - along * along;
  if (!(determinant > 0.0)) {
    return line;
  }
  const Eigen::Vector2d tangent(-line.normal.y(), line.normal.x());
  const double offset = (along_along * across - along * along_across) / determinant;
  const double slope = (n * along_across - along * across) / determinant;
  return {line.middle + offset * line.normal, (line.normal - slope * tangent).normalized(),
          determinant / n};
}

void move_onto(const Line& line, const Eigen::Vector2d& beam, double far, ScanPoint& point) {
  const double cosine = line.normal.dot(beam);
  const double moved = line.normal.dot(point.position - line.middle) / cosine;
  if (std::abs(cosine) < kLeastCosine || !(std::abs(moved) <= far)) {
    return;
  }
  point.position -= moved * beam;
  point.moved = -moved;
  point.normal = cosine < 0.0 ? line.normal : Eigen::Vector2d(-line.normal);
}

}  // namespace

void HitRows::assign(const std::vector<ScanPoint>& points, double max_wall_gap) {
  size = points.size();
  for (auto* row : {&x, &y, &beam_x, &beam_y}) {
    row->resize(size + kLanes);
    std::fill(row->end() - kLanes, row->end(), 0.0);
  }
  for (std::size_t i = 0; i < size; ++i) {
    x[i] = points[i].position.x();
    y[i] = points[i].position.y();
    beam_x[i] = x[i] - points[i].origin.x();
    beam_y[i] = y[i] - points[i].origin.y();
  }
  normalise(size, beam_x.data(), beam_y.data());
  gaps.assign(size, 0.0);
  find_gaps(x.data(), y.data(), std::max<std::size_t>(size, 1) - 1, gaps.data());
  find_unbroken_runs(gaps.data(), size, max_wall_gap, runs);
}

double range_noise(const HitRows& hits, WallMemory& memory) {
  // Whose standard deviation is known to 1 / sqrt(40), 16 %.
  constexpr std::size_t kMinResiduals = 20;
  constexpr double kOutlierSigmas = 3.0;  // standard deviations; with 1.5 the median error of pairs
                                          // is 8 to 13 % larger, with 6 up to 3 %
  std::vector<double>& all = memory.squares_of_all;
  all.resize(hits.size);
  find_squares_off_neighbours(hits.x.data(), hits.y.data(), hits.beam_x.data(), hits.beam_y.data(),
                              hits.size, all.data());
  std::vector<double>& squares = memory.squares;
  squares.clear();
  squares.reserve(whole_lanes(hits.size));
  for (const Run& run : hits.runs) {
    for (std::size_t i = run.first + 1; i < run.last; ++i) {
      if (std::isfinite(all[i])) {
        squares.push_back(all[i]);
      }
    }
  }
  if (squares.size() < kMinResiduals) {
    return 0.0;
  }
  // Two in three lie within a standard deviation, but most of the rest may be corners.
  const auto third = squares.begin() + static_cast<std::ptrdiff_t>(squares.size() * 2 / 3);
  std::nth_element(squares.begin(), third, squares.end());
  double variance = *third;
  squares.resize(whole_lanes(squares.size()), std::numeric_limits<double>::infinity());
  for (int i = 0; i < 3; ++i) {
    std::array<double, 2 * kLanes> sums{};
    add_up_to(squares.data(), squares.size(), kOutlierSigmas * kOutlierSigmas * variance,
              sums.data());
    variance = sum_of(sums.data()) / sum_of(&sums[kLanes]);
  }
  return std::sqrt(variance);
}

void straighten_walls(const HitRows& hits, double noise, WallMemory& memory,
                      std::vector<ScanPoint>& points) {
  // Standard deviations; farther off is something in front of the wall, or once in 2000 noise.
  // With 1.75 the median error of pairs in clutter is 12 % larger, with 7 in rooms 3 %.
  constexpr double kOutlierSigmas = 3.5;
  // Largest standard deviation of a wall's direction [rad]; from less certain ones the normals of
  // single points are as good. With 0.1 the median error of pairs in clutter is 10 % larger, with
  // 0.4 4 % smaller.
  constexpr double kMaxDirectionSigma = 0.2;
  memory.sums.reserve(hits.size + 1);
  InverseRangeSums sums(memory.sums);
  SplitAndMerge pieces(sums, noise, memory);
  for (const Run& run : hits.runs) {
    if (run.size() < SplitAndMerge::kMinPoints) {
      continue;
    }
    sums.assign(hits, run, points[run.first + run.size() / 2].origin);
    for (const Run& part : pieces.pieces_of(run)) {
      const Fit fit = sums.fit(part);
      if (!pieces.is_straight(part, fit)) {
        continue;
      }
      Line line{sums.laser() + fit.q / fit.q.squaredNorm(), fit.q.normalized(), 0.0};
      line = improved(hits, part, line, kOutlierSigmas * noise);
      line = improved(hits, part, line, kOutlierSigmas * noise);
      if (!(line.spread * kMaxDirectionSigma * kMaxDirectionSigma >= noise * noise)) {
        continue;
      }
      for (std::size_t i = part.first; i <= part.last; ++i) {
        move_onto(line, {hits.beam_x[i], hits.beam_y[i]}, kOutlierSigmas * noise, points[i]);
      }
    }
  }
}

}  // namespace matchbox_slam
