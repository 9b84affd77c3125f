#pragma once

#include <string>
#include <vector>

namespace matchbox_slam {

/// Rows of text in columns as wide as they need to be, for a terminal. The first column is flush
/// left, the others, which hold numbers, flush right. Text is UTF-8.
/// @param rows  the first one is the heading; all as long as the heading.
[[nodiscard]] std::string format_table(const std::vector<std::vector<std::string>>& rows);

}  // namespace matchbox_slam
