#include "run/live_configuration.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>

namespace matchbox_slam {

namespace {

constexpr std::array kNodeOptions = {"publish_tf",   "transform_tolerance", "map_update_interval",
                                     "map_file",     "map_format",          "max_lag",
                                     "tf_while_lost"};

bool may_change(const std::string& name) {
  if (name.find('/') == std::string::npos) {
    return std::find(kNodeOptions.begin(), kNodeOptions.end(), name) != kNodeOptions.end();
  }
  // The map is made with these, and scans are by whoever subscribes.
  return name != "map/resolution" && name.rfind("field/", 0) != 0 && name.rfind("cloud/", 0) != 0 &&
         name != "scan/sweep_time" && name != "scan/join_parts";
}

void append_changeable(std::vector<OptionDescription> from, std::vector<OptionDescription>& rows) {
  for (OptionDescription& row : from) {
    if (may_change(row.name)) {
      rows.push_back(std::move(row));
    }
  }
}

/// The matcher by its short name, to be chosen among all.
OptionDescription matcher_choice(const SlamSetup& setup, const MatcherCatalog& catalog) {
  OptionDescription row = describe_options(RunOptions{}).front();
  row.value = matcher_short_name(setup.matcher_name);
  for (const std::string& lookup_name : catalog.lookup_names()) {
    row.limits.words.push_back(matcher_short_name(lookup_name));
  }
  return row;
}

}  // namespace

LiveConfiguration::LiveConfiguration(Parameters parameters, const MatcherCatalog& catalog,
                                     SetupOf whose)
    : parameters_(std::move(parameters)),
      catalog_(&catalog),
      setup_(make_slam_setup(parameters_, catalog, whose)) {}

std::vector<OptionDescription> LiveConfiguration::options() const {
  std::vector<OptionDescription> rows = {matcher_choice(setup_, *catalog_)};
  append_changeable(describe_options(setup_.run), rows);
  append_changeable(describe_options(setup_.node), rows);
  append_changeable(describe_engine_options(setup_.engine), rows);
  for (const std::string& lookup_name : catalog_->lookup_names()) {
    const std::string section = matcher_short_name(lookup_name);
    std::shared_ptr<ScanMatcher> matcher;
    try {
      matcher = catalog_->create(lookup_name);
    } catch (const ConfigurationError&) {
      continue;  // whoever chooses it is told why it cannot be loaded
    }
    matcher->configure(parameters_.section(section));
    for (OptionDescription& row : matcher->options()) {
      row.name = fmt::format("{}/{}", section, row.name);
      rows.push_back(std::move(row));
    }
  }
  return rows;
}

LiveConfiguration LiveConfiguration::with(const Parameters& changes) const {
  for (const auto& [name, value] : changes.values()) {
    if (name != "matcher" && !may_change(name)) {
      throw ConfigurationError(name +
                               ": cannot be changed while running; restart the node with it");
    }
  }
  Parameters changed = parameters_;
  changed.merge(changes);
  return {changed, *catalog_};
}

}  // namespace matchbox_slam
