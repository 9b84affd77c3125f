#pragma once

#include <cstddef>
#include <limits>
#include <map>
#include <string>
#include <vector>

namespace matchbox_slam {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Where the robot may be in the map.
struct Place {
  double x = 0.0;      ///< [m]
  double y = 0.0;      ///< [m]
  double theta = 0.0;  ///< [rad]
  double score = 0.0;  ///< how well the scan fits there, or what share speaks for it, 0 to 1
};

/// What a SLAM node has told of itself, and how long ago.
struct SlamReport {
  double match_age = kInfinity;  ///< [s] since it told of a scan
  std::string state;             ///< after that scan, such as "tracking"
  double score = 0.0;
  double evidence = 0.0;
  double loop_age = kInfinity;         ///< [s] since a loop moved the map
  double diagnostics_age = kInfinity;  ///< [s] since it told how it is
  int level = 0;                       ///< then: 0 well, 1 a warning, 2 an error
  std::string message;
  std::map<std::string, std::string> values;  ///< by their names in /diagnostics
  std::vector<Place> hypotheses;              ///< of the newest scan, the likeliest first
  double elsewhere = 0.0;                     ///< share that speaks for none of them
};

/// How a node is, for people.
struct Assessment {
  std::string headline;
  std::string advice;  ///< what it means, and what to do
  std::string color;   ///< of the headline's background, such as "#2e7d32"
};

/// @param node  its name, for the advice.
[[nodiscard]] Assessment assess(const SlamReport& report, const std::string& node);

/// Whether scans are skipped because somebody wanted that.
[[nodiscard]] bool is_paused(const SlamReport& report);

/// Score, evidence, key scans, loops and maps, as far as they are known; lines of text.
[[nodiscard]] std::string figures_of(const SlamReport& report);

constexpr int kMostHypothesisLines = 4;

/// Where the robot may be by the newest scan, each with the share that speaks for it; as many lines
/// of text, the likeliest first. Empty while that is one place.
[[nodiscard]] std::string hypotheses_of(const SlamReport& report);

/// A line of text. @param rank  from 1 on, the best first.
[[nodiscard]] std::string text_of(const Place& place, std::size_t rank);

/// The words that an option may take, from its `edit_method` as dynamic_reconfigure has it; none
/// where any will do.
[[nodiscard]] std::vector<std::string> words_of(const std::string& edit_method);

/// What `~save_map` calls a map, by the name of one of its files: without .slam and the like.
[[nodiscard]] std::string without_map_extension(const std::string& file);

/// What `~load_map` reads of the map that is named so or by one of its files: a .yaml file is taken
/// as it is, else it is the .slam file.
[[nodiscard]] std::string file_to_load(const std::string& file);

}  // namespace matchbox_slam
