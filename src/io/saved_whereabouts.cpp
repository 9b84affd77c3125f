#include <utility>
#include <vector>

#include "io/saved_parts.hpp"

namespace matchbox_slam {
namespace {

/// The number of a part of the map, of which there are so many.
template <typename Archive, typename Part>
void transfer_part(Archive& archive, Part& part, std::size_t parts) {
  transfer_number(archive, "part", part, "map", parts);
}

void write_waiting(const std::vector<WaitingScan>& waiting, MapWriter& writer) {
  KeyScans scans;
  for (const WaitingScan& scan : waiting) {
    scans.add(scan.scan);
  }
  write_key_scans(scans, writer);
  for (const WaitingScan& scan : waiting) {
    transfer_part(writer, scan.part, 0);
  }
}

std::vector<WaitingScan> read_waiting(std::size_t parts, MapReader& reader) {
  const KeyScans scans = read_key_scans(reader);
  std::vector<WaitingScan> waiting;
  for (const PlacedScan& scan : scans.all()) {
    waiting.push_back({0, scan});
    transfer_part(reader, waiting.back().part, parts);
  }
  return waiting;
}

constexpr int kMost = 1 << 30;

/// How many scans there were of some kind, or how many more than of another.
template <typename Archive, typename Count>
void transfer_count(Archive& archive, Count& count, int least = 0) {
  archive.integer(count);
  if constexpr (Archive::kReads) {
    if (count < least || count > kMost) {
      archive.fail("is damaged: it counts " + std::to_string(count) + " scans");
    }
  }
}

template <typename Archive, typename Doubt>
void transfer_doubt(Archive& archive, Doubt& doubt) {
  archive.flag(doubt.doubts);
  archive.flag(doubt.is_provisional);
  archive.number(doubt.since, kLargest);
  archive.number(doubt.way);
  transfer_count(archive, doubt.doubtful);
  transfer_count(archive, doubt.contradictions);
  if (archive.version() >= 11) {
    archive.number(doubt.contradiction_sum);
  }
  transfer_count(archive, doubt.confirmations, -kMost);
  transfer_pose(archive, doubt.map_from_base);
}

template <typename Archive, typename Search>
void transfer_search(Archive& archive, Search& search, std::size_t parts) {
  constexpr std::size_t kMostHypotheses = 1000;
  std::uint64_t next = search.next;
  archive.integer(next);
  archive.flag(search.complete);
  archive.number(search.stamp, kLargest);
  archive.size(search.hypotheses, 60, kMostHypotheses, "places where the robot may be");
  for (auto& hypothesis : search.hypotheses) {
    transfer_part(archive, hypothesis.part, parts);
    transfer_pose(archive, hypothesis.part_from_apart);
    transfer_count(archive, hypothesis.confirmations);
    transfer_pose(archive, hypothesis.apart_from_base);
  }
  if constexpr (Archive::kReads) {
    search.next = static_cast<std::size_t>(next);
  }
}

}  // namespace

void write_whereabouts(const Whereabouts& whereabouts, MapWriter& writer) {
  const std::size_t parts = whereabouts.apart.size() + 1;
  writer.integer(std::uint64_t{whereabouts.apart.size()});
  for (const MapPart& part : whereabouts.apart) {
    write_grids(part.map, writer);
    write_key_scans(part.key_scans, writer);
    write_last_inserted(part.last_inserted, writer);
    writer.number(part.begin);
    transfer_part(writer, part.left, parts);
    transfer_pose(writer, part.left_from_here);
  }
  transfer_part(writer, whereabouts.here, parts);
  transfer_doubt(writer, whereabouts.doubt);
  writer.number(whereabouts.usual_score);
  writer.number(whereabouts.contradicted_way);
  write_waiting(whereabouts.held, writer);
  write_waiting(whereabouts.pending, writer);
  transfer_search(writer, whereabouts.search, parts);
}

Whereabouts read_whereabouts(MapReader& reader) {
  Whereabouts whereabouts;
  const std::size_t parts = reader.count(60, kMostPartsApart, "maps apart") + 1;
  while (whereabouts.apart.size() + 1 < parts) {
    MapPart part{read_grids(reader), read_key_scans(reader), read_last_inserted(reader), 0};
    reader.number(part.begin, kLargest);
    transfer_part(reader, part.left, parts);
    transfer_pose(reader, part.left_from_here);
    whereabouts.apart.push_back(std::move(part));
  }
  transfer_part(reader, whereabouts.here, parts);
  transfer_doubt(reader, whereabouts.doubt);
  reader.number(whereabouts.usual_score);
  if (reader.version() >= 10) {
    reader.number(whereabouts.contradicted_way);
  }
  whereabouts.held = read_waiting(parts, reader);
  whereabouts.pending = read_waiting(parts, reader);
  transfer_search(reader, whereabouts.search, parts);
  for (const PlaceHypothesis& hypothesis : whereabouts.search.hypotheses) {
    if (hypothesis.part == whereabouts.here) {
      reader.fail("is damaged: it looks for part " + std::to_string(whereabouts.here) +
                  " of the map in itself");
    }
  }
  return whereabouts;
}

}  // namespace matchbox_slam
