#pragma once

#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "matchbox_slam/common/parameters.hpp"

namespace matchbox_slam {

/// Thrown for an unknown key or a value that is not allowed. The text names the key, the value and
/// what is allowed.
class ConfigurationError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// What an option may be: a closed interval for numbers, a list of words for text (empty: any
/// text).
struct Allowed {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  std::vector<std::string> words;

  /// For people: "at least 1", "0 to 1", "one of a, b"; empty when anything goes.
  [[nodiscard]] std::string text() const;
};

[[nodiscard]] inline Allowed any() { return {}; }
[[nodiscard]] inline Allowed at_least(double low) {
  return {low, std::numeric_limits<double>::infinity(), {}};
}
[[nodiscard]] inline Allowed between(double low, double high) { return {low, high, {}}; }
[[nodiscard]] inline Allowed one_of(std::vector<std::string> words) {
  Allowed allowed;
  allowed.words = std::move(words);
  return allowed;
}

/// For people: "a, b, c".
[[nodiscard]] std::string join(const std::vector<std::string>& words);

/// What stands before, between and after the separators; at least one part, which may be empty.
[[nodiscard]] std::vector<std::string> split(const std::string& text, char separator);

/// One row of a parameter table.
struct OptionDescription {
  std::string name;
  ParameterValue value;
  std::string unit;     ///< empty when the value is a plain number, a word or a switch
  std::string allowed;  ///< for people
  std::string meaning;
  Allowed limits;  ///< for programs
};

// An options struct is a plain struct whose fields carry their defaults, with one static template
//
//   template <typename Self, typename Visitor>
//   static void visit(Self& self, Visitor&& option) {
//     option(self.max_tries, "max_tries", at_least(1), "", "Poses drawn in all.");
//     ...
//   }
//
// From that list come the reader below, doc/parameters.md and the configuration in reports.
// Fields may be bool, int, double, std::string, std::vector<double> or std::vector<std::string>.

/// Reads `field` from the value of the option `name`. Whole numbers are good for a double, but not
/// the reverse; numbers have to be finite. Throws ConfigurationError when its type or value is not
/// allowed.
void read_value(const ParameterValue& value, const std::string& name, const Allowed& allowed,
                bool& field);
void read_value(const ParameterValue& value, const std::string& name, const Allowed& allowed,
                int& field);
void read_value(const ParameterValue& value, const std::string& name, const Allowed& allowed,
                double& field);
void read_value(const ParameterValue& value, const std::string& name, const Allowed& allowed,
                std::string& field);
void read_value(const ParameterValue& value, const std::string& name, const Allowed& allowed,
                std::vector<double>& field);
void read_value(const ParameterValue& value, const std::string& name, const Allowed& allowed,
                std::vector<std::string>& field);

/// Throws ConfigurationError for the first key of `parameters` that is not among `known`, and
/// suggests the nearest known name.
void reject_unknown_keys(const Parameters& parameters, const std::string& component,
                         const std::vector<std::string>& known);

/// One row an option, in the order of the struct, with the values that `options` holds.
template <typename Options>
[[nodiscard]] std::vector<OptionDescription> describe_options(const Options& options) {
  std::vector<OptionDescription> rows;
  Options::visit(options, [&rows](const auto& field, const char* name, const Allowed& allowed,
                                  const char* unit, const char* meaning) {
    using Field = std::decay_t<decltype(field)>;
    ParameterValue value;
    if constexpr (std::is_same_v<Field, int>) {
      value = static_cast<std::int64_t>(field);
    } else {
      value = field;
    }
    rows.push_back({name, value, unit, std::is_same_v<Field, bool> ? "true, false" : allowed.text(),
                    meaning, allowed});
  });
  return rows;
}

/// Options with the defaults of the struct, replaced by what `parameters` names; there may be
/// others among them. `component` is for error texts. Throws ConfigurationError for values that are
/// not allowed.
/// @param known  gets the names of the options.
template <typename Options>
[[nodiscard]] Options read_options_among(const Parameters& parameters, const std::string& component,
                                         std::vector<std::string>& known) {
  Options options;
  Options::visit(options, [&](auto& field, const char* name, const Allowed& allowed,
                              const char* /*unit*/, const char* /*meaning*/) {
    known.emplace_back(name);
    if (const ParameterValue* value = parameters.find(name)) {
      read_value(*value, component.empty() ? name : component + "/" + name, allowed, field);
    }
  });
  return options;
}

/// The same without others. Throws ConfigurationError for unknown keys, too.
template <typename Options>
[[nodiscard]] Options read_options(const Parameters& parameters, const std::string& component) {
  std::vector<std::string> known;
  auto options = read_options_among<Options>(parameters, component, known);
  reject_unknown_keys(parameters, component, known);
  return options;
}

}  // namespace matchbox_slam
