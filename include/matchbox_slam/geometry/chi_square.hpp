#pragma once

namespace matchbox_slam {

/// Of poses that are as their covariance says 0.1 % are farther off, by the squared distance in
/// standard deviations: chi-square of three degrees of freedom.
constexpr double kMostChiSquare = 16.27;

}  // namespace matchbox_slam
