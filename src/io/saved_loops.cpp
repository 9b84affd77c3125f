#include <fmt/core.h>

#include <stdexcept>

#include "io/saved_parts.hpp"

namespace matchbox_slam {
namespace {

constexpr std::size_t kMostEdges = 10'000'000;  // ten a key scan

/// The number of a key scan in a graph of so many.
template <typename Archive, typename Node>
void transfer_node(Archive& archive, Node& node, std::size_t nodes) {
  transfer_number(archive, "key scan", node, "graph", nodes);
}

template <typename Archive, typename Value, typename Last>
void transfer_choice(Archive& archive, Value& value, Last last) {
  auto number = static_cast<std::uint8_t>(value);
  archive.integer(number);
  if constexpr (Archive::kReads) {
    if (number > static_cast<std::uint8_t>(last)) {
      archive.fail(fmt::format(
          "is damaged: an edge of its graph is of kind or verdict {}; allowed: up to {}", number,
          static_cast<int>(last)));
    }
    value = static_cast<Last>(number);
  }
}

template <typename Archive, typename Edge>
void transfer_edge(Archive& archive, Edge& edge, std::size_t nodes) {
  transfer_node(archive, edge.from, nodes);
  transfer_node(archive, edge.to, nodes);
  transfer_pose(archive, edge.from_to);
  transfer_matrix(archive, edge.covariance);
  transfer_choice(archive, edge.kind, EdgeKind::kCondensed);
  transfer_choice(archive, edge.verdict, LoopVerdict::kOutlier);
  if (!archive.is_of_1_0()) {
    for (int i = 0; i < 3; ++i) {
      archive.number(edge.drift[i]);
    }
  }
}

template <typename Archive, typename Loop>
void transfer_loop(Archive& archive, Loop& loop, std::size_t nodes) {
  transfer_node(archive, loop.found.key, nodes);
  transfer_node(archive, loop.newest, nodes);
  transfer_pose(archive, loop.found.key_from_newest);
  transfer_covariance(archive, "a loop", loop.found.covariance);
  archive.number(loop.found.score);
  archive.number(loop.found.rival_share);
  if (archive.is_of_1_0()) {
    double contradiction = 0.0;  // the share of beams through walls
    archive.number(contradiction);
  } else {
    archive.number(loop.found.log_odds);
  }
  archive.flag(loop.is_inlier);
  archive.number(loop.chi_square, kLargest);
  archive.number(loop.moved);
}

template <typename Archive, typename State>
void transfer_state(Archive& archive, State& state, std::size_t nodes) {
  archive.size(state.edges, 114, kMostEdges, "edges in its graph");
  for (auto& edge : state.edges) {
    transfer_edge(archive, edge, nodes);
  }
  archive.size(state.loops, 153, kMostEdges, "loops");
  for (auto& loop : state.loops) {
    transfer_loop(archive, loop, nodes);
  }
  archive.number(state.way);
  archive.integer(state.tries);
}

template <typename Archive, typename Pending>
void transfer_pending(Archive& archive, Pending& pending, std::size_t nodes, std::size_t edges) {
  transfer_node(archive, pending.newest, nodes);
  archive.integer(pending.edges);
  archive.flag(pending.is_search_due);
  archive.flag(pending.is_near_due);
  archive.flag(pending.is_abandoned);
  if constexpr (Archive::kReads) {
    if (pending.edges > edges) {
      archive.fail(fmt::format("is damaged: it goes on with {} edges of a graph of {}",
                               pending.edges, edges));
    }
  }
}

template <typename Archive, typename Contents>
void transfer_local_map(Archive& archive, Contents& contents, std::size_t key_scans) {
  transfer_vector(archive, contents.center);
  archive.size(contents.drawn, 8, key_scans, "key scans drawn near the robot");
  for (auto& id : contents.drawn) {
    transfer_node(archive, id, key_scans);
  }
}

void require_sound_graph(const PoseGraph& graph, const MapReader& reader) {
  try {
    require_sound(graph);
  } catch (const std::invalid_argument& error) {
    reader.fail(std::string("is damaged: ") + error.what());
  }
}

/// Of each key scan, where some are another robot's.
template <typename Archive, typename Flags>
void transfer_are_others(Archive& archive, Flags& are_others, std::size_t nodes) {
  if (archive.is_of_1_0()) {
    return;
  }
  archive.size(are_others, 1, nodes, "key scans that tell whose they are");
  for (std::size_t i = 0; i < are_others.size(); ++i) {
    bool is_other = are_others[i];
    archive.flag(is_other);
    if constexpr (Archive::kReads) {
      are_others[i] = is_other;
    }
  }
}

}  // namespace

void write_loops(const EngineState& map, MapWriter& writer) {
  const LoopState& state = map.loops;
  writer.integer(std::uint64_t{state.nodes});
  transfer_state(writer, state, 0);
  transfer_are_others(writer, state.are_others, 0);
  writer.flag(map.local_map.has_value());
  if (map.local_map) {
    transfer_local_map(writer, *map.local_map, 0);
  }
  writer.flag(map.is_moved);
  writer.flag(map.is_continued);
  writer.flag(state.pending.has_value());
  if (state.pending) {
    transfer_pending(writer, *state.pending, 0, 0);
  }
  writer.flag(map.is_of_key_scans);
}

void read_loops(MapReader& reader, EngineState& map) {
  const PlacedScans& keys = map.key_scans.all();
  LoopState state;
  std::uint64_t nodes = 0;
  reader.integer(nodes);
  if (nodes > keys.size()) {
    reader.fail(
        fmt::format("is damaged: its graph has {} key scans; the map has {}", nodes, keys.size()));
  }
  state.nodes = nodes;
  transfer_state(reader, state, nodes);
  transfer_are_others(reader, state.are_others, nodes);
  if (nodes > 0) {
    require_sound_graph(graph_of(map.key_scans, state), reader);
  }
  bool has_local_map = false;
  reader.flag(has_local_map);
  if (has_local_map && reader.is_of_1_0()) {
    // It holds the map itself, and does not tell what it shows; another is drawn soon.
    static_cast<void>(read_grids(reader));
    Eigen::Vector2d center;
    transfer_vector(reader, center);
  } else if (has_local_map) {
    map.local_map = LocalMapContents{};
    transfer_local_map(reader, *map.local_map, keys.size());
  }
  reader.flag(map.is_moved);
  reader.flag(map.is_continued);
  bool has_pending = false;
  reader.flag(has_pending);
  if (has_pending) {
    state.pending = PendingLoopWork{};  // GCC 10 cannot emplace() what has initialisers
    transfer_pending(reader, *state.pending, nodes, state.edges.size());
    require_sound_graph(graph_as_of(*state.pending, map.key_scans, state), reader);
  }
  reader.flag(map.is_of_key_scans);
  map.loops = std::move(state);
}

}  // namespace matchbox_slam
