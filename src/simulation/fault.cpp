#include "simulation/fault.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

#include "common/number_text.hpp"
#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/common/parameters.hpp"
#include "matchbox_slam/common/random.hpp"

namespace matchbox_slam {
namespace {

constexpr double kMaxDuration = 1e4;  // [s], of a run too

/// What a kind is called, and what its duration and amount may be. Without duration and without
/// amount both limits are 0.
struct FaultKindRow {
  FaultKind kind;
  const char* name;
  const char* meaning;
  double duration;  ///< default [s]
  double longest;
  double amount;  ///< default
  double least;
  double most;
};

constexpr std::array<FaultKindRow, 10> kKinds = {{
    {FaultKind::kFreeze, "freeze",
     "odometry stands still for DURATION s, and afterwards is where it would have been", 1.0,
     kMaxDuration, 0.0, 0.0, 0.0},
    {FaultKind::kEncoders, "encoders",
     "odometry stands still for DURATION s, and what was driven meanwhile is never told", 1.0,
     kMaxDuration, 0.0, 0.0, 0.0},
    {FaultKind::kHeadingSlip, "heading_slip",
     "for DURATION s turns are told too large by the share AMOUNT of them; negative: too small",
     1.0, kMaxDuration, -0.5, -1.0, 10.0},
    {FaultKind::kWaySlip, "way_slip", "likewise distances", 1.0, kMaxDuration, 0.5, -1.0, 10.0},
    {FaultKind::kJump, "jump", "odometry jumps by AMOUNT m, in a random direction", 0.0, 0.0, 0.5,
     0.0, 1e3},
    {FaultKind::kTurnJump, "turn_jump", "odometry jumps by AMOUNT rad", 0.0, 0.0, 0.5, -3.2, 3.2},
    {FaultKind::kKidnap, "kidnap",
     "the robot is carried for DURATION s, to a place of its way at least AMOUNT m away", 3.0,
     kMaxDuration, 3.0, 0.0, 1e3},
    {FaultKind::kDropout, "dropout", "no scan comes for DURATION s", 1.0, kMaxDuration, 0.0, 0.0,
     0.0},
    {FaultKind::kCovered, "covered",
     "for DURATION s the share AMOUNT of the beams, side by side, ends 5 cm from the laser", 1.0,
     kMaxDuration, 1.0, 0.0, 1.0},
    {FaultKind::kPeople, "people",
     "for DURATION s the share AMOUNT of the beams ends early, on people and doors that move", 10.0,
     kMaxDuration, 0.3, 0.0, 1.0},
}};

const FaultKindRow& row_of(FaultKind kind) {
  return *std::find_if(kKinds.begin(), kKinds.end(),
                       [&](const FaultKindRow& row) { return row.kind == kind; });
}

const FaultKindRow& row_named(const std::string& name, const std::string& text) {
  const auto found = std::find_if(kKinds.begin(), kKinds.end(),
                                  [&](const FaultKindRow& row) { return row.name == name; });
  if (found == kKinds.end()) {
    std::vector<std::string> names;
    for (const FaultKindRow& row : kKinds) {
      names.emplace_back(row.name);
    }
    throw ConfigurationError("fault '" + text + "': '" + name +
                             "' is not allowed; allowed: one of " + join(names));
  }
  return *found;
}

double number_of(const std::string& part, double left_out, double low, double high,
                 const std::string& what, const std::string& text) {
  if (part.empty()) {
    return left_out;
  }
  const std::optional<double> number = finite_number(part);
  if (!number || *number < low || *number > high) {
    throw ConfigurationError("fault '" + text + "': the " + what + " '" + part +
                             "' is not allowed; " +
                             (low < high ? "allowed: " + to_string(ParameterValue(low)) + " to " +
                                               to_string(ParameterValue(high))
                                         : "leave it out"));
  }
  return *number;
}

}  // namespace

bool is_any_on(FaultKind kind, double since_start, const std::vector<Fault>& faults) {
  return std::any_of(faults.begin(), faults.end(), [&](const Fault& fault) {
    return fault.kind == kind && fault.is_on(since_start);
  });
}

Fault parse_fault(const std::string& text) {
  std::vector<std::string> parts = split(text, ':');
  if (parts.size() < 2 || parts.size() > 4 || parts[1].empty()) {
    throw ConfigurationError("fault '" + text +
                             "' is not allowed; allowed: KIND:TIME, KIND:TIME:DURATION or "
                             "KIND:TIME:DURATION:AMOUNT, such as freeze:20:1.5");
  }
  parts.resize(4);
  const FaultKindRow& row = row_named(parts[0], text);
  Fault fault;
  fault.kind = row.kind;
  if (parts[1] != "random") {
    fault.time = number_of(parts[1], 0.0, 0.0, kMaxDuration, "time", text);
  }
  fault.duration = number_of(parts[2], row.duration, 0.0, row.longest, "duration", text);
  fault.amount = number_of(parts[3], row.amount, row.least, row.most, "amount", text);
  return fault;
}

std::string to_string(const Fault& fault) {
  const auto text = [](double value) { return to_string(ParameterValue(value)); };
  return std::string(row_of(fault.kind).name) + ":" +
         (std::isnan(fault.time) ? "random" : text(fault.time)) + ":" + text(fault.duration) + ":" +
         text(fault.amount);
}

std::string fault_help() {
  std::string help;
  for (const FaultKindRow& row : kKinds) {
    help += std::string(help.empty() ? "" : "; ") + row.name + ": " + row.meaning;
  }
  return help;
}

std::vector<Fault> with_drawn_times(std::vector<Fault> faults, double run_duration,
                                    std::uint64_t seed) {
  constexpr double kTimeMargin = 10.0;  // [s], so that there is a map before and a drive after
  for (std::size_t i = 0; i < faults.size(); ++i) {
    if (std::isnan(faults[i].time)) {
      const double room = std::max(0.0, run_duration - faults[i].duration);
      const double margin = std::min(kTimeMargin, 0.25 * room);
      faults[i].time = Random(mix_seed(seed, i)).uniform(margin, room - margin);
    }
    if (faults[i].time >= run_duration) {
      throw ConfigurationError("fault '" + to_string(faults[i]) +
                               "' comes too late: the run lasts " +
                               to_string(ParameterValue(run_duration)) +
                               " s; allowed: an earlier time, or a longer run");
    }
  }
  return faults;
}

}  // namespace matchbox_slam
