#pragma once

#include <string>

namespace matchbox_slam {

/// The bytes in the gzip format, which carries their length and checksum. Throws std::runtime_error
/// for more than 4 GB.
[[nodiscard]] std::string compress(const std::string& bytes);

/// What `compress` was given. Throws FileError naming `path` when that is cut off or damaged, or
/// would take more than 4 GB.
[[nodiscard]] std::string decompress(const std::string& compressed, const std::string& path);

}  // namespace matchbox_slam
