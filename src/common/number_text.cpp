#include "common/number_text.hpp"

#include <cmath>
#include <iomanip>
#include <locale>
#include <sstream>

#include "matchbox_slam/common/parameters.hpp"

namespace matchbox_slam {

std::string fixed_text(double value, int decimals) {
  std::ostringstream stream;
  stream.imbue(std::locale::classic());
  stream << std::fixed << std::setprecision(decimals) << value;
  return stream.str();
}

std::optional<double> finite_number(const std::string& text) {
  const std::optional<double> number = number_in(parse_parameter_value(text));
  return number && std::isfinite(*number) ? number : std::nullopt;
}

}  // namespace matchbox_slam
