#pragma once

#include <cstddef>
#include <vector>

#include "geometry/trajectory.hpp"

namespace matchbox_slam {

struct ClockOffsetOptions {
  static constexpr double kWidestRange = 86400.0;  ///< [s], a day takes minutes
  double range = 120.0;             ///< [s], > 0; offsets from -range to range are tried
  double max_gap = kDefaultMaxGap;  ///< [s], truth is not interpolated across more than this
  double min_overlap = 0.5;  ///< in (0, 1], share of the largest overlap that an offset must have
};

/// How well estimate and truth fit when so many seconds are added to the truth's stamps.
struct ClockOffsetFit {
  double offset = 0.0;    ///< [s]
  double rmse = 0.0;      ///< [m], of positions after alignment in SE(2)
  std::size_t poses = 0;  ///< of the estimate that had truth, of those that were looked at
};

struct ClockOffset {
  double offset = 0.0;                ///< [s], clock of the estimate minus clock of the truth
  std::vector<ClockOffsetFit> curve;  ///< every offset tried with enough overlap, by offset
};

/// The offset between two clocks, from the trajectories alone: the one at which the absolute
/// trajectory error is least. The whole range is tried on a grid of 0.25 s, then the surroundings
/// of the best places at 0.01 s; a parabola through the squared errors around the least gives the
/// answer. Of a long estimate about 2,000 poses are used, spread evenly.
///
/// An offset counts when the trajectories overlap by at least `min_overlap` of the most they do at
/// any offset in the range: with few poses left, alignment makes anything fit. Half is enough to
/// exclude that and still finds an estimate of which up to half lies outside the truth.
///
/// Throws EvaluationError, which says what to do, when one of the two is empty or they never
/// overlap, and when the answer would mean nothing: when the error is about the same (less than a
/// quarter more, or 5 mm) at an offset more than 3 s from the best one, because the robot rests,
/// drives straight or turns in circles, or repeats itself; when the best one is at the end of the
/// offsets tried; and when the trajectories do not fit even there. They do not when the error is
/// more than a tenth of the path's extent (both root mean squares), or when headings, which play no
/// part in the alignment, differ by more than 0.02 rad and a twentieth of their own spread, a
/// constant difference aside. Trajectories without headings, all of which are the same, are judged
/// by positions alone. Of random pieces of winding drives that overlap too little or not at all,
/// about one in 350 still fits that well somewhere. Throws std::invalid_argument for options that
/// are not allowed.
[[nodiscard]] ClockOffset find_clock_offset(const Trajectory& estimate, const Trajectory& truth,
                                            const ClockOffsetOptions& options = {});

}  // namespace matchbox_slam
