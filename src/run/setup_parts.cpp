#include "run/setup_parts.hpp"

#include <cstddef>

namespace matchbox_slam {

void reject_unknown_names(const Parameters& parameters, const std::vector<std::string>& options,
                          std::vector<std::string> sections, const MatcherCatalog& catalog) {
  for (const std::string& lookup_name : catalog.lookup_names()) {
    sections.push_back(matcher_short_name(lookup_name));
  }
  Parameters names_in_sections;
  Parameters plain_names;
  for (const auto& [key, value] : parameters.values()) {
    const std::size_t slash = key.find('/');
    (slash == std::string::npos ? plain_names : names_in_sections).set(key.substr(0, slash), value);
  }
  reject_unknown_keys(plain_names, "", options);
  reject_unknown_keys(names_in_sections, "sections", sections);
}

std::shared_ptr<const ScanMatcher> make_matcher(const Parameters& parameters,
                                                const MatcherCatalog& catalog,
                                                const std::string& lookup_name) {
  const std::shared_ptr<ScanMatcher> matcher = catalog.create(lookup_name);
  matcher->configure(parameters.section(matcher_short_name(lookup_name)));
  for (const std::string& other : catalog.lookup_names()) {
    const Parameters options = parameters.section(matcher_short_name(other));
    if (other != lookup_name && !options.values().empty()) {
      catalog.create(other)->configure(options);
    }
  }
  return matcher;
}

}  // namespace matchbox_slam
