#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <unordered_map>

#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/slam/engine_state.hpp"

namespace matchbox_slam {

// A map that is saved again and again changes little from one time to the next. What has changed
// goes into a small file beside it, `path` + ".changes"; reading the map reads both.

/// Cuts bytes into pieces where what they hold says so, so that what comes again is cut in the same
/// places, wherever it lies (Muthitacharoen, Chen and Mazieres 2001): of about 2 kB.
class PieceCutter {
 public:
  using Take = std::function<void(const std::string& piece)>;
  explicit PieceCutter(Take take) : take_(std::move(take)) {}

  void add(const std::string& bytes);
  /// To be called once, at the end.
  void finish();

 private:
  Take take_;
  std::string piece_;
  std::uint64_t hash_ = 0;
};

/// What the bytes of a saved map are made of, before compression: to be recognised, and to find its
/// pieces in a later one.
class MapPieces {
 public:
  struct Place {
    std::uint64_t begin = 0;
    std::uint64_t size = 0;
  };

  void add(const std::string& piece);
  [[nodiscard]] const Place* find(const std::string& piece) const;
  [[nodiscard]] std::uint64_t size() const { return size_; }
  [[nodiscard]] std::uint32_t checksum() const { return checksum_; }

 private:
  std::unordered_map<std::uint64_t, Place> places_;  ///< by hash
  std::uint64_t size_ = 0;
  std::uint32_t checksum_ = 0;
};

/// As write_saved_map. Returns what it is made of.
MapPieces write_map_in_pieces(const EngineState& map, const ByteSink& sink);

/// The file of what has changed in a map since it was saved.
[[nodiscard]] std::string changes_since(const MapPieces& saved, const EngineState& map);

/// Where that file is.
[[nodiscard]] std::string path_of_changes(const std::string& map_path);

/// Thrown where that file is damaged; the map without it is whole, and older.
class DamagedChanges : public FileError {
 public:
  using FileError::FileError;
};

/// The bytes of a saved map as they are with its file of changes. Without one, or where that is of
/// another map, as they are. Throws DamagedChanges.
[[nodiscard]] std::string with_changes(std::string saved, const std::string& map_path);

}  // namespace matchbox_slam
