#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/matching/hough/hough_transform.hpp"

namespace matchbox_slam {

struct HoughAlignmentOptions {
  int angles = 180;
  double rho_cell = 0.03;
  double point_spacing = 0.03;
  std::string spectrum = "energy";
  double window_sigmas = 3.0;
  double max_window_xy = 5.0;
  double rotation_prior_weight = 0.02;
  int rotations = 12;
  int directions = 4;
  double direction_spacing = 0.35;
  int peaks = 4;
  double residual_cells = 1.5;
  double weakest_column = 0.02;
  int translations = 4;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor&& option) {
    option(self.angles, "angles", between(12, 3600), "",
           "Columns of the Hough domain over the half circle.");
    option(self.rho_cell, "rho_cell", between(0.005, 0.5), "m", "Cell of a column.");
    option(self.point_spacing, "point_spacing", between(0.0, 1.0), "m",
           "Neighbouring points closer than this vote as one; 0: every point for itself.");
    option(self.spectrum, "spectrum", one_of({"energy", "maximum"}), "",
           "What of each column the rotation is found by: the sum of its squares, as in 'The Scan "
           "Matchers Research and Comparison', or its strongest cell.");
    option(self.window_sigmas, "window_sigmas", between(0.1, 10.0), "",
           "Rotations and translations are looked for up to this many of the prior's standard "
           "deviations.");
    option(self.max_window_xy, "max_window_xy", between(0.05, 100.0), "m",
           "Translations are looked for at most this far from the prediction, however wide the "
           "prior is.");
    option(self.rotation_prior_weight, "rotation_prior_weight", between(0.0, 10.0), "",
           "A rotation s standard deviations of the prior away loses half of this times s^2 in "
           "correlation.");
    option(self.rotations, "rotations", between(1, 100), "",
           "Peaks of the spectra's correlation that are tried as rotations, at most.");
    option(self.directions, "directions", between(3, 5), "",
           "Columns that each rotation's translation is found from, at most.");
    option(self.direction_spacing, "direction_spacing", between(0.01, 0.7), "rad",
           "Least difference in direction of the columns that a translation is found from.");
    option(self.peaks, "peaks", between(1, 6), "",
           "Shifts of each column that are tried, at most.");
    option(self.residual_cells, "residual_cells", between(0.1, 10.0), "cells",
           "Shifts of several columns make a translation when each agrees with it within this.");
    option(
        self.weakest_column, "weakest_column", between(0.0, 1.0), "",
        "Columns whose correlation is less than this share of the strongest one's are left out.");
    option(self.translations, "translations", between(1, 100), "",
           "Translations of each rotation that are scored, at most.");
  }
};

/// What is known of a motion before two scans are compared.
struct MotionGuess {
  Pose2 reference_from_scan;
  Eigen::Matrix3d covariance;  ///< over (x, y, theta) in the reference's frame
};

/// A motion under which the Hough domains of two scans fit.
struct HoughAlignment {
  Pose2 reference_from_scan;
  double vote = 0.0;  ///< sum of the columns' correlations
  /// What the columns say about the translation: the matrix of the least squares, with the
  /// strongest column's weight as 1 (after Censi, Iocchi and Grisetti 2005, section IV).
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
};

/// Finds the motions that take one scan to another by their Hough domains alone (Censi, Iocchi and
/// Grisetti, "Scan matching in the Hough domain", ICRA 2005), most votes first for each rotation:
/// the rotation shifts the spectrum, the translation (x, y) shifts the column of
/// theta by x cos theta + y sin theta.
/// Deviations from Censi, Iocchi and Grisetti: the columns compared are voted for anew at the exact
/// rotation, and what varies slowly in them is taken out. Cost: columns times points, then
/// rotations times directions times lags times cells.
[[nodiscard]] std::vector<HoughAlignment> align_in_hough_domain(
    const HoughPoints& reference, const HoughPoints& scan, const MotionGuess& guess,
    const HoughAlignmentOptions& options);

/// A rotation that the spectra suggest.
struct RotationPeak {
  double angle = 0.0;        ///< of the scan in the reference [rad]
  double correlation = 0.0;  ///< of the spectra, -1...1
};

/// Peaks of the spectra's correlation within the guess's window, best first, each once as it is and
/// once turned by half a circle where the window holds both.
[[nodiscard]] std::vector<RotationPeak> find_rotations(const std::vector<float>& correlation,
                                                       double guess, double sigma,
                                                       const HoughAlignmentOptions& options);

}  // namespace matchbox_slam
