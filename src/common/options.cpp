#include "matchbox_slam/common/options.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

namespace matchbox_slam {
namespace {

std::string full_name(const std::string& component, const std::string& name) {
  return component.empty() ? name : component + "/" + name;
}

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

void check(const std::string& name, const std::string& word, const Allowed& allowed) {
  const std::vector<std::string>& words = allowed.words;
  if (!words.empty() && std::find(words.begin(), words.end(), word) == words.end()) {
    refuse(name, to_string(word), "is not allowed" + text_of(allowed));
  }
}

/// Whether a list without elements was given, which has no type of its own.
bool is_empty_list(const ParameterValue& value) {
  const auto* numbers = std::get_if<std::vector<double>>(&value);
  const auto* words = std::get_if<std::vector<std::string>>(&value);
  return (numbers != nullptr && numbers->empty()) || (words != nullptr && words->empty());
}

/// Number of letters to insert, remove or replace to turn one text into the other (Levenshtein).
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, diagonal + 1});
    }
  }
  return row[b.size()];
}

/// The known name that was probably meant; empty when none is near.
std::string nearest_name(const std::string& key, const std::vector<std::string>& known) {
  std::string nearest;
  std::size_t least = std::max<std::size_t>(2, key.size() / 3) + 1;
  for (const std::string& name : known) {
    const std::size_t distance = edit_distance(key, name);
    if (distance < least) {
      least = distance;
      nearest = name;
    }
  }
  return nearest;
}

/// Reads a list; `kind` says what it has to be.
template <typename Value>
void read_list(const Parameters& parameters, const std::string& component, const std::string& name,
               const Allowed& allowed, const char* kind, std::vector<Value>& field) {
  const ParameterValue* value = parameters.find(name);
  if (value == nullptr) {
    return;
  }
  if (is_empty_list(*value)) {
    field.clear();
    return;
  }
  const auto* given = std::get_if<std::vector<Value>>(value);
  if (given == nullptr) {
    refuse_type(full_name(component, name), *value, kind, allowed);
  }
  for (std::size_t i = 0; i < given->size(); ++i) {
    const std::string place = full_name(component, name) + "[" + std::to_string(i) + "]";
    if constexpr (std::is_same_v<Value, double>) {
      check(place, (*given)[i], (*given)[i], allowed);
    } else {
      check(place, (*given)[i], allowed);
    }
  }
  field = *given;
}

}  // namespace

std::string join(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) {
    text += (text.empty() ? "" : ", ") + word;
  }
  return text;
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

void read_option(const Parameters& parameters, const std::string& component,
                 const std::string& name, const Allowed& /*allowed*/, bool& field) {
  const ParameterValue* value = parameters.find(name);
  if (value == nullptr) {
    return;
  }
  const auto* given = std::get_if<bool>(value);
  if (given == nullptr) {
    refuse(full_name(component, name), to_string(*value), "is not allowed; allowed: true, false");
  }
  field = *given;
}

void read_option(const Parameters& parameters, const std::string& component,
                 const std::string& name, const Allowed& allowed, int& field) {
  const ParameterValue* value = parameters.find(name);
  if (value == nullptr) {
    return;
  }
  const auto* given = std::get_if<std::int64_t>(value);
  if (given == nullptr) {
    refuse_type(full_name(component, name), *value, "a whole number", allowed);
  }
  constexpr double kLowest = std::numeric_limits<int>::lowest();
  constexpr double kHighest = std::numeric_limits<int>::max();
  Allowed narrowed = allowed;
  const auto number = static_cast<double>(*given);
  if (number < kLowest || number > kHighest) {  // only then do the limits of int interest anybody
    narrowed.low = std::max(allowed.low, kLowest);
    narrowed.high = std::min(allowed.high, kHighest);
  }
  check(full_name(component, name), number, *value, narrowed);
  field = static_cast<int>(*given);
}

void read_option(const Parameters& parameters, const std::string& component,
                 const std::string& name, const Allowed& allowed, double& field) {
  const ParameterValue* value = parameters.find(name);
  if (value == nullptr) {
    return;
  }
  double number = 0.0;
  if (const auto* whole = std::get_if<std::int64_t>(value)) {
    number = static_cast<double>(*whole);
  } else if (const auto* real = std::get_if<double>(value)) {
    number = *real;
  } else {
    refuse_type(full_name(component, name), *value, "a number", allowed);
  }
  check(full_name(component, name), number, *value, allowed);
  field = number;
}

void read_option(const Parameters& parameters, const std::string& component,
                 const std::string& name, const Allowed& allowed, std::string& field) {
  const ParameterValue* value = parameters.find(name);
  if (value == nullptr) {
    return;
  }
  const auto* given = std::get_if<std::string>(value);
  if (given == nullptr) {
    refuse_type(full_name(component, name), *value, "text (quote it if it is meant as text)",
                allowed);
  }
  check(full_name(component, name), *given, allowed);
  field = *given;
}

void read_option(const Parameters& parameters, const std::string& component,
                 const std::string& name, const Allowed& allowed, std::vector<double>& field) {
  read_list(parameters, component, name, allowed, "a list of numbers", field);
}

void read_option(const Parameters& parameters, const std::string& component,
                 const std::string& name, const Allowed& allowed, std::vector<std::string>& field) {
  read_list(parameters, component, name, allowed, "a list of texts", field);
}

void reject_unknown_keys(const Parameters& parameters, const std::string& component,
                         const std::vector<std::string>& known) {
  for (const auto& [key, value] : parameters.values()) {
    if (std::find(known.begin(), known.end(), key) != known.end()) {
      continue;
    }
    const std::string nearest = nearest_name(key, known);
    throw ConfigurationError((component.empty() ? "" : component + ": ") + "unknown parameter '" +
                             key + "'" +
                             (nearest.empty() ? "." : "; did you mean '" + nearest + "'?") +
                             (known.empty() ? " It takes none." : " Known: " + join(known) + "."));
  }
}

}  // namespace matchbox_slam
