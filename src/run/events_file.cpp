#include "run/events_file.hpp"

#include <fmt/core.h>

#include <array>
#include <memory>
#include <sstream>
#include <variant>

#include "matchbox_slam/io/yaml_parameters.hpp"
#include "matchbox_slam/matching/scan_matcher.hpp"
#include "run/setup_parts.hpp"
#include "run/start_map.hpp"

namespace matchbox_slam {
namespace {

constexpr std::array kKinds = {"set_pose", "correct_pose", "be_anywhere", "reset",
                               "load",     "pause",        "reconfigure", "leave_out"};

/// An entry but for the sections of its event.
struct Entry {
  double scan = 0.0;
  int laser = 0;
  int time_jumps = 0;
  bool be_anywhere = true;
  bool reset = true;
  std::string load;
  bool pause = true;
  bool leave_out = true;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor&& option) {
    option(self.scan, "scan", any(), "s", "");
    option(self.laser, "laser", at_least(0.0), "", "");
    option(self.time_jumps, "time_jumps", at_least(0.0), "", "");
    option(self.be_anywhere, "be_anywhere", any(), "", "");
    option(self.reset, "reset", any(), "", "");
    option(self.load, "load", any(), "", "");
    option(self.pause, "pause", any(), "", "");
    option(self.leave_out, "leave_out", any(), "", "");
  }
};

struct PoseEntry {
  double scan = 0.0;
  double x = 0.0;
  double y = 0.0;
  double theta = 0.0;
  std::vector<double> covariance;

  [[nodiscard]] Pose2 pose() const { return {x, y, wrap_angle(theta)}; }

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor&& option) {
    option(self.scan, "scan", any(), "s", "");
    option(self.x, "x", between(-1e8, 1e8), "m", "");
    option(self.y, "y", between(-1e8, 1e8), "m", "");
    option(self.theta, "theta", any(), "rad", "");
    option(self.covariance, "covariance", any(), "", "");
  }
};

// --- reading ---

Eigen::Matrix3d to_covariance(const std::vector<double>& numbers) {
  if (numbers.size() == 9) {
    Eigen::Matrix3d matrix =
        Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(numbers.data());
    if (is_covariance(matrix)) {
      return matrix;
    }
  }
  throw ConfigurationError(
      "set_pose/covariance is none: it has to be 9 numbers, those of a symmetric 3x3 matrix "
      "without negative variance in any direction");
}

PoseEntry read_pose(const Parameters& entry, const std::string& kind,
                    const std::vector<std::string>& needed) {
  const Parameters section = entry.section(kind);
  reject_unknown_keys(section, kind, needed);
  for (const std::string& name : needed) {
    if (section.find(name) == nullptr) {
      throw ConfigurationError(fmt::format("{}/{} is missing", kind, name));
    }
  }
  return read_options<PoseEntry>(section, kind);
}

/// The one kind of event among the names of an entry.
std::string kind_of(const Parameters& names) {
  std::vector<std::string> known = {"scan", "laser", "time_jumps"};
  known.insert(known.end(), kKinds.begin(), kKinds.end());
  reject_unknown_keys(names, "", known);
  std::vector<std::string> given;
  for (const char* kind : kKinds) {
    if (names.find(kind) != nullptr) {
      given.emplace_back(kind);
    }
  }
  if (given.size() != 1) {
    throw ConfigurationError(fmt::format("an entry has to give one of {}; it gives {}",
                                         join({kKinds.begin(), kKinds.end()}),
                                         given.empty() ? "none" : join(given)));
  }
  return given.front();
}

RunEvent read_event(const std::string& kind, const Parameters& parameters, const Entry& entry,
                    const SlamSetup& setup) {
  if (kind == "set_pose") {
    const PoseEntry told = read_pose(parameters, kind, {"x", "y", "theta", "covariance"});
    return SetPose{told.pose(), to_covariance(told.covariance)};
  }
  if (kind == "correct_pose") {
    const PoseEntry found = read_pose(parameters, kind, {"scan", "x", "y", "theta"});
    return CorrectPose{found.scan, found.pose()};
  }
  if (kind == "load") {
    return LoadMapFile{entry.load,
                       std::make_shared<const EngineState>(read_start_map(entry.load, setup))};
  }
  if (kind == "pause") {
    return Pause{entry.pause};
  }
  if (kind == "reconfigure") {
    return Reconfigure{parameters.section(kind)};
  }
  if (!entry.reset || !entry.leave_out || !entry.be_anywhere) {
    throw ConfigurationError(kind +
                             ": false is not allowed; allowed: true, or leave the entry out");
  }
  if (kind == "leave_out") {
    return LeaveOut{};
  }
  if (kind == "be_anywhere") {
    return BeAnywhere{};
  }
  return Reset{};
}

