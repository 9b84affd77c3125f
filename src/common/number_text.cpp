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
  const ParameterValue value = parse_parameter_value(text);
  if (const auto* whole = std::get_if<std::int64_t>(&value)) {
    return static_cast<double>(*whole);
  }
  const auto* real = std::get_if<double>(&value);
  return real != nullptr && std::isfinite(*real) ? std::optional<double>(*real) : std::nullopt;
}

}  // namespace matchbox_slam
