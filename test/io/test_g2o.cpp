#include <gtest/gtest.h>

#include <Eigen/LU>
#include <sstream>
#include <string>

#include "graph/random_graphs.hpp"
#include "io/g2o.hpp"
#include "io/temporary_folder.hpp"
#include "matchbox_slam/graph/optimise.hpp"
#include "matchbox_slam/io/file.hpp"

namespace matchbox_slam {
namespace {

/// What g2o makes of the text, and the chi-square of each edge as it reckons: the error is
/// z^-1 * (a^-1 * b).
struct G2o {
  PoseGraph graph;
  std::vector<double> chi_square;

  explicit G2o(const std::string& text) {
    std::istringstream lines(text);
    std::size_t fixed = 1;
    for (std::string kind; lines >> kind;) {
      std::size_t id = 0;
      Pose2 pose;
      if (kind == "FIX") {
        lines >> fixed;
      } else if (kind == "VERTEX_SE2") {
        lines >> id >> pose.x >> pose.y >> pose.theta;
        EXPECT_EQ(id, graph.poses.size());
        graph.poses.push_back(pose);
      } else {
        EXPECT_EQ(kind, "EDGE_SE2");
        PoseEdge edge;
        lines >> edge.from >> edge.to >> edge.from_to.x >> edge.from_to.y >> edge.from_to.theta;
        Eigen::Matrix3d information;
        for (int row = 0; row < 3; ++row) {
          for (int column = row; column < 3; ++column) {
            lines >> information(row, column);
            information(column, row) = information(row, column);
          }
        }
        graph.edges.push_back(edge);
        const Pose2 error =
            edge.from_to.inverse() * (graph.poses[edge.from].inverse() * graph.poses[edge.to]);
        const Eigen::Vector3d values(error.x, error.y, error.theta);
        chi_square.push_back(values.dot(information * values));
      }
    }
    EXPECT_TRUE(lines.eof()) << "a line of another form";
    EXPECT_EQ(fixed, 0U);
  }
};

TEST(G2o, SaysTheSameAsTheGraph) {
  RandomGraphOptions options;
  options.wrong = 0.3;
  OptimisedGraph made = optimise(random_graph(3, options).graph);
  for (PoseEdge& edge : made.graph.edges) {
    edge.covariance(0, 0) *= 3.0;
    edge.covariance(1, 2) = edge.covariance(2, 1) = 1e-4;
  }
  made = optimise(made.graph);
  const G2o read(to_g2o(made.graph));
  EXPECT_EQ(read.graph.poses, made.graph.poses);
  std::size_t at = 0;
  for (std::size_t i = 0; i < made.graph.edges.size(); ++i) {
    const PoseEdge& edge = made.graph.edges[i];
    if (is_used(edge)) {
      ASSERT_LT(at, read.graph.edges.size());
      EXPECT_EQ(read.graph.edges[at].from, edge.from);
      EXPECT_EQ(read.graph.edges[at].to, edge.to);
      EXPECT_EQ(read.graph.edges[at].from_to, edge.from_to);
      EXPECT_NEAR(read.chi_square[at], made.chi_square[i], 1e-9 * (1.0 + made.chi_square[i]));
      ++at;
    }
  }
  EXPECT_EQ(at, read.graph.edges.size());
  EXPECT_LT(at, made.graph.edges.size()) << "no loop is an outlier";
}

TEST(G2o, IsWrittenToAFile) {
  const TemporaryFolder folder;
  PoseGraph graph;
  graph.poses = {{0.5, -2.0, 0.25}};
  write_g2o(folder / "graph.g2o", graph);
  EXPECT_EQ(read_file(folder / "graph.g2o"), "VERTEX_SE2 0 0.5 -2 0.25\nFIX 0\n");
}

}  // namespace
}  // namespace matchbox_slam
