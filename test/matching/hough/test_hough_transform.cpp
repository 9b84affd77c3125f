#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>

#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/geometry/angles.hpp"
#include "matchbox_slam/matching/hough/hough_transform.hpp"
#include "matching/match_scene.hpp"

namespace matchbox_slam {
namespace {

constexpr HoughGrid kGrid{180, 0.03};
constexpr double kSpacing = 0.03;

const std::vector<ScanPoint>& rooms_points() { return rooms_scene().scan.points; }

/// The votes as they lie in another frame.
HoughPoints moved(const HoughPoints& points, const Pose2& to_from_points) {
  HoughPoints result = points;
  result.reach = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d point =
        to_from_points *
        Eigen::Vector2d(static_cast<double>(points.x[i]), static_cast<double>(points.y[i]));
    result.x[i] = static_cast<float>(point.x());
    result.y[i] = static_cast<float>(point.y());
    result.reach = std::max(result.reach, point.norm());
  }
  return result;
}

HoughPoints votes_of(const std::vector<std::array<float, 3>>& votes) {
  HoughPoints points;
  for (const auto& [x, y, weight] : votes) {
    points.x.push_back(x);
    points.y.push_back(y);
    points.weight.push_back(weight);
    points.reach =
        std::max(points.reach, std::hypot(static_cast<double>(x), static_cast<double>(y)));
  }
  return points;
}

ScanPoint at(double x, double y, bool joined = false) {
  ScanPoint point;
  point.position = {x, y};
  point.origin = Eigen::Vector2d::Zero();
  point.joined_to_next = joined;
  return point;
}

TEST(HoughColumn, SplitsEachVoteOnTheRightSide) {
  const std::vector<float> above = hough_column(votes_of({{0.01F, 5.0F, 1.0F}}), 0.0, 0.03, 4);
  EXPECT_NEAR(above[4], 2.0 / 3.0, 1e-5);
  EXPECT_NEAR(above[5], 1.0 / 3.0, 1e-5);
  const std::vector<float> below = hough_column(votes_of({{-0.01F, 5.0F, 1.0F}}), 0.0, 0.03, 4);
  EXPECT_NEAR(below[4], 2.0 / 3.0, 1e-5);
  EXPECT_NEAR(below[3], 1.0 / 3.0, 1e-5);
}

TEST(HoughColumn, IsTheSumOverAllPointsByBruteForce) {
  const HoughPoints points = hough_points(rooms_points(), kSpacing);
  const int half = hough_half_cells(points, kGrid.rho_cell);
  for (const double theta : {0.0, 0.3, 1.57, 3.0, -2.0}) {
    std::vector<double> expected(2 * static_cast<std::size_t>(half) + 1, 0.0);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double rho = static_cast<double>(points.x[i]) * std::cos(theta) +
                         static_cast<double>(points.y[i]) * std::sin(theta);
      for (int cell = -half; cell <= half; ++cell) {
        const double away = std::abs(rho / kGrid.rho_cell - cell);
        const auto at = static_cast<std::size_t>(cell) + static_cast<std::size_t>(half);
        expected[at] += static_cast<double>(points.weight[i]) * std::max(0.0, 1.0 - away);
      }
    }
    const std::vector<float> column = hough_column(points, theta, kGrid.rho_cell, half);
    ASSERT_EQ(column.size(), expected.size());
    for (std::size_t i = 0; i < column.size(); ++i) {
      ASSERT_NEAR(column[i], expected[i], 2e-4) << i;
    }
  }
}

TEST(HoughColumn, IsMirroredHalfACircleOn) {
  const HoughPoints points = hough_points(rooms_points(), kSpacing);
  const int half = hough_half_cells(points, kGrid.rho_cell);
  std::vector<float> there = hough_column(points, 0.7 + kPi, kGrid.rho_cell, half);
  std::reverse(there.begin(), there.end());
  const std::vector<float> here = hough_column(points, 0.7, kGrid.rho_cell, half);
  for (std::size_t i = 0; i < here.size(); ++i) {
    ASSERT_NEAR(here[i], there[i], 2e-4);
  }
}

