#pragma once

#include <string>
#include <vector>

#include "matchbox_slam/io/file.hpp"
#include "tools/movie_frame.hpp"

namespace matchbox_slam {

/// Where a movie goes: a GIF, where the name ends so, else a folder of PNGs, `frame_000.png` and so
/// on.
class MovieFile {
 public:
  /// Throws ConfigurationError for a name that is neither's.
  explicit MovieFile(std::string name);

  /// To be called before the work: makes the folder if need be. Throws FileError naming the file or
  /// folder and the reason.
  void require_writable() const;

  /// @param frames             at least one.
  /// @param finest_resolution  of cells of level 0 [m].
  void add(const std::vector<MovieFrame>& frames, double finest_resolution,
           FileReplacement& files) const;

  /// When that has taken its names: in a folder, frames of a longer movie before are removed, which
  /// would seem to be of this one.
  void remove_older(const std::vector<MovieFrame>& frames) const;

 private:
  [[nodiscard]] std::string frame_path(std::size_t number) const;

  std::string name_;
  bool is_gif_;
};

}  // namespace matchbox_slam
