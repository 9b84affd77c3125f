#include "io/map_changes.hpp"

#include <fmt/core.h>
#include <zlib.h>

#include <array>
#include <filesystem>
#include <utility>

#include "io/gzip.hpp"
#include "io/saved_parts.hpp"

namespace matchbox_slam {
namespace {

const std::string kChangesHead = "matchbox_slam map changes, version 1\n";

// [bytes] of a piece; where its end is by chance, 2 kB in the mean.
constexpr std::size_t kLeastPiece = 256;
constexpr std::size_t kMostPiece = 16384;
constexpr std::uint64_t kEndMask = (std::uint64_t{1} << 11U) - 1;

enum class Step : std::uint8_t { kEnd, kCopy, kInsert };

/// A number for each byte that looks like chance (splitmix64; Steele, Lea and Flood 2014).
std::array<std::uint64_t, 256> random_table() {
  std::array<std::uint64_t, 256> table{};
  std::uint64_t state = 0;
  for (std::uint64_t& entry : table) {
    state += 0x9e3779b97f4a7c15U;
    std::uint64_t mixed = (state ^ (state >> 30U)) * 0xbf58476d1ce4e5b9U;
    mixed = (mixed ^ (mixed >> 27U)) * 0x94d049bb133111ebU;
    entry = mixed ^ (mixed >> 31U);
  }
  return table;
}

const std::array<std::uint64_t, 256> kOfByte = random_table();

std::uint64_t hash_of(const std::string& piece) {
  std::uint64_t hash = piece.size();
  for (const char byte : piece) {
    hash = (hash ^ kOfByte[static_cast<unsigned char>(byte)]) * 0x9e3779b97f4a7c15U;
    hash ^= hash >> 32U;
  }
  return hash;
}

std::uint32_t checksum_after(std::uint32_t before, const std::string& bytes) {
  // zlib takes unsigned bytes. NOLINTNEXTLINE
  const auto* data = reinterpret_cast<const Bytef*>(bytes.data());
  return static_cast<std::uint32_t>(crc32_z(before, data, bytes.size()));
}

/// Gives the pieces of a map's bytes.
void cut(const EngineState& map, const PieceCutter::Take& take) {
  PieceCutter cutter(take);
  write_map_bytes(map, [&cutter](const std::string& bytes) { cutter.add(bytes); });
  cutter.finish();
}

/// Writes steps that follow each other as one where they can be.
class ChangeWriter {
 public:
  explicit ChangeWriter(MapWriter& writer) : writer_(writer) {}

  void copy(const MapPieces::Place& place) {
    write_inserted();
    if (copied_.size > 0 && copied_.begin + copied_.size == place.begin) {
      copied_.size += place.size;
      return;
    }
    write_copied();
    copied_ = place;
  }

  void insert(const std::string& bytes) {
    write_copied();
    inserted_ += bytes;
  }

  void finish() {
    write_copied();
    write_inserted();
    writer_.integer(static_cast<std::uint8_t>(Step::kEnd));
  }

 private:
  void write_copied() {
    if (copied_.size > 0) {
      writer_.integer(static_cast<std::uint8_t>(Step::kCopy));
      writer_.integer(copied_.begin);
      writer_.integer(copied_.size);
      copied_ = {};
    }
  }

  void write_inserted() {
    if (!inserted_.empty()) {
      writer_.integer(static_cast<std::uint8_t>(Step::kInsert));
      writer_.integer(std::uint64_t{inserted_.size()});
      writer_.text(inserted_);
      inserted_.clear();
    }
  }

  MapWriter& writer_;
  MapPieces::Place copied_;
  std::string inserted_;
};

/// What the file of changes says of the bytes that they are.
struct Identity {
  std::uint64_t size = 0;
  std::uint32_t checksum = 0;

