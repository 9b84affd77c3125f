#include "run/matcher_catalog.hpp"

#include <fmt/core.h>

#include <cctype>
#include <cstddef>

#include "matchbox_slam/common/options.hpp"

namespace matchbox_slam {
namespace {

bool is_upper(char c) { return std::isupper(static_cast<unsigned char>(c)) != 0; }

}  // namespace

std::string matcher_short_name(const std::string& lookup_name) {
  const std::string name = lookup_name.substr(lookup_name.rfind('/') + 1);
  std::string snake;
  for (std::size_t i = 0; i < name.size(); ++i) {
    const bool ends_acronym =
        i + 1 < name.size() && i > 0 && is_upper(name[i - 1]) && !is_upper(name[i + 1]);
    if (is_upper(name[i]) && i > 0 && name[i - 1] != '_' &&
        (!is_upper(name[i - 1]) || ends_acronym)) {
      snake += '_';
    }
    snake += static_cast<char>(std::tolower(static_cast<unsigned char>(name[i])));
  }
  return snake;
}

std::string MatcherCatalog::find(const std::string& name) const {
  for (const std::string& lookup_name : names_at_hand()) {
    if (lookup_name == name || matcher_short_name(lookup_name) == name) {
      return lookup_name;
    }
  }
  const std::vector<std::string> declared = lookup_names();
  std::vector<std::string> fitting;
  std::vector<std::string> short_names;
  for (const std::string& lookup_name : declared) {
    short_names.push_back(matcher_short_name(lookup_name));
    if (lookup_name == name) {
      return lookup_name;
    }
    if (short_names.back() == name) {
      fitting.push_back(lookup_name);
    }
  }
  if (fitting.size() > 1) {
    throw ConfigurationError(
        fmt::format("matcher '{}' may be any of {}; give the full name", name, join(fitting)));
  }
  if (fitting.empty()) {
    throw ConfigurationError(fmt::format("there is no matcher '{}'; known: {} (or {})", name,
                                         join(short_names), join(declared)));
  }
  return fitting.front();
}

}  // namespace matchbox_slam
