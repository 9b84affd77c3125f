#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "simulation/fault.hpp"
#include "simulation/laser.hpp"
#include "simulation/world_changes.hpp"

namespace matchbox_slam {

/// What a simulated bag tells of its making, so that what its scans truly saw can be computed anew.
struct SimulationRecord {
  std::string world;
  std::uint64_t seed = 1;
  LaserOptions laser;
  std::vector<Fault> faults;  ///< with their times
  WorldChangeOptions changes = {};
};

/// The topic of a simulated bag that carries its record, as a std_msgs/String.
constexpr const char* kSimulationTopic = "/simulation";

/// The world that was driven through. Throws ConfigurationError for one that there is not.
[[nodiscard]] World world_of(const SimulationRecord& record);

/// The record as YAML.
[[nodiscard]] std::string to_yaml(const SimulationRecord& record);

/// The record in YAML. Throws ConfigurationError when it is none, or from a version of this program
/// that has other options.
[[nodiscard]] SimulationRecord parse_simulation_record(const std::string& yaml);

/// The record in a recording; none unless it was simulated. Throws as parse_simulation_record does,
/// and BagError when a bag cannot be read.
[[nodiscard]] std::optional<SimulationRecord> read_simulation_record(
    const std::vector<std::string>& bags);

}  // namespace matchbox_slam
