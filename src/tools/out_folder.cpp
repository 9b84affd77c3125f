#include "tools/out_folder.hpp"

#include <fmt/core.h>

#include <filesystem>
#include <system_error>

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

}  // namespace matchbox_slam
