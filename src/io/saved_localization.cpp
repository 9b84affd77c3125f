#include <fmt/core.h>

#include <limits>
#include <utility>
#include <vector>

#include "io/saved_parts.hpp"

namespace matchbox_slam {
namespace {

/// The number of a component of the map, of which there are so many.
template <typename Archive, typename Number>
void transfer_component(Archive& archive, Number& component, std::size_t components) {
  transfer_number(archive, "component", component, "map", components);
}

void write_waiting(const std::vector<WaitingScan>& waiting, MapWriter& writer) {
  KeyScans scans;
  for (const WaitingScan& scan : waiting) {
    scans.add(scan.scan);
  }
  write_key_scans(scans, writer);
  for (const WaitingScan& scan : waiting) {
    transfer_component(writer, scan.component, 0);
  }
}

std::vector<WaitingScan> read_waiting(std::size_t components, MapReader& reader) {
  const KeyScans scans = read_key_scans(reader);
  std::vector<WaitingScan> waiting;
  for (const PlacedScan& scan : scans.all()) {
    waiting.push_back({0, scan});
    transfer_component(reader, waiting.back().component, components);
  }
  return waiting;
}

constexpr int kMaxCount = 1 << 30;
constexpr std::size_t kMostPlaces = 1000;

/// How many scans there were of some kind.
template <typename Archive, typename Count>
void transfer_count(Archive& archive, Count& count) {
  archive.integer(count);
  if constexpr (Archive::kReads) {
    if (count < 0 || count > kMaxCount) {
      archive.fail(fmt::format("is damaged: it counts {} scans", count));
    }
  }
}

/// What 1.0 knew of doubts; they end where such a map is read.
void skip_doubt(MapReader& reader) {
  bool flag = false;
  double number = 0.0;
  int count = 0;
  Pose2 pose;
  reader.flag(flag);
  reader.flag(flag);
  reader.number(number, kLargest);
  reader.number(number);
  transfer_count(reader, count);
  transfer_count(reader, count);
  transfer_count(reader, count);
  transfer_pose(reader, pose);
  reader.number(number);
}

template <typename Archive, typename Pose>
void transfer_key_pose(Archive& archive, Pose& pose) {
  bool has_pose = pose.has_value();
  archive.flag(has_pose);
  if (has_pose) {
    if constexpr (Archive::kReads) {
      pose = Pose2{};
    }
    transfer_pose(archive, *pose);
  }
}

constexpr std::size_t kMostSinceFork = 1'000'000;

template <typename Archive, typename Fork>
void transfer_fork(Archive& archive, Fork& fork) {
  for (auto* count : {&fork.key_scans, &fork.inserted}) {
    std::uint64_t written = *count;
    archive.integer(written);
    if constexpr (Archive::kReads) {
      *count = static_cast<std::size_t>(written);
    }
  }
  archive.number(fork.undecided);
  archive.number(fork.searched);
}

template <typename Archive, typename State>
void transfer_hypotheses(Archive& archive, State& state) {
  constexpr std::size_t kMostOthers = 100;
  for (auto& range : state.profile) {
    auto metres = static_cast<double>(range);
    archive.number(metres);
    if constexpr (Archive::kReads) {
      range = static_cast<float>(metres);
    }
  }
  archive.number(state.elsewhere, std::numeric_limits<double>::infinity());
  if constexpr (Archive::kReads) {
    if (state.elsewhere > kFarthest) {
      archive.fail("is damaged: the log odds of somewhere unknown are " +
                   to_string(state.elsewhere));
    }
  }
  bool is_forked = state.fork.has_value();
  archive.flag(is_forked);
  if (!is_forked) {
    return;
  }
  if constexpr (Archive::kReads) {
    state.fork.emplace();
  }
  transfer_fork(archive, *state.fork);
  archive.size(state.others, 40, kMostOthers, "poses where the robot may be");
  for (auto& other : state.others) {
    transfer_pose(archive, other.map_from_base);
    archive.number(other.log_odds);
    archive.size(other.key_scans, 1, kMostSinceFork, "key scans of such a pose");
    for (auto& pose : other.key_scans) {
      transfer_key_pose(archive, pose);
    }
  }
}

/// @param key_scans  that the component has which the robot is in.
void require_sound(const HypothesesState& state, std::size_t key_scans, const MapReader& reader) {
  if (!state.fork) {
    return;
  }
  const HypothesesFork& fork = *state.fork;
  bool is_sound = fork.key_scans <= key_scans && fork.inserted == key_scans - fork.key_scans;
  for (const PoseHypothesis& other : state.others) {
    is_sound = is_sound && other.key_scans.size() == fork.inserted;
  }
  if (!is_sound) {
    reader.fail(
        fmt::format("is damaged: of {} key scans {} and {} are from before and after it was sure "
                    "where the robot is",
                    key_scans, fork.key_scans, fork.inserted));
  }
}

/// How far 1.0 had looked for the robot; it is looked for anew.
void skip_search(MapReader& reader, std::size_t components) {
  std::uint64_t next = 0;
  bool is_complete = false;
  PlaceSearch search;
  reader.integer(next);
  reader.flag(is_complete);
  reader.number(search.stamp, kLargest);
  reader.size(search.hypotheses, 60, kMostPlaces, "places where the robot may be");
  for (PlaceHypothesis& place : search.hypotheses) {
    int confirmations = 0;
    transfer_component(reader, place.component, components);
    transfer_pose(reader, place.component_from_active);
    transfer_count(reader, confirmations);
    transfer_pose(reader, place.component_from_active);
  }
}

template <typename Archive, typename Search>
void transfer_search(Archive& archive, Search& search, std::size_t components) {
  archive.number(search.stamp, kLargest);
  archive.integer(search.indexed);
  transfer_count(archive, search.sampled);
  transfer_count(archive, search.alike);
  if constexpr (Archive::kReads) {
    if (search.alike > search.sampled) {
      archive.fail(fmt::format("is damaged: of {} places {} look like others", search.sampled,
                               search.alike));
    }
  }
  archive.size(search.explained, 56, kMostPlaces, "key scans of a robot that is lost");
  for (auto& explained : search.explained) {
    archive.integer(explained.key_scan);
    transfer_component(archive, explained.component, components);
    transfer_pose(archive, explained.component_from_base);
    archive.number(explained.best);
    archive.number(explained.elsewhere);
  }
  archive.size(search.hypotheses, 48, kMostPlaces, "places where the robot may be");
  for (auto& place : search.hypotheses) {
    transfer_component(archive, place.component, components);
    transfer_pose(archive, place.component_from_active);
    archive.number(place.log_odds);
    archive.number(place.behind);
  }
}

}  // namespace

void write_localization(const LocalizationState& localization, MapWriter& writer) {
  const std::size_t components = localization.components.size() + 1;
  writer.integer(std::uint64_t{localization.components.size()});
  for (const MapComponent& component : localization.components) {
    write_grids(component.map, writer);
    write_key_scans(component.key_scans, writer);
    write_last_inserted(component.last_inserted, writer);
    writer.number(component.begin);
    transfer_component(writer, component.parent, components);
    transfer_pose(writer, component.parent_from_component);
  }
  transfer_component(writer, localization.active, components);
  transfer_hypotheses(writer, localization.hypotheses);
  write_last_inserted(localization.inserted_before_fork, writer);
  write_waiting(localization.pending, writer);
  transfer_search(writer, localization.search, components);
}

LocalizationState read_localization(const KeyScans& key_scans, MapReader& reader) {
  LocalizationState localization;
  const std::size_t components = reader.count(60, kMostDisconnectedComponents, "maps apart") + 1;
  while (localization.components.size() + 1 < components) {
    MapComponent component{read_grids(reader), read_key_scans(reader), read_last_inserted(reader),
                           0};
    reader.number(component.begin, kLargest);
    transfer_component(reader, component.parent, components);
    transfer_pose(reader, component.parent_from_component);
    localization.components.push_back(std::move(component));
  }
  transfer_component(reader, localization.active, components);
  if (reader.is_of_1_0()) {
    skip_doubt(reader);
    static_cast<void>(read_waiting(components, reader));  // what was held until a doubt ended
    localization.pending = read_waiting(components, reader);
    skip_search(reader, components);
    return localization;
  }
  transfer_hypotheses(reader, localization.hypotheses);
  localization.inserted_before_fork = read_last_inserted(reader);
  const KeyScans& here = localization.active > 0
                             ? localization.components[localization.active - 1].key_scans
                             : key_scans;
  require_sound(localization.hypotheses, here.size(), reader);
  localization.pending = read_waiting(components, reader);
  transfer_search(reader, localization.search, components);
  for (const PlaceHypothesis& hypothesis : localization.search.hypotheses) {
    if (hypothesis.component == localization.active) {
      reader.fail(fmt::format("is damaged: it looks for component {} of the map in itself",
                              localization.active));
    }
  }
  return localization;
}

}  // namespace matchbox_slam