// Equation 4 of "The Scan Matchers Research and Comparison: Monte-Carlo, Olson and Hough", and what
// makes the translation visible: HT_ref(theta, rho) = HT_cur(theta - phi, rho - t n(theta)).
TEST(HoughColumn, ShiftsByTheMotionAlongItsNormal) {
  const HoughPoints scan = hough_points(rooms_points(), kSpacing);
  const double phi = 0.37;
  for (const double theta : {0.0, 0.5, 1.2, 2.9}) {
    // A motion by whole cells along this normal, and by anything across it.
    const int cells = 17;
    const Eigen::Vector2d normal(std::cos(theta), std::sin(theta));
    const Eigen::Vector2d t =
        cells * kGrid.rho_cell * normal + 0.4 * Eigen::Vector2d(-normal.y(), normal.x());
    const HoughPoints reference = moved(scan, {t.x(), t.y(), phi});
    const int half = hough_half_cells(reference, kGrid.rho_cell) + cells + 30;
    const std::vector<float> a = hough_column(reference, theta, kGrid.rho_cell, half);
    const std::vector<float> b = hough_column(scan, theta - phi, kGrid.rho_cell, half);
    for (std::size_t i = cells; i < a.size(); ++i) {
      ASSERT_NEAR(a[i], b[i - cells], 1e-3) << theta << " " << i;
    }
  }
}

TEST(HoughSpectrum, IsTheEnergyOrTheMaximumOfEachColumn) {
  const HoughPoints points = hough_points(rooms_points(), kSpacing);
  const std::vector<float> energy = hough_spectrum(points, kGrid, SpectrumKind::kEnergy);
  const std::vector<float> maximum = hough_spectrum(points, kGrid, SpectrumKind::kMaximum);
  ASSERT_EQ(energy.size(), 180U);
  const int half = hough_half_cells(points, kGrid.rho_cell);
  for (const std::size_t k : {0U, 45U, 90U, 179U}) {
    const std::vector<float> column =
        hough_column(points, degrees_to_radians(static_cast<double>(k)), kGrid.rho_cell, half);
    const float sum = std::inner_product(column.begin(), column.end(), column.begin(), 0.0F);
    EXPECT_NEAR(energy[k], sum, 1e-4 * static_cast<double>(sum));
    EXPECT_EQ(maximum[k], *std::max_element(column.begin(), column.end()));
  }
}

TEST(HoughSpectrum, StaysWhenTheScanMoves) {
  const HoughPoints scan = hough_points(rooms_points(), kSpacing);
  const std::vector<float> before = hough_spectrum(scan, kGrid, SpectrumKind::kEnergy);
  for (const Eigen::Vector2d& t : {Eigen::Vector2d(0.6, -0.3), Eigen::Vector2d(1.0, 2.0)}) {
    const std::vector<float> after =
        hough_spectrum(moved(scan, {t.x(), t.y(), 0.0}), kGrid, SpectrumKind::kEnergy);
    const std::vector<float> correlation = correlate_spectra(before, after);
    // How votes are split between cells changes, and nothing else.
    EXPECT_GT(correlation[0], 0.99F);
    EXPECT_EQ(std::max_element(correlation.begin(), correlation.end()), correlation.begin());
  }
}

TEST(HoughSpectrum, ShiftsWhenTheScanTurns) {
  const HoughPoints scan = hough_points(rooms_points(), kSpacing);
  for (const SpectrumKind kind : {SpectrumKind::kEnergy, SpectrumKind::kMaximum}) {
    const std::vector<float> before = hough_spectrum(scan, kGrid, kind);
    const int columns = 23;
    const std::vector<float> after =
        hough_spectrum(moved(scan, {0.0, 0.0, kGrid.angle(columns)}), kGrid, kind);
    for (std::size_t k = 0; k < 180; ++k) {
      const float expected = before[(k + 180 - columns) % 180];
      ASSERT_NEAR(after[k], expected, 2e-3 * static_cast<double>(expected));
    }
    const std::vector<float> correlation = correlate_spectra(after, before);
    EXPECT_EQ(std::max_element(correlation.begin(), correlation.end()) - correlation.begin(),
              columns);
  }
}

