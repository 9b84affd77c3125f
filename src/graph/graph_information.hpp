#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <cstddef>
#include <vector>

#include "graph/edge_error.hpp"
#include "matchbox_slam/graph/pose_graph.hpp"

namespace matchbox_slam {

/// The inverse of the covariance of all poses, linearised where they are, with the first held
/// fixed.
class GraphInformation {
 public:
  /// Of what edges tell.
  struct Terms {
    bool motion_only = false;  ///< of edges of motion alone; else of loops that are inliers, too
    double drift_share = 1.0;  ///< of the variance of drift that edges assume
  };

  GraphInformation(const PoseGraph& graph, const Terms& terms);

  /// How the error of an edge changes where the poses are changed so: `edge_error` times this.
  using Change = Eigen::Matrix<double, Eigen::Dynamic, 3>;

  /// Covariance of all poses with the error of an edge at these poses.
  [[nodiscard]] Change covariance_with(const PoseEdge& edge, const EdgeError& error) const;

  /// What a change of all poses does to an edge's error.
  template <typename Derived>
  [[nodiscard]] auto error_of(const PoseEdge& edge, const EdgeError& error,
                              const Eigen::MatrixBase<Derived>& change) const {
    Eigen::Matrix<double, 3, Derived::ColsAtCompileTime> sum;
    sum.setZero(3, change.cols());
    if (edge.from != kFixed) {
      sum += error.by_from * change.template middleRows<3>(first_of(edge.from));
    }
    if (edge.to != kFixed) {
      sum += error.by_to * change.template middleRows<3>(first_of(edge.to));
    }
    return sum;
  }

  /// The change of all poses that makes the errors least, to first order.
  [[nodiscard]] Eigen::VectorXd best_change() const { return factor_.solve(gradient_); }

  /// The chi-square there, to first order of the errors.
  [[nodiscard]] double least_chi_square() const {
    return chi_square_ - gradient_.dot(best_change());
  }

  /// Natural logarithm of its determinant.
  [[nodiscard]] double log_determinant() const { return factor_.vectorD().array().log().sum(); }

  /// The covariance of the errors of edges that are in it, for what the poses contribute.
  [[nodiscard]] std::vector<Eigen::Matrix3d> error_covariances(
      const PoseGraph& graph, const std::vector<std::size_t>& edges) const;

 private:
  [[nodiscard]] Eigen::VectorXi count_rows(const PoseGraph& graph) const;
  /// Adds the edges to gradient and chi-square, and returns the information, its lower half.
  [[nodiscard]] Eigen::SparseMatrix<double> add_edges(const PoseGraph& graph, const Terms& terms);
  /// Row; of the fixed node, which has none, any.
  [[nodiscard]] static Eigen::Index first_of(std::size_t node) {
    return node == kFixed ? 0 : 3 * static_cast<Eigen::Index>(node - 1);
  }

  static constexpr std::size_t kFixed = 0;
  std::size_t nodes_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor_;
  Eigen::VectorXd gradient_;  ///< of half the chi-square, downhill
  double chi_square_ = 0.0;   ///< of the edges, where the poses are
};

}  // namespace matchbox_slam
