#include "matchbox_slam/common/options.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <sstream>

#include "common/known_names.hpp"

namespace matchbox_slam {
namespace {

/// A limit without the point that marks a double: "at least 1", not "at least 1.0".
std::string limit_text(double limit) {
  const bool is_short_integer = std::trunc(limit) == limit && std::abs(limit) < 1e15;
  return is_short_integer ? to_string(static_cast<std::int64_t>(limit)) : to_string(limit);
}

std::string text_of(const Allowed& allowed) {
  const std::string text = allowed.text();
  return text.empty() ? "" : "; allowed: " + text;
}

[[noreturn]] void refuse(const std::string& name, const std::string& value,
                         const std::string& reason) {
  throw ConfigurationError(name + ": " + value + " " + reason);
}

[[noreturn]] void refuse_type(const std::string& name, const ParameterValue& value,
                              const std::string& wanted, const Allowed& allowed) {
  refuse(name, to_string(value), "is not " + wanted + text_of(allowed));
}

void check(const std::string& name, double number, const ParameterValue& value,
           const Allowed& allowed) {
  if (!std::isfinite(number)) {
    refuse_type(name, value, "a finite number", allowed);
  }
  if (number < allowed.low || number > allowed.high) {
    refuse(name, to_string(value), "is not allowed" + text_of(allowed));
  }
}

/// The value of that type; `wanted` says which one it is.
template <typename Value>
const Value& get(const ParameterValue& value, const std::string& name, const Allowed& allowed,
                 const char* wanted) {
  const auto* given = std::get_if<Value>(&value);
  if (given == nullptr) {
    refuse_type(name, value, wanted, allowed);
  }
  return *given;
}

/// Whether a list without elements was given, which has no type of its own.
bool is_empty_list(const ParameterValue& value) {
  const auto* numbers = std::get_if<std::vector<double>>(&value);
  const auto* words = std::get_if<std::vector<std::string>>(&value);
  return (numbers != nullptr && numbers->empty()) || (words != nullptr && words->empty());
}

template <typename Value>
void read_list(const ParameterValue& value, const std::string& name, const Allowed& allowed,
               const char* wanted, std::vector<Value>& field) {
  field.clear();
  if (is_empty_list(value)) {
    return;
  }
  for (const Value& element : get<std::vector<Value>>(value, name, allowed, wanted)) {
    const std::string place = name + "[" + std::to_string(field.size()) + "]";
    read_value(element, place, allowed, field.emplace_back());
  }
}

}  // namespace

std::string join(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) {
    text += (text.empty() ? "" : ", ") + word;
  }
  return text;
}

std::vector<std::string> split(const std::string& text, char separator) {
  std::istringstream stream(text + separator);
  std::vector<std::string> parts;
  for (std::string part; std::getline(stream, part, separator);) {
    parts.push_back(part);
  }
  return parts;
}

std::string Allowed::text() const {
  if (!words.empty()) {
    return "one of " + join(words);
  }
  const bool has_low = std::isfinite(low);
  const bool has_high = std::isfinite(high);
  if (has_low && has_high) {
    return limit_text(low) + " to " + limit_text(high);
  }
  if (has_low) {
    return "at least " + limit_text(low);
  }
  return has_high ? "at most " + limit_text(high) : "";
}

void read_value(const ParameterValue& value, const std::string& name, const Allowed& /*allowed*/,
                bool& field) {
  const auto* given = std::get_if<bool>(&value);
  if (given == nullptr) {
    refuse(name, to_string(value), "is not allowed; allowed: true, false");
  }
  field = *given;
}

void read_value(const ParameterValue& value, const std::string& name, const Allowed& allowed,
                int& field) {
  const auto number =
      static_cast<double>(get<std::int64_t>(value, name, allowed, "a whole number"));
  constexpr double kLowest = std::numeric_limits<int>::lowest();
  constexpr double kHighest = std::numeric_limits<int>::max();
  Allowed narrowed = allowed;
  if (number < kLowest || number > kHighest) {  // only then do the limits of int interest anybody
    narrowed.low = std::max(allowed.low, kLowest);
    narrowed.high = std::min(allowed.high, kHighest);
  }
  check(name, number, value, narrowed);
  field = static_cast<int>(number);
}

void read_value(const ParameterValue& value, const std::string& name, const Allowed& allowed,
                double& field) {
  const std::optional<double> number = number_in(value);
  if (!number) {
    refuse_type(name, value, "a number", allowed);
  }
  field = *number;
  check(name, field, value, allowed);
}

void read_value(const ParameterValue& value, const std::string& name, const Allowed& allowed,
                std::string& field) {
  field = get<std::string>(value, name, allowed, "text (quote it if it is meant as text)");
  const std::vector<std::string>& words = allowed.words;
  if (!words.empty() && std::find(words.begin(), words.end(), field) == words.end()) {
    refuse(name, to_string(value), "is not allowed" + text_of(allowed));
  }
}

void read_value(const ParameterValue& value, const std::string& name, const Allowed& allowed,
                std::vector<double>& field) {
  read_list(value, name, allowed, "a list of numbers, such as [1.0, 2.0]", field);
}

void read_value(const ParameterValue& value, const std::string& name, const Allowed& allowed,
                std::vector<std::string>& field) {
  read_list(value, name, allowed, "a list of texts, such as [one, two]", field);
}

void reject_unknown_keys(const Parameters& parameters, const std::string& component,
                         const std::vector<std::string>& known) {
  for (const auto& [key, value] : parameters.values()) {
    if (std::find(known.begin(), known.end(), key) != known.end()) {
      continue;
    }
    const std::string nearest = nearest_name(key, known);
    throw ConfigurationError(
        (component.empty() ? "" : component + ": ") +
        unknown_name_text("parameter", key,
                          nearest.empty() ? std::vector<std::string>{} : std::vector{nearest},
                          known));
  }
}

}  // namespace matchbox_slam