  [[nodiscard]] bool is_of(const std::string& bytes) const {
    return bytes.size() == size && checksum_after(0, bytes) == checksum;
  }
};

template <typename Archive>
void transfer_identity(Archive& archive, Identity& identity) {
  archive.integer(identity.size);
  archive.integer(identity.checksum);
}

/// By the steps of the file, from its saved map.
std::string carried_out(MapReader& reader, const std::string& saved) {
  std::string bytes;
  while (true) {
    std::uint8_t step = 0;
    std::uint64_t begin = 0;
    std::uint64_t size = 0;
    reader.integer(step);
    if (step == static_cast<std::uint8_t>(Step::kEnd)) {
      return bytes;
    }
    if (step == static_cast<std::uint8_t>(Step::kCopy)) {
      reader.integer(begin);
      reader.integer(size);
      if (begin > saved.size() || size > saved.size() - begin) {
        reader.fail("is damaged: it copies what is not there");
      }
      bytes.append(saved, begin, size);
    } else {
      reader.integer(size);
      reader.bytes(size, bytes);
    }
  }
}

std::optional<std::string> read_changes(const std::string& saved, const std::string& path) {
  const std::string packed = decompress(read_file(path), path);
  MapReader reader(packed, path, 0.0);
  if (!reader.begins_with(kChangesHead)) {
    reader.fail("is no file of changes that this version reads");
  }
  Identity base;
  transfer_identity(reader, base);
  if (!base.is_of(saved)) {
    return std::nullopt;  // left by a program that was ended before it could remove it
  }
  std::string bytes = carried_out(reader, saved);
  Identity result;
  transfer_identity(reader, result);
  if (!result.is_of(bytes)) {
    reader.fail("is damaged: what comes of it is not what was saved");
  }
  return bytes;
}

}  // namespace

void PieceCutter::add(const std::string& bytes) {
  for (const char byte : bytes) {
    piece_ += byte;
    hash_ = (hash_ << 1U) + kOfByte[static_cast<unsigned char>(byte)];
    const bool is_end = piece_.size() >= kLeastPiece && (hash_ >> 40U & kEndMask) == 0;
    if (is_end || piece_.size() >= kMostPiece) {
      take_(piece_);
      piece_.clear();
    }
  }
}

void PieceCutter::finish() {
  if (!piece_.empty()) {
    take_(piece_);
  }
}

void MapPieces::add(const std::string& piece) {
  places_.try_emplace(hash_of(piece), Place{size_, piece.size()});
  size_ += piece.size();
  checksum_ = checksum_after(checksum_, piece);
}

const MapPieces::Place* MapPieces::find(const std::string& piece) const {
  const auto found = places_.find(hash_of(piece));
  return found != places_.end() && found->second.size == piece.size() ? &found->second : nullptr;
}

MapPieces write_map_in_pieces(const EngineState& map, const ByteSink& sink) {
  MapPieces pieces;
  Compressor compressor(sink);
  cut(map, [&](const std::string& piece) {
    pieces.add(piece);
    compressor.add(piece);
  });
  compressor.finish();
  return pieces;
}

std::string changes_since(const MapPieces& saved, const EngineState& map) {
  std::string packed;
  Compressor compressor([&packed](const std::string& bytes) { packed += bytes; });
  MapWriter writer([&compressor](const std::string& bytes) { compressor.add(bytes); });
  writer.text(kChangesHead);
  Identity identity{saved.size(), saved.checksum()};
  transfer_identity(writer, identity);
  ChangeWriter changes(writer);
  Identity result;
  cut(map, [&](const std::string& piece) {
    if (const MapPieces::Place* place = saved.find(piece)) {
      changes.copy(*place);
    } else {
      changes.insert(piece);
    }
    result.size += piece.size();
    result.checksum = checksum_after(result.checksum, piece);
  });
  changes.finish();
  transfer_identity(writer, result);
  writer.finish();
  compressor.finish();
  return packed;
}

std::string path_of_changes(const std::string& map_path) { return map_path + ".changes"; }

std::string with_changes(std::string saved, const std::string& map_path) {
  const std::string path = path_of_changes(map_path);
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) {
    return saved;
  }
  try {
    std::optional<std::string> changed = read_changes(saved, path);
    return changed ? std::move(*changed) : std::move(saved);
  } catch (const DamagedFile& error) {
    throw DamagedChanges(
        fmt::format("{}; without it the map is as it was saved before: to go on with that, rm {}",
                    error.what(), path));
  }
}

}  // namespace matchbox_slam
