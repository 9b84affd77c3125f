#pragma once

#include <string>

namespace matchbox_slam {

/// Whether a file lies right in a folder, however both are named.
[[nodiscard]] bool lies_in(const std::string& file, const std::string& folder);

/// A saved map may be the only one of the days that it took: throws ConfigurationError where it
/// lies in the folder of the results, among which one may have its name.
void require_other_folder(const std::string& map, const std::string& out);

}  // namespace matchbox_slam
