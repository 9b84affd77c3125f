#include "run/setup_parts.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <utility>

#include "common/known_names.hpp"

namespace matchbox_slam {

namespace {

bool is_among(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// The options in sections, by their whole names.
std::vector<std::string> all_in_sections(const std::vector<std::string>& sections,
                                         const std::vector<OptionDescription>& in_sections,
                                         const MatcherCatalog& catalog) {
  std::vector<std::string> all;
  for (const OptionDescription& row : in_sections) {
    if (is_among(sections, row.name.substr(0, row.name.find('/')))) {
      all.push_back(row.name);
    }
  }
  for (const std::string& lookup_name : catalog.lookup_names()) {
    try {
      for (const OptionDescription& row : catalog.create(lookup_name)->options()) {
        all.push_back(fmt::format("{}/{}", matcher_short_name(lookup_name), row.name));
      }
    } catch (const ConfigurationError&) {
      continue;  // whoever chooses it is told why it cannot be loaded
    }
  }
  return all;
}

/// Those of that name, else the only one whose name begins with it.
std::vector<std::string> meant_of(const std::vector<std::string>& all, const std::string& name) {
  constexpr std::size_t kMinLetters = 3;  // letters, as of nearest_name
  std::vector<std::string> same;
  std::vector<std::string> longer;
  for (const std::string& whole : all) {
    const std::string own = whole.substr(whole.find('/') + 1);
    if (own == name) {
      same.push_back(whole);
    } else if (own.rfind(name, 0) == 0) {
      longer.push_back(whole);
    }
  }
  const bool is_beginning = same.empty() && longer.size() == 1 && name.size() >= kMinLetters;
  return is_beginning ? longer : same;
}

/// Options of version 1 that have another name now.
constexpr std::array<std::pair<const char*, const char*>, 2> kRenamedOptions = {
    {{"loops/apart", "loops/max_relative_sigma"},
     {"motion/least_share", "motion/min_noise_scale"}}};

/// Options that were the same for everybody, and what they are.
constexpr std::array<std::pair<const char*, const char*>, 5> kSettledOptions = {
    {{"hypotheses/carried", "9.2"},
     {"hypotheses/search_theta", "1 rad"},
     {"hypotheses/search_xy", "0.5 m"},
     {"hypotheses/unexpected", "7"},
     {"loops/search_way", "1 m"}}};

/// Options of version 1 whose place others have taken.
void reject_former(const std::string& key, const std::string& section) {
  if (key == "loops/most_contradiction" || key == "loops/least_mutual_fit") {
    throw ConfigurationError(key +
                             ": there is no such option since version 2; loops/decisive took "
                             "its place: see doc/parameters.md");
  }
  if (section == "doubt" || section == "tracking") {
    throw ConfigurationError(
        fmt::format("{}: there is no such option since version 2; hypotheses/{} took its place: "
                    "see doc/parameters.md",
                    key, key == "doubt/enabled" ? "enabled" : "*"));
  }
  constexpr std::array kConfirmationOptions = {"recovery/key_scans", "recovery/confirmations",
                                               "recovery/far_confirmations", "recovery/least_score",
                                               "recovery/distance"};
  if (std::find(kConfirmationOptions.begin(), kConfirmationOptions.end(), key) !=
      kConfirmationOptions.end()) {
    throw ConfigurationError(fmt::format(
        "{}: there is no such option since version 2; {} took its place: see doc/parameters.md",
        key, key == "recovery/key_scans" ? "recovery/places" : "recovery/sure"));
  }
  if (key == "olson/widenings") {
    throw ConfigurationError(
        "olson/widenings: there is no such option since version 2; windows are not widened, "
        "olson/window_sigmas, window_xy and window_theta say how wide they are; leave it out");
  }
  for (const auto& [former, value] : kSettledOptions) {
    if (key == former) {
      throw ConfigurationError(
          fmt::format("{}: this is no option, it is {} for everybody; leave it out", key, value));
    }
  }
  for (const auto& [former, now] : kRenamedOptions) {
    if (key == former) {
      throw ConfigurationError(
          fmt::format("{}: since version 2 this option is called {}; write that", key, now));
    }
  }
}

}  // namespace

std::vector<std::string> reject_unknown_names(const Parameters& parameters,
                                              const std::vector<std::string>& options,
                                              std::vector<std::string> sections,
                                              const std::vector<OptionDescription>& in_sections,
                                              const MatcherCatalog& catalog) {
  std::vector<std::string> matchers = catalog.names_at_hand();
  const std::size_t of_engine = sections.size();
  const auto add_sections = [&] {
    sections.resize(of_engine);
    std::transform(matchers.begin(), matchers.end(), std::back_inserter(sections),
                   matcher_short_name);
  };
  add_sections();
  const auto& values = parameters.values();
  if (std::any_of(values.begin(), values.end(), [&](const auto& value) {
        const std::size_t slash = value.first.find('/');
        return !is_among(slash == std::string::npos ? options : sections,
                         value.first.substr(0, slash));
      })) {
    matchers = catalog.lookup_names();
    add_sections();
  }
  for (const auto& [key, value] : parameters.values()) {
    const std::size_t slash = key.find('/');
    const bool is_plain = slash == std::string::npos;
    const std::vector<std::string>& known = is_plain ? options : sections;
    const std::string name = key.substr(0, slash);
    reject_former(key, name);
    if (is_among(known, name)) {
      continue;
    }
    std::vector<std::string> meant;
    if (is_plain) {
      meant = meant_of(all_in_sections(sections, in_sections, catalog), name);
    }
    if (const std::string nearest = nearest_name(name, known); meant.empty() && !nearest.empty()) {
      meant = {nearest};
    }
    throw ConfigurationError(
        unknown_name_text(is_plain ? "parameter" : "section", name, meant, known));
  }
  return matchers;
}

std::shared_ptr<const ScanMatcher> make_matcher(const Parameters& parameters,
                                                const MatcherCatalog& catalog,
                                                const std::string& lookup_name,
                                                const std::vector<std::string>& others) {
  const std::shared_ptr<ScanMatcher> matcher = catalog.create(lookup_name);
  matcher->configure(parameters.section(matcher_short_name(lookup_name)));
  for (const std::string& other : others) {
    const Parameters options = parameters.section(matcher_short_name(other));
    if (other != lookup_name && !options.values().empty()) {
      catalog.create(other)->configure(options);
    }
  }
  return matcher;
}

}  // namespace matchbox_slam
