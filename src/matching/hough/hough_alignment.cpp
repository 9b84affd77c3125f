#include "matchbox_slam/matching/hough/hough_alignment.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "matchbox_slam/geometry/angles.hpp"
#include "matchbox_slam/matching/pose_prior.hpp"
#include "matching/hough/lane_dot.hpp"

namespace matchbox_slam {
namespace {

/// Where the parabola through three values that lie one apart has its top, from the middle one.
double parabola_top(double before, double middle, double after) {
  const double bend = before - 2.0 * middle + after;
  return bend < 0.0 ? std::clamp(0.5 * (before - after) / bend, -0.5, 0.5) : 0.0;
}

// --- columns ---

/// Takes out what varies slowly along a column: votes of walls that run across it.
void sharpen(std::vector<float>& column, double rho_cell) {
  // [m] to each side. The mean relation of hough in intel is 0.074 m; with half of this 0.088, with
  // double the same.
  constexpr double kBackground = 0.3;
  const auto half = static_cast<std::size_t>(std::max(2L, std::lround(kBackground / rho_cell)));
  std::vector<float> sums(column.size() + 1, 0.0F);
  for (std::size_t i = 0; i < column.size(); ++i) {
    sums[i + 1] = sums[i] + column[i];
  }
  const float share = 1.0F / static_cast<float>(2 * half + 1);
  for (std::size_t i = 0; i < column.size(); ++i) {
    const std::size_t first = i > half ? i - half : 0;
    const std::size_t last = std::min(column.size(), i + half + 1);
    column[i] -= share * (sums[last] - sums[first]);
  }
}

/// A shift of one column.
struct Shift {
  double distance = 0.0;     ///< [m]
  double strength = 0.0;     ///< correlation
  double correlation = 0.0;  ///< the same, of unit columns
};

/// One direction, with the shifts that it may have.
struct Direction {
  Eigen::Vector2d normal;
  std::vector<Shift> shifts;  ///< strongest first
};

struct LagWindow {
  int center;  ///< cells
  int half;    ///< cells
};

LagWindow lag_window(const Eigen::Vector2d& normal, const MotionGuess& guess,
                     const HoughAlignmentOptions& options) {
  constexpr int kMargin = 3;  // cells, so that a peak at the end is seen as one
  const double variance = normal.dot(guess.covariance.topLeftCorner<2, 2>() * normal);
  const double reach =
      std::min(options.max_window_xy, options.window_sigmas * std::sqrt(std::max(0.0, variance)));
  const double center = normal.dot(guess.reference_from_scan.translation());
  return {static_cast<int>(std::lround(center / options.rho_cell)),
          static_cast<int>(std::ceil(reach / options.rho_cell)) + kMargin};
}

/// Cells of a column from the first to the last that holds anything.
struct FilledCells {
  explicit FilledCells(const std::vector<float>& column) {
    const auto is_filled = [](float cell) { return cell != 0.0F; };
    begin = std::find_if(column.begin(), column.end(), is_filled) - column.begin();
    end = column.rend() - std::find_if(column.rbegin(), column.rend(), is_filled);
  }

  std::ptrdiff_t begin;
  std::ptrdiff_t end;
};

/// Correlations of two columns for the lags of a window.
std::vector<float> correlate_columns(const std::vector<float>& reference,
                                     const std::vector<float>& scan, const LagWindow& lags) {
  const auto count = static_cast<std::ptrdiff_t>(reference.size());
  const FilledCells of_reference(reference);
  const FilledCells of_scan(scan);
  std::vector<float> correlation;
  correlation.reserve(2 * static_cast<std::size_t>(lags.half) + 1);
  for (int lag = lags.center - lags.half; lag <= lags.center + lags.half; ++lag) {
    // reference(i) = scan(i - lag)
    const std::ptrdiff_t in_reference = std::max(0, lag);
    const std::ptrdiff_t in_scan = std::max(0, -lag);
    const std::ptrdiff_t overlap = count - std::abs(lag);
    const std::ptrdiff_t begin =
        std::max({std::ptrdiff_t{0}, of_reference.begin - in_reference, of_scan.begin - in_scan});
    const std::ptrdiff_t end =
        std::min({overlap, of_reference.end - in_reference, of_scan.end - in_scan});
    correlation.push_back(
        end > begin
            ? lane_dot_between(reference.data() + in_reference, scan.data() + in_scan,
                               static_cast<std::size_t>(overlap), static_cast<std::size_t>(begin),
                               static_cast<std::size_t>(end))
            : 0.0F);
  }
  return correlation;
}

std::vector<Shift> strongest_shifts(const std::vector<float>& correlation, const LagWindow& lags,
                                    float scale, const HoughAlignmentOptions& options) {
  std::vector<Shift> shifts;
  for (std::size_t i = 1; i + 1 < correlation.size(); ++i) {
    const float here = correlation[i];
    if (here > 0.0F && here >= correlation[i - 1] && here > correlation[i + 1]) {
      const double lag = lags.center - lags.half + static_cast<double>(i) +
                         parabola_top(correlation[i - 1], here, correlation[i + 1]);
      shifts.push_back({lag * options.rho_cell, here, here / scale});
    }
  }
  std::stable_sort(shifts.begin(), shifts.end(),
                   [](const Shift& a, const Shift& b) { return a.strength > b.strength; });
  shifts.resize(std::min(shifts.size(), static_cast<std::size_t>(options.peaks)));
  return shifts;
}

/// Compares the two scans' columns.
class ColumnPair {
 public:
  ColumnPair(const HoughPoints& reference, const HoughPoints& scan, double rho_cell)
      : reference_(reference),
        scan_(scan),
        rho_cell_(rho_cell),
        half_cells_(
            std::max(hough_half_cells(reference, rho_cell), hough_half_cells(scan, rho_cell))) {}

