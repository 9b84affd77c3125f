#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/map/likelihood_field.hpp"
#include "matchbox_slam/matching/correspondences.hpp"
#include "matchbox_slam/matching/pose_prior.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"

namespace matchbox_slam {

struct RefinementOptions {
  int iterations = 12;
  double first_kernel = 0.15;
  double last_kernel = 0.03;
  double noise = 0.01;
  double weakest_direction = 0.005;
  double weakest_facing = 0.001;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor&& option) {
    option(self.iterations, "refine_iterations", between(0, 100), "",
           "Gauss-Newton steps at most; 0 leaves the search's answer as it is.");
    option(self.first_kernel, "refine_first_kernel", between(1e-3, 1.0), "m",
           "Width of the robust kernel at the first step; it narrows from step to step.");
    option(
        self.last_kernel, "refine_last_kernel", between(1e-3, 1.0), "m",
        "Width of the robust kernel at the last steps: points farther than this from a wall count "
        "little.");
    option(self.noise, "refine_noise", between(1e-4, 1.0), "m",
           "Standard deviation of a point's distance to its wall, before the scan shows its own.");
    option(self.weakest_direction, "weakest_direction", between(0.0, 1.0), "",
           "A direction of translation of which scan and map confirm each other less than this "
           "share of the strongest direction's information counts as unconstrained, unless walls "
           "clearly face it.");
    option(self.weakest_facing, "weakest_facing", between(0.0, 1.0), "",
           "Share of the strongest direction's information that walls which clearly face a "
           "direction have to tell, so that it counts as constrained, where points are as noisy as "
           "refine_noise; it changes with the square of their variance.");
  }
};

/// What the covariance of a search's answer has to hold where nothing refines it: the pose is but
/// the nearest of those that the search tells apart, which errors are uniform between.
/// @param step_xy, step_theta  [m], [rad] from one such pose to the next.
[[nodiscard]] Eigen::Matrix3d step_covariance(double step_xy, double step_theta);

struct RefinedPose {
  Pose2 map_from_base;
  Eigen::Matrix3d covariance;  ///< of prior and scan together, over (x, y, theta) in the map frame
  double score = 0.0;          ///< mean closeness of the points to the map's walls, 0...1
  std::vector<Eigen::Vector2d> unconstrained_directions;  ///< unit vectors, map frame
};

/// Moves a pose that is a few cells off to where scan, map and prior agree best, far below the size
/// of a cell: Gauss-Newton on the distances from the points to the walls next to them, under a
/// robust kernel that narrows from step to step (point to line: Censi 2008). Directions that the
/// scan does not constrain keep the prior's value and variance. A prior that turns out far off
/// (prior_penalty) counts less, also in the covariance, and so is told to be less sure in these
/// directions. The covariance is scaled by the variance of the residuals that are left, as in least
/// squares of unknown precision. Cost: one look-up a point and step.
/// @param pairs  the scan next to what it is matched to, at the pose to start from; is at the
///               refined one afterwards.
[[nodiscard]] RefinedPose refine(Correspondences& pairs, const Pose2& start_map_from_base,
                                 const PosePrior& prior, const RefinementOptions& options);
[[nodiscard]] inline RefinedPose refine(const std::vector<ScanPoint>& points,
                                        const PlacedFields& fields,
                                        const Pose2& start_map_from_base, const PosePrior& prior,
                                        const RefinementOptions& options) {
  Correspondences pairs(points, fields, start_map_from_base);
  return refine(pairs, start_map_from_base, prior, options);
}
[[nodiscard]] inline RefinedPose refine(const std::vector<ScanPoint>& points,
                                        const LikelihoodField& field,
                                        const Pose2& start_map_from_base, const PosePrior& prior,
                                        const RefinementOptions& options) {
  return refine(points, PlacedFields{{&field, Pose2{}}}, start_map_from_base, prior, options);
}

/// Probability of the poses around one pose, given scan and prior.
class LocalPosterior {
 public:
  /// @param pairs  at the pose; outlives this.
  LocalPosterior(const Correspondences& pairs, const Pose2& map_from_base, const PosePrior& prior,
                 const RefinementOptions& options);

  /// Negative logarithm of the probability a small step (x, y, theta) away, over that at the pose.
  [[nodiscard]] double cost(const Eigen::Vector3d& step) const;

  /// The same of many steps and their opposites at once; see Correspondences.
  void costs_of_both(const std::vector<Eigen::Vector3d>& steps,
                     std::vector<std::array<double, 2>>& costs) const;

 private:
  [[nodiscard]] double prior_cost(const Eigen::Vector3d& step) const;

  const Correspondences& correspondences_;
  Eigen::Matrix3d prior_information_;
  Eigen::Vector3d off_prior_;
  double kernel_;
  double scan_information_;  ///< of a point [1/m^2]
  double cost_here_;
};

}  // namespace matchbox_slam
