#include "tools/out_folder.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <system_error>
#include <utility>

#include "matchbox_slam/common/options.hpp"

namespace matchbox_slam {

bool lies_in(const std::string& file, const std::string& folder) {
  std::error_code unknown;  // of what is not there nothing is lost
  return std::filesystem::equivalent(std::filesystem::absolute(file).parent_path(), folder,
                                     unknown);
}

void require_other_folder(const std::string& map, const std::string& out) {
  if (lies_in(map, out)) {
    throw ConfigurationError(
        fmt::format("--out: '{}' is the folder of {}, which would be written over; give another "
                    "--out, or --overwrite",
                    out, map));
  }
}

FolderLock::FolderLock(const std::string& folder)
    : descriptor_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (descriptor_ >= 0 && ::flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    ::close(descriptor_);
    throw ConfigurationError(fmt::format(
        "--out: another program is writing its results into '{}'; give another --out, or wait "
        "until it has ended",
        folder));
  }
}

FolderLock::~FolderLock() {
  if (descriptor_ >= 0) {
    ::close(descriptor_);
  }
}

EmptyFolderRemoval::EmptyFolderRemoval(std::string folder) : folder_(std::move(folder)) {
  std::error_code unknown;
  was_there_ = std::filesystem::exists(folder_, unknown) || unknown;
}

EmptyFolderRemoval::~EmptyFolderRemoval() {
  if (was_there_) {
    return;
  }
  try {
    const FolderLock lock(folder_);
    std::error_code is_not_empty;
    std::filesystem::remove(folder_, is_not_empty);
  } catch (const ConfigurationError&) {  // another program has not written into it yet
  }
}

}  // namespace matchbox_slam