TEST(CorrelateSpectra, IsPearsonsByBruteForce) {
  Random random(1);
  std::vector<float> a(37);
  std::vector<float> b(37);
  for (std::size_t i = 0; i < a.size(); ++i) {
    a[i] = static_cast<float>(random.uniform());
    b[i] = static_cast<float>(random.uniform());
  }
  const auto mean = [](const std::vector<float>& v) {
    return std::accumulate(v.begin(), v.end(), 0.0) / static_cast<double>(v.size());
  };
  const std::vector<float> correlation = correlate_spectra(a, b);
  for (std::size_t shift = 0; shift < a.size(); ++shift) {
    double ab = 0.0;
    double aa = 0.0;
    double bb = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      const double x = static_cast<double>(a[(i + shift) % a.size()]) - mean(a);
      const double y = static_cast<double>(b[i]) - mean(b);
      ab += x * y;
      aa += x * x;
      bb += y * y;
    }
    EXPECT_NEAR(correlation[shift], ab / std::sqrt(aa * bb), 1e-5);
  }
  const std::vector<float> flat = correlate_spectra(std::vector<float>(37, 1.0F), b);
  EXPECT_EQ(flat, std::vector<float>(37, 0.0F)) << "a spectrum without shape says nothing";
}

TEST(HoughPoints, WeighsPointsByTheirPieceOfWall) {
  std::vector<ScanPoint> points;
  for (int i = 0; i < 100; ++i) {
    points.push_back(at(1.0, 0.005 * i));  // a near wall of half a metre ...
  }
  for (int i = 0; i < 6; ++i) {
    points.push_back(at(10.0, 0.1 * i));  // ... and a far one
  }
  const HoughPoints votes = hough_points(points, 0.0);
  double near = 0.0;
  double far = 0.0;
  for (std::size_t i = 0; i < votes.size(); ++i) {
    (votes.x[i] < 5.0F ? near : far) += static_cast<double>(votes.weight[i]);
  }
  EXPECT_NEAR(near, 0.495, 1e-5);
  EXPECT_NEAR(far, 0.5, 1e-5);
}

TEST(HoughPoints, LeavesOutJumpEdgesAndWhatIsNoNumber) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const HoughPoints votes =
      hough_points({at(1.0, 0.0), at(1.0, 0.1), at(2.5, 0.2) /* between two surfaces */,
                    at(4.0, 0.3), at(4.0, 0.4), at(nan, 1.0), at(1e30, 0.0), at(-1e300, 0.0)},
                   0.0);
  ASSERT_EQ(votes.size(), 4U);
  EXPECT_LT(votes.reach, 4.1);
  EXPECT_TRUE(hough_points({at(1.0, 0.0)}, 0.0).empty());
  EXPECT_TRUE(hough_points({}, 0.0).empty());
}

TEST(HoughPoints, KeepsTheGapsOfOneWall) {
  const HoughPoints votes = hough_points({at(5.0, 0.0, true), at(5.0, 0.25)}, 0.0);
  ASSERT_EQ(votes.size(), 2U);
  EXPECT_NEAR(votes.weight[0], 0.125, 1e-6);
  EXPECT_TRUE(hough_points({at(5.0, 0.0, false), at(5.0, 0.25)}, 0.0).empty());
}

TEST(HoughPoints, MergesNeighboursIntoTheirMiddle) {
  std::vector<ScanPoint> points;
  for (int i = 0; i < 40; ++i) {
    points.push_back(at(2.0, 0.01 * i));
  }
  const HoughPoints merged = hough_points(points, 0.035);
  EXPECT_EQ(merged.size(), 10U);
  double moment = 0.0;
  double total = 0.0;
  for (std::size_t i = 0; i < merged.size(); ++i) {
    moment += static_cast<double>(merged.weight[i]) * static_cast<double>(merged.y[i]);
    total += static_cast<double>(merged.weight[i]);
  }
  EXPECT_NEAR(total, 0.39, 1e-5);
  EXPECT_NEAR(moment / total, 0.195, 1e-5);
}

}  // namespace
}  // namespace matchbox_slam