  [[nodiscard]] Direction compare(double theta, double rotation, const MotionGuess& guess,
                                  const HoughAlignmentOptions& options) const {
    const std::vector<float> reference = column(reference_, theta);
    const std::vector<float> scan = column(scan_, theta - rotation);
    const float scale = std::sqrt(lane_dot(reference.data(), reference.data(), reference.size()) *
                                  lane_dot(scan.data(), scan.data(), scan.size()));
    Direction direction{{std::cos(theta), std::sin(theta)}, {}};
    if (scale > 0.0F) {
      const LagWindow lags = lag_window(direction.normal, guess, options);
      direction.shifts =
          strongest_shifts(correlate_columns(reference, scan, lags), lags, scale, options);
    }
    return direction;
  }

 private:
  [[nodiscard]] std::vector<float> column(const HoughPoints& points, double theta) const {
    std::vector<float> made = hough_column(points, theta, rho_cell_, half_cells_);
    sharpen(made, rho_cell_);
    return made;
  }

  const HoughPoints& reference_;
  const HoughPoints& scan_;
  double rho_cell_;
  int half_cells_;
};

// --- translation ---

/// The columns in which both scans, one turned to the other, are strong, at some distance of each
/// other, one of them about across the strongest.
std::vector<double> strong_directions(const std::vector<float>& reference,
                                      const std::vector<float>& scan, double rotation,
                                      const HoughAlignmentOptions& options) {
  const auto count = static_cast<int>(reference.size());
  const HoughGrid grid{count, options.rho_cell};
  std::vector<std::pair<float, int>> common;
  for (int k = 0; k < count; ++k) {
    const double turned = k - rotation / grid.angle(1.0);
    const double below = std::floor(turned);
    const auto share = static_cast<float>(turned - below);
    const int i = ((static_cast<int>(below) % count) + count) % count;
    const float there = (1.0F - share) * scan[static_cast<std::size_t>(i)] +
                        share * scan[static_cast<std::size_t>((i + 1) % count)];
    common.emplace_back(reference[static_cast<std::size_t>(k)] * there, k);
  }
  std::stable_sort(common.begin(), common.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  const auto apart = [](double a, double b) { return std::abs(std::remainder(a - b, kPi)); };
  std::vector<double> chosen = {grid.angle(common.front().second)};
  // Beside a long wall all columns are shoulders of the wall's, except those along it.
  for (const bool is_across : {true, false}) {
    for (const auto& candidate : common) {
      const double angle = grid.angle(candidate.second);
      const bool is_new = std::all_of(chosen.begin(), chosen.end(), [&](double other) {
        return apart(angle, other) >= options.direction_spacing;
      });
      const bool is_wanted =
          !is_across || apart(angle, chosen.front() + 0.5 * kPi) <= options.direction_spacing;
      if (is_new && is_wanted) {
        chosen.push_back(angle);
      }
      if (chosen.size() == static_cast<std::size_t>(options.directions) ||
          (is_across && chosen.size() == 2)) {
        break;
      }
    }
  }
  return chosen;
}

/// Tries all combinations of one shift a direction, or none, and keeps those that agree.
class ShiftCombinations {
 public:
  ShiftCombinations(const std::vector<Direction>& directions, const MotionGuess& guess,
                    double rotation, const HoughAlignmentOptions& options)
      : directions_(directions),
        guess_(guess.reference_from_scan.translation()),
        rotation_(rotation),
        tolerance_(options.residual_cells * options.rho_cell),
        fewest_(std::min<std::size_t>(3, directions.size())) {
    for (const Direction& direction : directions) {
      strongest_ = std::max(strongest_, direction.shifts.front().strength);
    }
    chosen_.reserve(directions.size());
    // Where few directions hold anything, or all disagree, fewer must do; the ranking by likelihood
    // then sorts out what fits by chance.
    for (; found_.empty() && fewest_ > 0; --fewest_) {
      descend(0);
    }
  }

  [[nodiscard]] std::vector<HoughAlignment> take() { return std::move(found_); }

 private:
  struct Chosen {
    Eigen::Vector2d normal;
    double offset;  ///< of the guess [m]
    double weight;
    double correlation;
  };

  void descend(std::size_t level) {
    const std::size_t left = directions_.size() - level;
    if (chosen_.size() + left < fewest_) {
      return;
    }
    if (left == 0) {
      solve();
      return;
    }
    const Direction& direction = directions_[level];
    for (const Shift& shift : direction.shifts) {
      const Chosen next{direction.normal, shift.distance - direction.normal.dot(guess_),
                        shift.strength / strongest_, shift.correlation};
      if (may_agree(next)) {
        chosen_.push_back(next);
        descend(level + 1);
        chosen_.pop_back();
      }
    }
    descend(level + 1);
  }

  /// False where no translation is within the tolerance of the shift and of two that are chosen:
  /// the third normal is a sum of the other two, and so is what its shift would have to be. Most
  /// combinations end here, before they are solved.
  [[nodiscard]] bool may_agree(const Chosen& next) const {
    constexpr double kPairRounding = 1.0 + 1e-9;
    const auto cross = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
      return a.x() * b.y() - a.y() * b.x();
    };
    for (std::size_t i = 0; i + 1 < chosen_.size(); ++i) {
      for (std::size_t j = i + 1; j < chosen_.size(); ++j) {
        const double of_next = cross(chosen_[i].normal, chosen_[j].normal);
        const double of_i = cross(next.normal, chosen_[j].normal);
        const double of_j = cross(chosen_[i].normal, next.normal);
        const double apart =
            of_next * next.offset - of_i * chosen_[i].offset - of_j * chosen_[j].offset;
        if (std::abs(apart) >
            kPairRounding * tolerance_ * (std::abs(of_next) + std::abs(of_i) + std::abs(of_j))) {
          return false;
        }
      }
    }
    return true;
  }

  /// Weighted least squares for the translation. Where the columns hold it in one direction only,
  /// the other one is the guess's.
  void solve() {
    constexpr double kMinEigenvalueRatio = 0.01;  // eigenvalue over the largest one
    HoughAlignment alignment;
    Eigen::Vector2d right = Eigen::Vector2d::Zero();
    for (const Chosen& one : chosen_) {
      alignment.information += one.weight * one.normal * one.normal.transpose();
      right += one.weight * one.offset * one.normal;
      alignment.vote += one.correlation;
    }
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver;
    solver.computeDirect(alignment.information);
    Eigen::Vector2d offset = Eigen::Vector2d::Zero();
    for (int i = 0; i < 2; ++i) {
      const double strength = solver.eigenvalues()(i);
      if (strength > kMinEigenvalueRatio * solver.eigenvalues()(1)) {
        const Eigen::Vector2d axis = solver.eigenvectors().col(i);
        offset += axis * (axis.dot(right) / strength);
      }
    }
    for (const Chosen& one : chosen_) {
      if (std::abs(one.normal.dot(offset) - one.offset) > tolerance_) {
        return;
      }
    }
    alignment.reference_from_scan = {guess_.x() + offset.x(), guess_.y() + offset.y(), rotation_};
    found_.push_back(alignment);
  }

  const std::vector<Direction>& directions_;
  Eigen::Vector2d guess_;
  double rotation_;
  double tolerance_;
  std::size_t fewest_;
  double strongest_ = 0.0;
  std::vector<Chosen> chosen_;
  std::vector<HoughAlignment> found_;
};

/// The ones with most votes, each farther than the tolerance from those before.
std::vector<HoughAlignment> best_of(std::vector<HoughAlignment> all,
                                    const HoughAlignmentOptions& options) {
  std::stable_sort(all.begin(), all.end(), [](const HoughAlignment& a, const HoughAlignment& b) {
    return a.vote > b.vote;
  });
  const double apart = options.residual_cells * options.rho_cell;
  std::vector<HoughAlignment> best;
  for (const HoughAlignment& one : all) {
    const Eigen::Vector2d here = one.reference_from_scan.translation();
    const bool is_new = std::all_of(best.begin(), best.end(), [&](const HoughAlignment& other) {
      return (other.reference_from_scan.translation() - here).norm() > apart;
    });
    if (is_new) {
      best.push_back(one);
    }
    if (best.size() == static_cast<std::size_t>(options.translations)) {
      break;
    }
  }
  return best;
}

std::vector<Direction> compare_directions(const ColumnPair& columns,
                                          const std::vector<double>& angles, double rotation,
                                          const MotionGuess& guess,
                                          const HoughAlignmentOptions& options) {
  std::vector<Direction> directions;
  double strongest = 0.0;
  for (const double angle : angles) {
    Direction direction = columns.compare(angle, rotation, guess, options);
    if (!direction.shifts.empty()) {
      strongest = std::max(strongest, direction.shifts.front().strength);
      directions.push_back(std::move(direction));
    }
  }
  directions.erase(std::remove_if(directions.begin(), directions.end(),
                                  [&](const Direction& direction) {
                                    return direction.shifts.front().strength <
                                           options.weakest_column * strongest;
                                  }),
                   directions.end());
  return directions;
}

}  // namespace

std::vector<RotationPeak> find_rotations(const std::vector<float>& correlation, double guess,
                                         double sigma, const HoughAlignmentOptions& options) {
  const auto count = static_cast<int>(correlation.size());
  const double column = HoughGrid{count, 0.0}.angle(1.0);
  const double reach = options.window_sigmas * sigma + 2.0 * column;
  const auto at = [&](int k) {
    return static_cast<double>(correlation[static_cast<std::size_t>((k + count) % count)]);
  };
  const auto rank = [&](const RotationPeak& peak) {
    const double sigmas = wrap_angle(peak.angle - guess) / std::max(sigma, column);
    return peak.correlation - 0.5 * options.rotation_prior_weight * prior_penalty(sigmas * sigmas);
  };
  std::vector<RotationPeak> peaks;
  for (int k = 0; k < count; ++k) {
    if (at(k) < at(k - 1) || at(k) <= at(k + 1)) {
      continue;
    }
    const double angle = (k + parabola_top(at(k - 1), at(k), at(k + 1))) * column;
    for (const double turned : {wrap_angle(angle), wrap_angle(angle + kPi)}) {
      if (std::abs(wrap_angle(turned - guess)) <= reach) {
        peaks.push_back({turned, at(k)});
      }
    }
  }
  if (peaks.empty()) {
    peaks.push_back({guess, 0.0});
  }
  std::stable_sort(peaks.begin(), peaks.end(),
                   [&](const RotationPeak& a, const RotationPeak& b) { return rank(a) > rank(b); });
  peaks.resize(std::min(peaks.size(), static_cast<std::size_t>(options.rotations)));
  return peaks;
}

std::vector<HoughAlignment> align_in_hough_domain(const HoughPoints& reference,
                                                  const HoughPoints& scan, const MotionGuess& guess,
                                                  const HoughAlignmentOptions& options) {
  if (reference.empty() || scan.empty()) {
    return {};
  }
  const HoughGrid grid{options.angles, options.rho_cell};
  const SpectrumKind kind =
      options.spectrum == "maximum" ? SpectrumKind::kMaximum : SpectrumKind::kEnergy;
  const std::vector<float> reference_spectrum = hough_spectrum(reference, grid, kind);
  const std::vector<float> scan_spectrum = hough_spectrum(scan, grid, kind);
  const std::vector<RotationPeak> rotations = find_rotations(
      correlate_spectra(reference_spectrum, scan_spectrum), guess.reference_from_scan.theta,
      std::sqrt(std::max(0.0, guess.covariance(2, 2))), options);
  const ColumnPair columns(reference, scan, options.rho_cell);
  std::vector<HoughAlignment> alignments;
  for (const RotationPeak& rotation : rotations) {
    const std::vector<Direction> directions = compare_directions(
        columns, strong_directions(reference_spectrum, scan_spectrum, rotation.angle, options),
        rotation.angle, guess, options);
    if (directions.empty()) {
      continue;
    }
    const std::vector<HoughAlignment> best =
        best_of(ShiftCombinations(directions, guess, rotation.angle, options).take(), options);
    alignments.insert(alignments.end(), best.begin(), best.end());
  }
  return alignments;
}

}  // namespace matchbox_slam
