#include "graph/graph_information.hpp"

#include <algorithm>
#include <stdexcept>

namespace matchbox_slam {
namespace {

using Index = Eigen::Index;
using Sparse = Eigen::SparseMatrix<double>;

/// The entries of the inverse of L D Lᵀ where L has entries, below its diagonal, and the diagonal;
/// L's own is 1 and not stored (Takahashi, Fagan and Chen 1973).
struct SparseInverse {
  Sparse below;
  Eigen::VectorXd diagonal;

  SparseInverse(const Sparse& lower, const Eigen::VectorXd& d)
      : below(lower), diagonal(d.cwiseInverse()) {
    const auto* starts = below.outerIndexPtr();
    const auto* rows = below.innerIndexPtr();
    double* values = below.valuePtr();
    const double* l = lower.valuePtr();
    Eigen::VectorXi place = Eigen::VectorXi::Constant(lower.rows(), -1);  // of a row in column j
    for (Index j = lower.cols() - 1; j >= 0; --j) {
      for (auto a = starts[j]; a < starts[j + 1]; ++a) {
        values[a] = 0.0;
        place[rows[a]] = a;
      }
      for (auto a = starts[j]; a < starts[j + 1]; ++a) {
        const Index k = rows[a];
        values[a] -= l[a] * diagonal[k];
        for (auto b = starts[k]; b < starts[k + 1]; ++b) {
          const auto other = place[rows[b]];
          if (other >= 0) {
            values[other] -= l[a] * values[b];
            values[a] -= l[other] * values[b];
          }
        }
      }
      for (auto a = starts[j]; a < starts[j + 1]; ++a) {
        diagonal[j] -= l[a] * values[a];
        place[rows[a]] = -1;
      }
    }
  }

  [[nodiscard]] double at(Index row, Index column) const {
    return row == column ? diagonal[row]
                         : below.coeff(std::max(row, column), std::min(row, column));
  }
};

}  // namespace

GraphInformation::GraphInformation(const PoseGraph& graph, const Terms& terms)
    : nodes_(graph.poses.size()) {
  factor_.compute(add_edges(graph, terms));
  if (factor_.info() != Eigen::Success) {
    throw std::invalid_argument(
        "pose graph: its covariances differ too much to be computed with; give the smallest more, "
        "or the largest less");
  }
}

/// How many rows each column of the lower half has at most.
Eigen::VectorXi GraphInformation::count_rows(const PoseGraph& graph) const {
  Eigen::VectorXi rows = Eigen::VectorXi::Constant(3 * static_cast<Index>(nodes_ - 1), 3);
  for (const PoseEdge& edge : graph.edges) {
    if (edge.from != kFixed && edge.to != kFixed) {
      rows.segment<3>(std::min(first_of(edge.from), first_of(edge.to))).array() += 3;
    }
  }
  return rows;
}

Eigen::SparseMatrix<double> GraphInformation::add_edges(const PoseGraph& graph,
                                                        const Terms& terms) {
  const Index size = 3 * static_cast<Index>(nodes_ - 1);
  gradient_.setZero(size);
  Sparse information(size, size);
  information.reserve(count_rows(graph));
  const auto add = [&](Index row, Index column, const Eigen::Matrix3d& block) {
    for (Index i = 0; i < 3; ++i) {
      for (Index j = 0; j < 3; ++j) {
        if (row + i >= column + j) {
          information.coeffRef(row + i, column + j) += block(i, j);
        }
      }
    }
  };
  for (const PoseEdge& edge : graph.edges) {
    if (!is_used(edge) || (terms.motion_only && edge.kind == EdgeKind::kLoop)) {
      continue;
    }
    const Eigen::Matrix3d root = information_root(covariance_with_drift(edge, terms.drift_share));
    const EdgeError error = edge_error(graph, edge);
    const Eigen::Vector3d weighed = root * error.error;
    chi_square_ += weighed.squaredNorm();
    const Eigen::Matrix3d by_from = root * error.by_from;
    const Eigen::Matrix3d by_to = root * error.by_to;
    const Index from = first_of(edge.from);
    const Index to = first_of(edge.to);
    if (edge.from != kFixed) {
      add(from, from, by_from.transpose() * by_from);
      gradient_.segment<3>(from) -= by_from.transpose() * weighed;
    }
    if (edge.to != kFixed) {
      add(to, to, by_to.transpose() * by_to);
      gradient_.segment<3>(to) -= by_to.transpose() * weighed;
    }
    if (edge.from != kFixed && edge.to != kFixed) {
      if (from > to) {
        add(from, to, by_from.transpose() * by_to);
      } else {
        add(to, from, by_to.transpose() * by_from);
      }
    }
  }
  information.makeCompressed();
  return information;
}

GraphInformation::Change GraphInformation::covariance_with(const PoseEdge& edge,
                                                           const EdgeError& error) const {
  Change right = Change::Zero(gradient_.size(), 3);
  if (edge.from != kFixed) {
    right.middleRows<3>(first_of(edge.from)) += error.by_from.transpose();
  }
  if (edge.to != kFixed) {
    right.middleRows<3>(first_of(edge.to)) += error.by_to.transpose();
  }
  return factor_.solve(right);
}

std::vector<Eigen::Matrix3d> GraphInformation::error_covariances(
    const PoseGraph& graph, const std::vector<std::size_t>& edges) const {
  const SparseInverse inverse(factor_.matrixL().nestedExpression(), factor_.vectorD());
  const auto& order = factor_.permutationP().indices();
  // Of poses that an edge in the information joins, and of each with itself.
  const auto block = [&](std::size_t a, std::size_t b) {
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    if (a == kFixed || b == kFixed) {
      return covariance;
    }
    for (Index i = 0; i < 3; ++i) {
      for (Index j = 0; j < 3; ++j) {
        covariance(i, j) = inverse.at(order[first_of(a) + i], order[first_of(b) + j]);
      }
    }
    return covariance;
  };
  std::vector<Eigen::Matrix3d> covariances;
  covariances.reserve(edges.size());
  for (const std::size_t i : edges) {
    const PoseEdge& edge = graph.edges[i];
    const EdgeError error = edge_error(graph, edge);
    const Eigen::Matrix3d cross =
        error.by_from * block(edge.from, edge.to) * error.by_to.transpose();
    covariances.emplace_back(
        error.by_from * block(edge.from, edge.from) * error.by_from.transpose() + cross +
        cross.transpose() + error.by_to * block(edge.to, edge.to) * error.by_to.transpose());
  }
  return covariances;
}

}  // namespace matchbox_slam
