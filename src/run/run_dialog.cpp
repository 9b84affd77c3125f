#include "run/run_dialog.hpp"

#include <fmt/core.h>

namespace matchbox_slam {

std::string seconds_text(double seconds) { return fmt::format("{:.1f} s", seconds); }

}  // namespace matchbox_slam
