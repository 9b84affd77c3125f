#pragma once

#include <cstddef>
#include <string>

#include "io/picture.hpp"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/matching/hough/hough_alignment.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"

namespace matchbox_slam {

/// Two scans as the Hough matcher compares them, as in figure 5 of "The Scan Matchers Research and
/// Comparison: Monte-Carlo, Olson and Hough": the Hough domain of the reference and of the scan
/// (theta to the right over the half circle, rho up, dark where many points vote), their spectra
/// over the same theta (the scan's dashed), and below the spectra's correlation over the rotation
/// from -90 to 90 degrees.
[[nodiscard]] Picture draw_hough_domains(const PointScan& reference, const PointScan& scan,
                                         const HoughAlignmentOptions& options);

/// Comparisons that `--debug` draws at most.
constexpr std::size_t kMostHoughPictures = 20;

/// The same as a file of `--debug`: FOLDER/hough_NUMBER.png.
[[nodiscard]] FileContents hough_picture_file(const std::string& folder, std::size_t number,
                                              const PointScan& reference, const PointScan& scan,
                                              const HoughAlignmentOptions& options);

}  // namespace matchbox_slam
