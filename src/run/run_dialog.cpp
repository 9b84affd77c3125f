#include "run/run_dialog.hpp"

#include "common/number_text.hpp"

namespace matchbox_slam {

std::string seconds_text(double seconds) { return fixed_text(seconds, 1) + " s"; }

}  // namespace matchbox_slam
