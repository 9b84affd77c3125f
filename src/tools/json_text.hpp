#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "evaluation/error_statistics.hpp"
#include "matchbox_slam/common/options.hpp"

namespace matchbox_slam {

/// JSON as a program writes it. Names of files are any bytes: what is not UTF-8 in them is replaced
/// by U+FFFD, as JSON has no other way to hold it.
/// @param indent  spaces a level; below 0 all is on one line.
[[nodiscard]] std::string json_text(const nlohmann::json& json, int indent = 2);

/// All but the count. @param unit  that errors are multiplied by.
[[nodiscard]] nlohmann::json to_json(const ErrorStatistics& statistics, double unit = 1.0);

/// The values of options by their names.
[[nodiscard]] nlohmann::json values_of(const std::vector<OptionDescription>& options);

}  // namespace matchbox_slam
