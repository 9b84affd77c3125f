#pragma once

#include <sys/wait.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <string>

#include "tools/run_command.hpp"

namespace matchbox_slam {

/// Runs the program `evaluate` with arguments as a shell takes them.
[[nodiscard]] inline Outcome run_evaluate(const std::string& arguments) {
  return run_command(MATCHBOX_EVALUATE, arguments);
}

/// Whether the script that draws the figures can.
[[nodiscard]] inline bool has_matplotlib() {
  return WEXITSTATUS(std::system("/usr/bin/python3 -c 'import matplotlib' 2>/dev/null")) == 0;
}

[[nodiscard]] inline std::size_t line_count(const std::string& text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

}  // namespace matchbox_slam
