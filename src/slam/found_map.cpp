#include "slam/found_map.hpp"

#include <algorithm>

namespace matchbox_slam {
namespace {

/// Of a key scan of both, where this robot's come first, when the other robot's have come in.
std::size_t number_in_map(const FoundMap& found, std::size_t number) {
  return number < found.own.size() ? found.number_of(number) : number - found.own.size() + 1;
}

}  // namespace

std::vector<PoseEdge> edges_with(const FoundMap& found, const std::vector<PoseEdge>& own) {
  std::vector<PoseEdge> edges;
  for (PoseEdge edge : found.both_loops.edges) {
    edge.from = number_in_map(found, edge.from);
    edge.to = number_in_map(found, edge.to);
    add_edge(edge, edges);
  }
  for (PoseEdge edge : own) {
    if (std::max(edge.from, edge.to) >= found.own.size()) {  // it has come since
      edge.from = found.number_of(edge.from);
      edge.to = found.number_of(edge.to);
      add_edge(edge, edges);
    }
  }
  return edges;
}

std::vector<ClosedLoop> loops_with(const FoundMap& found, std::vector<ClosedLoop> own) {
  for (ClosedLoop& loop : own) {
    loop.found.key = found.number_of(loop.found.key);
    loop.newest = found.number_of(loop.newest);
  }
  const std::vector<ClosedLoop>& both = found.both_loops.loops;
  for (auto loop = both.begin() + static_cast<std::ptrdiff_t>(found.loops); loop != both.end();
       ++loop) {
    own.push_back(*loop);
    own.back().found.key = number_in_map(found, loop->found.key);
    own.back().newest = number_in_map(found, loop->newest);
  }
  return own;
}

PlacedScans others_of(const FoundMap& found) {
  const PlacedScans& all = found.both.all();
  return {all.begin() + static_cast<std::ptrdiff_t>(found.own.size()), all.end()};
}

}  // namespace matchbox_slam