TimedEvent read_timed_event(const Parameters& parameters, const SlamSetup& setup) {
  Parameters names;
  Parameters plain;
  for (const auto& [name, value] : parameters.values()) {
    const std::string part = name.substr(0, name.find('/'));
    names.set(part, value);
    const bool is_section = part == "set_pose" || part == "correct_pose" || part == "reconfigure";
    if (is_section && part == name) {
      throw ConfigurationError(name + ": has to be a map of names to values");
    }
    if (!is_section) {
      plain.set(name, value);
    }
  }
  const std::string kind = kind_of(names);
  const auto entry = read_options<Entry>(plain, "");
  if (plain.find("scan") == nullptr) {
    throw ConfigurationError("scan is missing: the stamp of the scan before which the event comes");
  }
  return {{entry.time_jumps, entry.scan, entry.laser}, read_event(kind, parameters, entry, setup)};
}

// --- writing ---

Parameters pose_parameters(const std::string& kind, const Pose2& pose) {
  Parameters parameters;
  parameters.set(kind + "/x", pose.x);
  parameters.set(kind + "/y", pose.y);
  parameters.set(kind + "/theta", pose.theta);
  return parameters;
}

struct ToParameters {
  Parameters operator()(const SetPose& event) const {
    Parameters parameters = pose_parameters("set_pose", event.map_from_base);
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> rows = event.covariance;
    parameters.set("set_pose/covariance",
                   std::vector<double>(rows.data(), rows.data() + rows.size()));
    return parameters;
  }
  Parameters operator()(const CorrectPose& event) const {
    Parameters parameters = pose_parameters("correct_pose", event.map_from_base);
    parameters.set("correct_pose/scan", event.stamp);
    return parameters;
  }
  Parameters operator()(const BeAnywhere& /*event*/) const { return single("be_anywhere", true); }
  Parameters operator()(const Reset& /*event*/) const { return single("reset", true); }
  Parameters operator()(const LoadMapFile& event) const { return single("load", event.path); }
  Parameters operator()(const Pause& event) const { return single("pause", event.paused); }
  Parameters operator()(const LeaveOut& /*event*/) const { return single("leave_out", true); }
  Parameters operator()(const Reconfigure& event) const {
    Parameters parameters;
    for (const auto& [name, value] : event.changes.values()) {
      parameters.set("reconfigure/" + name, value);
    }
    return parameters;
  }

  template <typename Value>
  static Parameters single(const std::string& name, const Value& value) {
    Parameters parameters;
    parameters.set(name, value);
    return parameters;
  }
};

}  // namespace

std::string to_events_file(const std::vector<TimedEvent>& events) {
  std::string text = "# What happened to a run between its scans; map_bag --events repeats it.\n";
  for (const TimedEvent& event : events) {
    Parameters entry = std::visit(ToParameters{}, event.event);
    entry.set("scan", event.scan.stamp);
    if (event.scan.laser != 0) {
      entry.set("laser", event.scan.laser);
    }
    if (event.scan.time_jumps != 0) {
      entry.set("time_jumps", event.scan.time_jumps);
    }
    std::istringstream lines(to_yaml(entry));
    std::string mark = "- ";
    for (std::string line; std::getline(lines, line); mark = "  ") {
      text += fmt::format("{}{}\n", mark, line);
    }
  }
  return text;
}

std::vector<TimedEvent> read_events_file(const std::string& path, LiveConfiguration configuration) {
  std::vector<TimedEvent> events;
  for (const ParameterEntry& entry : read_yaml_list(path)) {
    try {
      events.push_back(read_timed_event(entry.parameters, configuration.setup()));
      if (const auto* change = std::get_if<Reconfigure>(&events.back().event)) {
        configuration = configuration.with(change->changes);
      }
      if (events.size() > 1 && events.back().scan < events[events.size() - 2].scan) {
        throw ConfigurationError("scan: the entry before comes later; they have to be in order");
      }
    } catch (const std::exception& error) {
      throw ConfigurationError(fmt::format("{}:{}: {}", path, entry.line, error.what()));
    }
  }
  return events;
}

}  // namespace matchbox_slam
