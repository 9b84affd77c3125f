#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace matchbox_slam {

/// JSON as a program writes it. Names of files are any bytes: what is not UTF-8 in them is replaced
/// by U+FFFD, as JSON has no other way to hold it.
/// @param indent  spaces a level; below 0 all is on one line.
[[nodiscard]] std::string json_text(const nlohmann::json& json, int indent = 2);

}  // namespace matchbox_slam
