#include "rviz/slam_report.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <filesystem>

#include "matchbox_slam/geometry/angles.hpp"

namespace matchbox_slam {
namespace {

constexpr double kSilence = 4.0;      // [s]; the node tells how it is once a second
constexpr double kNewLoopAge = 10.0;  // [s]
constexpr int kError = 2;

constexpr const char* kGreen = "#2e7d32";
constexpr const char* kLime = "#9e9d24";
constexpr const char* kAmber = "#ef6c00";
constexpr const char* kRed = "#c62828";
constexpr const char* kBlue = "#1565c0";
constexpr const char* kGrey = "#616161";

std::string value_of(const SlamReport& report, const std::string& name) {
  const auto value = report.values.find(name);
  return value == report.values.end() ? "" : value->second;
}

/// Whether what it tells about itself, once a second, is of the state after the newest scan.
bool is_told_of_now(const SlamReport& report) {
  return report.diagnostics_age < kSilence && value_of(report, "State") == report.state;
}

Assessment assess_tracking(const SlamReport& report) {
  if (is_told_of_now(report) && report.level != 0) {
    return {report.level == kError ? "Error" : "Tracking", report.message,
            report.level == kError ? kRed : kGreen};
  }
  const bool is_new_loop = report.loop_age < kNewLoopAge;
  return {"Tracking",
          is_new_loop ? "A loop was closed: the map has moved, and the robot with it."
                      : "The scans match the map.",
          kGreen};
}

std::string where(const Place& place) {
  return fmt::format("x {:.2f} m,  y {:.2f} m,  {:.0f}\u00b0", place.x, place.y,
                     radians_to_degrees(place.theta));
}

std::string percent(double share) { return fmt::format("{:.0f} %", 100.0 * share); }

/// By the state after a scan, in the words of doc/how_it_works.md.
Assessment assess_state(const SlamReport& report) {
  if (report.state == "tracking") {
    return assess_tracking(report);
  }
  if (report.state == "doubt") {
    return {"In doubt",
            "The robot may be elsewhere than it is thought to be. Drive on: the next scans will "
            "tell, and what is mapped meanwhile moves with it.",
            kAmber};
  }
  if (report.state == "lost") {
    return {"Lost",
            "What is seen is mapped apart, and searched in the map. Drive where the map is known, "
            "or say where the robot is: Relocalise and click a place, or 2D Pose Estimate.",
            kRed};
  }
  if (report.state == "recovered") {
    return {"Recovered",
            "The robot was found. What it mapped apart is being joined to the map; drive on.",
            kBlue};
  }
  return {report.state, "", kGrey};
}

}  // namespace

bool is_paused(const SlamReport& report) { return value_of(report, "Paused") == "yes"; }

Assessment assess(const SlamReport& report, const std::string& node) {
  if (std::min(report.match_age, report.diagnostics_age) > kSilence) {
    return {
        "No node",
        fmt::format("Nothing is heard from {}. Start it, or write its name into the field above.",
                    node),
        kGrey};
  }
  if (is_paused(report)) {
    return {"Paused", "Scans are skipped until Resume.", kBlue};
  }
  if (report.match_age > kSilence) {
    return {"No scans", report.message, report.level == kError ? kRed : kAmber};
  }
  return assess_state(report);
}

std::string figures_of(const SlamReport& report) {
  std::string text;
  if (report.match_age < kInfinity) {
    text += fmt::format("Score {:.2f}, evidence {:.2f}", report.score, report.evidence);
  }
  const std::string key_scans = value_of(report, "Key scans");
  const std::string loops = value_of(report, "Loops closed");
  if (!key_scans.empty()) {
    text += (text.empty() ? "" : "\n") + key_scans +
            (key_scans == "1" ? " key scan, " : " key scans, ") + loops +
            (loops == "1" ? " loop closed" : " loops closed");
  }
  const std::string apart = value_of(report, "Maps apart");
  if (!apart.empty() && apart != "0") {
    text += fmt::format(", {}{}", apart, apart == "1" ? " map apart" : " maps apart");
  }
  return text;
}

std::string hypotheses_of(const SlamReport& report) {
  constexpr double kMinProbability = 0.01;
  const std::vector<Place>& places = report.hypotheses;
  const bool is_one_place =
      report.state != "lost" && places.size() == 1 && report.elsewhere < kMinProbability;
  if (report.match_age > kSilence || places.empty() || is_one_place) {
    return "";
  }
  const std::size_t shown = std::min(places.size(), std::size_t{kMostHypothesisLines - 1});
  std::string text;
  for (std::size_t i = 0; i < shown; ++i) {
    text += fmt::format("{} at {}\n", percent(places[i].score), where(places[i]));
  }
  text += percent(report.elsewhere) + " elsewhere";
  if (places.size() > shown) {
    const std::size_t more = places.size() - shown;
    text += fmt::format(", {}{}", more, more == 1 ? " more place" : " more places");
  }
  return text;
}

std::string text_of(const Place& place, std::size_t rank) {
  return fmt::format("{}:  score {:.2f},  {}", rank, place.score, where(place));
}

std::vector<std::string> words_of(const std::string& edit_method) {
  // It is a dictionary of Python's; the words come after these.
  const std::string before = "'value': '";
  std::vector<std::string> words;
  for (std::size_t at = edit_method.find(before); at != std::string::npos;
       at = edit_method.find(before, at)) {
    at += before.size();
    words.push_back(edit_method.substr(at, edit_method.find('\'', at) - at));
  }
  return words;
}

std::string without_map_extension(const std::string& file) {
  for (const std::string extension :
       std::array{".slam", ".yaml", ".pgm", ".occupancy.png", ".png"}) {
    if (file.size() > extension.size() &&
        file.compare(file.size() - extension.size(), extension.size(), extension) == 0) {
      return file.substr(0, file.size() - extension.size());
    }
  }
  return file;
}

std::string file_to_load(const std::string& file) {
  const bool is_yaml = std::filesystem::path(file).extension() == ".yaml";
  return is_yaml ? file : without_map_extension(file) + ".slam";
}

}  // namespace matchbox_slam
