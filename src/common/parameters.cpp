#include "matchbox_slam/common/parameters.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <limits>
#include <locale>
#include <optional>
#include <sstream>
#include <string_view>

namespace matchbox_slam {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// What streams take in the classic locale is the YAML 1.2 core schema:
/// [-+]? digits, and [-+]? (digits [. digits?] | . digits) ([eE] [-+]? digits)?
template <typename Number>
std::optional<Number> read_number(const std::string& text) {
  std::istringstream stream(text);
  stream.imbue(std::locale::classic());
  Number number{};
  stream >> std::noskipws >> number;
  if (stream.fail() || stream.peek() != std::istringstream::traits_type::eof()) {
    return std::nullopt;
  }
  return number;
}

std::optional<double> parse_not_finite(const std::string& text) {
  std::string lower = text;
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (lower == ".inf" || lower == "+.inf") {
    return kInfinity;
  }
  if (lower == "-.inf") {
    return -kInfinity;
  }
  if (lower == ".nan") {
    return std::numeric_limits<double>::quiet_NaN();
  }
  return std::nullopt;
}

/// The fewest digits that read back as the same number.
std::string shortest_text(double value) {
  for (int digits = std::numeric_limits<double>::digits10;; ++digits) {
    std::ostringstream stream;
    stream.imbue(std::locale::classic());
    stream.precision(digits);
    stream << value;
    if (digits == std::numeric_limits<double>::max_digits10 ||
        read_number<double>(stream.str()) == value) {
      return stream.str();
    }
  }
}

std::string real_text(double value) {
  if (std::isnan(value)) {
    return ".nan";
  }
  if (std::isinf(value)) {
    return value > 0.0 ? ".inf" : "-.inf";
  }
  const std::string text = shortest_text(value);
  return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}

/// Whether YAML takes the text as it is, also within a list, and other readers of YAML do too.
bool is_plain(const std::string& text) {
  static const std::vector<std::string> kWords = {"yes", "no",   "on",   "off",  "y",
                                                  "n",   "null", "true", "false"};
  std::string lower;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) == 0 && std::string("_/.-").find(c) == std::string::npos) {
      return false;
    }
    lower.push_back(static_cast<char>(std::tolower(byte)));
  }
  return !text.empty() &&
         (std::isalpha(static_cast<unsigned char>(text[0])) != 0 || text[0] == '/' ||
          text[0] == '_') &&
         std::find(kWords.begin(), kWords.end(), lower) == kWords.end() &&
         std::holds_alternative<std::string>(parse_parameter_value(text));
}

std::string escaped(unsigned char c) {
  constexpr std::string_view kSpecial = "\"\\\n\t";
  constexpr std::string_view kLetters = "\"\\nt";
  if (const std::size_t at = kSpecial.find(static_cast<char>(c)); at != std::string_view::npos) {
    return {'\\', kLetters[at]};
  }
  if (c >= 0x20U) {
    return {static_cast<char>(c)};
  }
  constexpr std::string_view kHex = "0123456789abcdef";
  return {'\\', 'x', kHex[c >> 4U], kHex[c & 15U]};
}

std::string quoted_when_needed(const std::string& text) {
  if (is_plain(text)) {
    return text;
  }
  std::string quoted = "\"";
  for (const char c : text) {
    quoted += escaped(static_cast<unsigned char>(c));
  }
  return quoted + '"';
}

struct YamlWriter {
  std::string operator()(bool value) const { return value ? "true" : "false"; }
  std::string operator()(std::int64_t value) const { return std::to_string(value); }
  std::string operator()(double value) const { return real_text(value); }
  std::string operator()(const std::string& value) const { return quoted_when_needed(value); }

  template <typename Element>
  std::string operator()(const std::vector<Element>& values) const {
    std::string text = "[";
    for (const Element& value : values) {
      text += (text.size() > 1 ? ", " : "") + (*this)(value);
    }
    return text + "]";
  }
};

}  // namespace

std::string to_string(const ParameterValue& value) { return std::visit(YamlWriter{}, value); }

ParameterValue parse_parameter_value(const std::string& text) {
  if (text == "true" || text == "True" || text == "TRUE") {
    return true;
  }
  if (text == "false" || text == "False" || text == "FALSE") {
    return false;
  }
  if (const std::optional<double> number = parse_not_finite(text)) {
    return *number;
  }
  if (const std::optional<std::int64_t> number = read_number<std::int64_t>(text)) {
    return *number;
  }
  if (const std::optional<double> number = read_number<double>(text)) {
    return *number;  // also an integer beyond 64 bits
  }
  return text;
}

std::optional<double> number_in(const ParameterValue& value) {
  if (const auto* whole = std::get_if<std::int64_t>(&value)) {
    return static_cast<double>(*whole);
  }
  const auto* real = std::get_if<double>(&value);
  return real != nullptr ? std::optional<double>(*real) : std::nullopt;
}

const ParameterValue* Parameters::find(const std::string& key) const {
  const auto found = values_.find(key);
  return found == values_.end() ? nullptr : &found->second;
}

Parameters Parameters::section(const std::string& name) const {
  const std::string prefix = name + "/";
  Parameters result;
  for (auto it = values_.lower_bound(prefix);
       it != values_.end() && it->first.compare(0, prefix.size(), prefix) == 0; ++it) {
    result.values_.emplace(it->first.substr(prefix.size()), it->second);
  }
  return result;
}

void Parameters::merge(const Parameters& other) {
  for (const auto& [key, value] : other.values_) {
    values_[key] = value;
  }
}

}  // namespace matchbox_slam
