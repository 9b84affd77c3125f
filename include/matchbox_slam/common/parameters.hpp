#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace matchbox_slam {

using ParameterValue = std::variant<bool, std::int64_t, double, std::string, std::vector<double>,
                                    std::vector<std::string>>;

/// The value as a person would write it in YAML. Reading the text back as YAML gives the same
/// value, to the last bit of a double: numbers with a fraction keep their point, text that looks
/// like something else is quoted.
[[nodiscard]] std::string to_string(const ParameterValue& value);

/// The number that a value is, whole or not; none when it is something else.
[[nodiscard]] std::optional<double> number_in(const ParameterValue& value);

/// Reads a value the way YAML 1.2 types a plain scalar: `true`, `12`, `0.5`, `.inf`, `.nan`,
/// anything else is text, taken as it is. Does not depend on the locale. Never throws for its
/// contents.
[[nodiscard]] ParameterValue parse_parameter_value(const std::string& text);

/// A flat set of named values. Nested names are joined with '/', as on the ROS parameter server:
/// `monte_carlo/max_tries`. Where the values came from (YAML, rosparam, command line) is not known
/// here, so that all of them are checked by the same code.
class Parameters {
 public:
  /// Takes a ParameterValue or any of its types, and the literals one would write for them: any
  /// integer, any text. (Left to std::variant, older compilers turn a text literal into a bool.)
  template <typename Value>
  void set(const std::string& key, Value value) {
    if constexpr (std::is_same_v<Value, bool>) {
      values_[key] = value;
    } else if constexpr (std::is_integral_v<Value>) {
      values_[key] = static_cast<std::int64_t>(value);
    } else if constexpr (std::is_convertible_v<Value, std::string>) {
      values_[key] = std::string(std::move(value));
    } else {
      values_[key] = std::move(value);
    }
  }

  /// Null when there is no such key.
  [[nodiscard]] const ParameterValue* find(const std::string& key) const;

  /// All values, sorted by key.
  [[nodiscard]] const std::map<std::string, ParameterValue>& values() const { return values_; }

  [[nodiscard]] bool empty() const { return values_.empty(); }

  /// The values below `name/`, without that prefix.
  [[nodiscard]] Parameters section(const std::string& name) const;

  /// Takes over every value of `other`, replacing those of the same key.
  void merge(const Parameters& other);

 private:
  std::map<std::string, ParameterValue> values_;
};

}  // namespace matchbox_slam
