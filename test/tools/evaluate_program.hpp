#pragma once

#include <algorithm>
#include <cstddef>
#include <string>

#include "tools/run_command.hpp"

namespace matchbox_slam {

/// Runs the program `evaluate` with arguments as a shell takes them.
[[nodiscard]] inline Outcome run_evaluate(const std::string& arguments) {
  return run_command(MATCHBOX_EVALUATE, arguments);
}

[[nodiscard]] inline std::size_t line_count(const std::string& text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

}  // namespace matchbox_slam
