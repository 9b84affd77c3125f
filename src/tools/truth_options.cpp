#include "tools/truth_options.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "common/number_text.hpp"
#include "io/stata_truth.hpp"
#include "io/tum.hpp"
#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/common/parameters.hpp"
#include "matchbox_slam/io/file.hpp"
#include "tools/pose_text.hpp"
#include "tools/text_table.hpp"

namespace matchbox_slam {
namespace {

Pose2 parse_lever_arm(const std::string& text) {
  if (text.empty()) {
    return {};
  }
  const std::optional<Pose2> lever_arm = parse_pose(text, 1);
  if (!lever_arm) {
    throw ConfigurationError(
        fmt::format("--lever-arm: '{}' is not allowed; allowed: X, X,Y or X,Y,THETA in metres and "
                    "radians, such as 0.275",
                    text));
  }
  return *lever_arm;
}

void check(const TruthOptions& options) {
  if (!(options.max_gap > 0.0) || !std::isfinite(options.max_gap)) {
    throw ConfigurationError(
        fmt::format("--max-gap: {} s is not allowed; allowed: more than 0, and finite",
                    to_string(options.max_gap)));
  }
  constexpr double kGreatestOffset = 1e9;  // [s], more than 30 years
  if (!(std::abs(options.time_offset) <= kGreatestOffset)) {
    throw ConfigurationError(fmt::format("--time-offset: {} s is not allowed; allowed: -1e9 to 1e9",
                                         to_string(options.time_offset)));
  }
  if (!(options.offset_range >= 1.0 && options.offset_range <= ClockOffsetOptions::kWidestRange)) {
    throw ConfigurationError(
        fmt::format("--offset-range: {} s is not allowed; allowed: 1 to {:.0f}",
                    to_string(options.offset_range), ClockOffsetOptions::kWidestRange));
  }
}

Trajectory read_trajectory_of_either_format(const std::string& path) {
  const std::string text = read_file(path);
  return looks_like_stata_truth(text) ? parse_stata_truth(text, path) : parse_tum(text, path);
}

Trajectory moved_to_base(const Trajectory& truth_body, const Pose2& base_from_truth_body) {
  const Pose2 truth_body_from_base = base_from_truth_body.inverse();
  std::vector<StampedPose2> poses = truth_body.poses();
  for (StampedPose2& stamped : poses) {
    stamped.pose = stamped.pose * truth_body_from_base;
  }
  return Trajectory(std::move(poses));
}

Trajectory delayed(const Trajectory& trajectory, double seconds) {
  std::vector<StampedPose2> poses = trajectory.poses();
  for (StampedPose2& stamped : poses) {
    stamped.stamp += seconds;
  }
  return Trajectory(std::move(poses));
}

ClockOffset search_offset(const Truth& truth, const Estimate& estimate) {
  ClockOffsetOptions options;
  options.range = truth.options.offset_range;
  options.max_gap = truth.options.max_gap;
  try {
    return find_clock_offset(estimate.trajectory, truth.trajectory, options);
  } catch (const EvaluationError& error) {
    throw EvaluationError(
        fmt::format("{} against {}: {}", estimate.path, truth.options.path, error.what()));
  }
}

/// Fits ever farther from the least error, both ways, by their offsets: the whole curve has
/// thousands.
std::map<double, ClockOffsetFit> thinned(const ClockOffset& search) {
  std::map<double, ClockOffsetFit> kept;
  for (const double distance :
       {0.0, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0}) {
    for (const double wanted : {search.offset - distance, search.offset + distance}) {
      const auto off = [&](const ClockOffsetFit& fit) { return std::abs(fit.offset - wanted); };
      const ClockOffsetFit& nearest = *std::min_element(
          search.curve.begin(), search.curve.end(),
          [&](const ClockOffsetFit& a, const ClockOffsetFit& b) { return off(a) < off(b); });
      if (off(nearest) < 0.5) {
        kept.emplace(nearest.offset, nearest);
      }
    }
  }
  return kept;
}

std::string describe_search(const Truth& truth) {
  std::vector<std::vector<std::string>> rows = {{"offset s", "rmse m", "poses"}};
  for (const auto& [offset, fit] : thinned(*truth.search)) {
    rows.push_back({fixed_text(offset, 2), fixed_text(fit.rmse, 4), std::to_string(fit.poses)});
  }
  const std::vector<ClockOffsetFit>& curve = truth.search->curve;
  return fmt::format(
      "Clock offset found with {}, best of {} from {:.0f} to {:.0f} s, where enough overlaps; "
      "around it:\n{}",
      truth.searched_with, curve.size(), curve.front().offset, curve.back().offset,
      format_table(rows));
}

nlohmann::json search_to_json(const Truth& truth) {
  nlohmann::json curve = nlohmann::json::array();
  for (const ClockOffsetFit& fit : truth.search->curve) {
    curve.push_back(nlohmann::json::object(
        {{"offset_s", fit.offset}, {"rmse_m", fit.rmse}, {"poses", fit.poses}}));
  }
  return nlohmann::json::object({{"estimate", truth.searched_with},
                                 {"range_s", truth.options.offset_range},
                                 {"curve", curve}});
}

}  // namespace

void add_truth_options(CLI::App& command, TruthOptions& options) {
  command
      .add_option("--truth", options.path,
                  "True trajectory: TUM, or ground truth of MIT Stata (stamp_us,x,y,theta)")
      ->type_name("FILE")
      ->required();
  command
      .add_option("--lever-arm", options.lever_arm,
                  "Pose of the truth's body, such as the laser, on the estimate's [m, rad]")
      ->type_name("X[,Y[,THETA]]");
  CLI::Option* offset = command.add_option(
      "--time-offset", options.time_offset,
      "Added to the truth's stamps: clock of the estimate minus clock of the truth [s]");
  CLI::Option* find =
      command
          .add_flag("--find-offset", options.find_offset, "Find that offset, by the first estimate")
          ->excludes(offset);
  command.add_option("--offset-range", options.offset_range, "Offsets up to this are tried [s]")
      ->needs(find);
  command.add_option("--max-gap", options.max_gap,
                     "Truth is not interpolated across more than this [s]");
}

std::vector<Estimate> read_estimates(const std::vector<std::string>& paths) {
  std::vector<Estimate> estimates;
  for (const std::string& path : paths) {
    estimates.push_back({path, read_tum(path)});
  }
  return estimates;
}

Truth read_truth(const TruthOptions& options, const Estimate& first_estimate) {
  check(options);
  Truth truth;
  truth.options = options;
  truth.base_from_truth_body = parse_lever_arm(options.lever_arm);
  truth.trajectory =
      moved_to_base(read_trajectory_of_either_format(options.path), truth.base_from_truth_body);
  truth.time_offset = options.time_offset;
  if (options.find_offset) {
    truth.search = search_offset(truth, first_estimate);
    truth.searched_with = first_estimate.path;
    truth.time_offset = truth.search->offset;
  }
  truth.trajectory = delayed(truth.trajectory, truth.time_offset);
  return truth;
}

std::string text_of_little_overlap(const Truth& truth, const Estimate& estimate,
                                   std::size_t without_truth) {
  constexpr double kSameClock = 0.5;  // s
  const std::size_t poses = estimate.trajectory.size();
  if (5 * without_truth <= poses) {
    return "";
  }
  const std::string few = fmt::format("{}: only {} of {} poses have truth", estimate.path,
                                      poses - without_truth, poses);
  try {
    const double offset =
        truth.time_offset + (truth.search ? 0.0 : search_offset(truth, estimate).offset);
    return few +
           (std::abs(offset - truth.time_offset) < kSameClock
                ? "; the clocks seem to agree"
                : fmt::format(
                      "; the clocks seem to differ: the two fit best with --time-offset {:.2f}",
                      offset));
  } catch (const EvaluationError&) {
    return few + "; whether the clocks differ cannot be told";
  }
}

std::string describe(const Truth& truth) {
  std::string text;
  if (!truth.options.lever_arm.empty()) {
    const Pose2& arm = truth.base_from_truth_body;
    text += fmt::format(
        "Truth moved to the estimates' body, on which its own is at x {:.3f} m, y {:.3f} m, theta "
        "{:.4f} rad\n",
        arm.x, arm.y, arm.theta);
  }
  if (truth.search) {
    text += describe_search(truth);
  }
  if (truth.search || truth.time_offset != 0.0) {
    const std::string seconds = fixed_text(std::abs(truth.time_offset), 3);
    const bool is_earlier = truth.time_offset < 0.0 && seconds != "0.000";
    text += fmt::format("Truth's stamps {}{} s\n", is_earlier ? "- " : "+ ", seconds);
  }
  text += fmt::format(
      "Truth interpolated at the stamps of the estimate, across gaps of up to {:.2f} s\n",
      truth.options.max_gap);
  return text;
}

nlohmann::json to_json(const Truth& truth) {
  const Pose2& arm = truth.base_from_truth_body;
  const nlohmann::json lever_arm =
      nlohmann::json::object({{"x_m", arm.x}, {"y_m", arm.y}, {"theta_rad", arm.theta}});
  return nlohmann::json::object(
      {{"truth", truth.options.path},
       {"max_gap_s", truth.options.max_gap},
       {"lever_arm", truth.options.lever_arm.empty() ? nlohmann::json() : lever_arm},
       {"time_offset_s", truth.time_offset},
       {"offset_search", truth.search ? search_to_json(truth) : nlohmann::json()}});
}

}  // namespace matchbox_slam
