#pragma once

#include <string>

namespace matchbox_slam {

/// Whether a file lies right in a folder, however both are named.
[[nodiscard]] bool lies_in(const std::string& file, const std::string& folder);

/// A saved map may be the only one of the days that it took: throws ConfigurationError where it
/// lies in the folder of the results, among which one may have its name.
void require_other_folder(const std::string& map, const std::string& out);

/// Keeps other runs of map_bag and merge_maps from writing their results into a folder at the same
/// time, of which the last one would win. Throws ConfigurationError where another one does. Where
/// files cannot be locked (some that are shared over a network) nothing is held.
class FolderLock {
 public:
  explicit FolderLock(const std::string& folder);
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;
  ~FolderLock();

 private:
  int descriptor_;
};

/// Takes away at its end a folder that was not there at its beginning and that nothing was written
/// into, as of a run that is refused; not one that another program holds (FolderLock).
class EmptyFolderRemoval {
 public:
  explicit EmptyFolderRemoval(std::string folder);
  EmptyFolderRemoval(const EmptyFolderRemoval&) = delete;
  EmptyFolderRemoval& operator=(const EmptyFolderRemoval&) = delete;
  ~EmptyFolderRemoval();

 private:
  std::string folder_;
  bool was_there_;
};

}  // namespace matchbox_slam
