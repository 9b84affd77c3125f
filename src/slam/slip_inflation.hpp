#pragma once

#include <cstddef>
#include <vector>

#include "matchbox_slam/graph/pose_graph.hpp"
#include "matchbox_slam/matching/key_scan.hpp"

namespace matchbox_slam {

/// In a corridor that holds nothing only odometry tells how far the robot drives, and wheels that
/// slip, or encoders that hang, hide some of it. Where a robot that drives straight on as before
/// seems to have gone slower for a few seconds, and its scans do not say how far, it may have
/// driven on: the edges of motion of these are widened along the way, so that loops put right what
/// is wrong there and not all ways. One that stood there for a moment cannot be told from it.
/// @param key  where the slow stretch ends: it and the one after are in the order of their stamps,
///             or nothing is done. To be called once for each.
void inflate_for_slip(const PlacedScans& keys, std::size_t key, std::vector<PoseEdge>& edges);

}  // namespace matchbox_slam
