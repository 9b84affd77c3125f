#include "bag/simulation_record.hpp"

#include <fmt/core.h>
#include <ros/message_traits.h>
#include <std_msgs/String.h>

#include <charconv>
#include <cstddef>
#include <utility>

#include "bag/bag_file.hpp"
#include "bag/recording_kind.hpp"
#include "matchbox_slam/io/yaml_parameters.hpp"
#include "simulation/make_world.hpp"

namespace matchbox_slam {
namespace {

std::string text_of(const Parameters& parameters, const std::string& name) {
  const ParameterValue* value = parameters.find(name);
  const auto* text = value != nullptr ? std::get_if<std::string>(value) : nullptr;
  if (text == nullptr) {
    throw ConfigurationError(fmt::format("{}: there is no text '{}'", kSimulationTopic, name));
  }
  return *text;
}

/// Options that programs before them refuse are told of only where they matter, so that all other
/// records can be read by those.
bool is_of_later_version(const std::string& option) {
  return option == "range_noise_square" || option == "parts" || option == "sent_time_increment" ||
         option == "sent_scan_time";
}

std::uint64_t seed_of(const std::string& text) {
  std::uint64_t seed = 0;
  const char* end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, seed);
  if (error != std::errc() || rest != end) {
    throw ConfigurationError(
        fmt::format("{}: seed: '{}' is no whole number", kSimulationTopic, text));
  }
  return seed;
}

}  // namespace

World world_of(const SimulationRecord& record) {
  return changed(make_world(record.world, record.seed), record.changes).world;
}

std::string to_yaml(const SimulationRecord& record) {
  Parameters parameters;
  parameters.set("world", record.world);
  // As text, since a seed may be larger than a number in YAML.
  parameters.set("seed", std::to_string(record.seed));
  const std::vector<OptionDescription> defaults = describe_options(LaserOptions{});
  const std::vector<OptionDescription> rows = describe_options(record.laser);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (!is_of_later_version(rows[i].name) || rows[i].value != defaults[i].value) {
      parameters.set("laser/" + rows[i].name, rows[i].value);
    }
  }
  std::vector<std::string> faults;
  for (const Fault& fault : record.faults) {
    faults.push_back(to_string(fault));
  }
  if (!faults.empty()) {
    parameters.set("faults", faults);
  }
  if (record.changes.any()) {
    for (const OptionDescription& row : describe_options(record.changes)) {
      parameters.set("changes/" + row.name, row.value);
    }
  }
  return to_yaml(parameters);
}

SimulationRecord parse_simulation_record(const std::string& yaml) {
  const Parameters parameters = parse_yaml_parameters(yaml, kSimulationTopic);
  SimulationRecord record;
  record.world = text_of(parameters, "world");
  record.seed = seed_of(text_of(parameters, "seed"));
  record.laser = read_options<LaserOptions>(parameters.section("laser"), kSimulationTopic);
  record.changes =
      read_options<WorldChangeOptions>(parameters.section("changes"), kSimulationTopic);
  if (const ParameterValue* faults = parameters.find("faults")) {
    const auto* texts = std::get_if<std::vector<std::string>>(faults);
    if (texts == nullptr) {
      throw ConfigurationError(std::string(kSimulationTopic) + ": 'faults' is no list of texts");
    }
    for (const std::string& text : *texts) {
      record.faults.push_back(parse_fault(text));
    }
  }
  return record;
}

std::optional<SimulationRecord> read_simulation_record(const std::vector<std::string>& bags) {
  for (const std::string& path : bags) {
    if (recording_kind(path).format != RecordingKind::Format::kRos1Bag) {
      continue;  // simulate writes bags of ROS 1 alone
    }
    const BagFile bag(path);
    BagSelection selection;
    for (const auto& [number, connection] : bag.connections()) {
      if (connection.topic == kSimulationTopic &&
          connection.md5sum == ros::message_traits::md5sum<std_msgs::String>()) {
        selection.connections.insert(number);
      }
    }
    BagEntries entries(bag, std::move(selection));
    const BagEntry* entry = entries.peek();
    if (entry == nullptr) {
      continue;
    }
    try {
      return parse_simulation_record(BagMessageReader(bag).read(*entry).array().text());
    } catch (const ByteError& error) {
      throw BagError(fmt::format("bag '{}': the record of the simulation cannot be read: {}", path,
                                 error.what()));
    }
  }
  return std::nullopt;
}

}  // namespace matchbox_slam
