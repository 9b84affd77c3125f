#include "run/run_dialog.hpp"

#include <iomanip>
#include <locale>
#include <sstream>

namespace matchbox_slam {

std::string seconds_text(double seconds) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << std::fixed << std::setprecision(1) << seconds << " s";
  return text.str();
}

}  // namespace matchbox_slam
