#include "tools/out_folder.hpp"

#include <fmt/core.h>

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

EmptyFolderRemoval::EmptyFolderRemoval(std::string folder) : folder_(std::move(folder)) {
  std::error_code unknown;
  was_there_ = std::filesystem::exists(folder_, unknown) || unknown;
}

EmptyFolderRemoval::~EmptyFolderRemoval() {
  if (!was_there_) {
    std::error_code is_not_empty;
    std::filesystem::remove(folder_, is_not_empty);
  }
}

}  // namespace matchbox_slam
