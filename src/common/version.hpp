#pragma once

#include <string>

namespace matchbox_slam {

/// As package.xml has it, such as "2.0.0".
[[nodiscard]] std::string package_version();

/// What a program says when it is asked for its version.
[[nodiscard]] std::string version_text(const std::string& program);

}  // namespace matchbox_slam
