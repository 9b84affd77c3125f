#pragma once

#include <string>

#include "matchbox_slam/graph/pose_graph.hpp"
#include "matchbox_slam/io/file.hpp"

namespace matchbox_slam {

/// A pose graph as g2o (Kümmerle et al. 2011) and others read it: `VERTEX_SE2 id x y theta`,
/// `FIX 0`, and `EDGE_SE2 from to x y theta` with the upper triangle of the information.
/// Outliers are left out, since others would take them for loops. g2o takes the error of an edge
/// in the frame of the measured pose, which the information is turned into. It holds all the drift
/// that is assumed, and not what loops say of it.
[[nodiscard]] std::string to_g2o(const PoseGraph& graph);

/// The same, a page at a time.
void write_g2o(const PoseGraph& graph, const ByteSink& sink);

/// Writes a file atomically. Throws FileError.
void write_g2o(const std::string& path, const PoseGraph& graph);

}  // namespace matchbox_slam
