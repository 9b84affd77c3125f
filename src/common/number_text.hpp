#pragma once

#include <optional>
#include <string>

namespace matchbox_slam {

/// A number with so many decimals, whatever the locale.
[[nodiscard]] std::string fixed_text(double value, int decimals);

/// The number that a text is, whatever the locale. None when it is no number, or not a finite one.
[[nodiscard]] std::optional<double> finite_number(const std::string& text);

}  // namespace matchbox_slam
