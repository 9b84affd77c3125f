#include "matchbox_slam/ros/pair_matching.hpp"

#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "matchbox_slam/evaluation/pair_statistics.hpp"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/tum.hpp"
#include "matchbox_slam/io/yaml_parameters.hpp"
#include "matchbox_slam/ros/pair_report.hpp"
#include "matchbox_slam/ros/simulation_record.hpp"
#include "matchbox_slam/ros/slam_setup.hpp"
#include "matchbox_slam/simulation/cramer_rao_bound.hpp"
#include "matchbox_slam/simulation/make_world.hpp"

namespace matchbox_slam {
namespace {

constexpr double kMaxTruthGap = 0.5;  // s

/// The configuration once for each matcher; without names, the configured one.
std::vector<SlamSetup> make_setups(const MatchPairsRequest& request, const Parameters& parameters) {
  const MatcherLoader loader;
  if (request.matchers.empty()) {
    return {make_slam_setup(parameters, loader)};
  }
  std::vector<SlamSetup> setups;
  for (const std::string& matcher : request.matchers) {
    Parameters with_matcher = parameters;
    with_matcher.set("matcher", matcher);
    setups.push_back(make_slam_setup(with_matcher, loader));
  }
  return setups;
}

Parameters gather_parameters(const MatchPairsRequest& request) {
  Parameters parameters = read_yaml_parameters(request.config_files);
  parameters.merge(frame_parameters(request.recording));
  parameters.merge(parse_overrides(request.overrides));
  return parameters;
}

/// True poses by the clock that stamps of scans have after their correction.
class TruthAtScans {
 public:
  TruthAtScans(Trajectory truth, double scan_time_offset)
      : truth_(std::move(truth)), offset_(scan_time_offset) {}

  [[nodiscard]] std::optional<Pose2> at(double stamp) const {
    return truth_.at(stamp - offset_, kMaxTruthGap);
  }

 private:
  Trajectory truth_;
  double offset_;
};

Pose2 motion_during(const ScanInput& input) {
  return input.odometry
             ? input.odometry->odom_from_base.inverse() * input.odometry->odom_from_base_last_beam
             : Pose2{};
}

/// All scans that have truth. Those before a time jump are not forgotten: they are as good.
std::vector<LocatedScan> read_scans(BagScans& scans, const TruthAtScans& truth) {
  std::vector<LocatedScan> located;
  while (std::optional<ScanQueue::Item> item = scans.next()) {
    auto* ready = std::get_if<ReadyScan>(&*item);
    if (ready == nullptr) {
      continue;
    }
    ScanInput& input = ready->input;
    if (const std::optional<Pose2> world_from_base = truth.at(input.scan.stamp)) {
      located.push_back(
          {std::move(input.scan), input.base_from_laser, motion_during(input), *world_from_base});
    }
  }
  return located;
}

/// Whether the scan is what the beams would measure, but for noise and lost readings.
bool is_scan_of(const std::vector<BeamTruth>& beams, const LocatedScan& located, double noise) {
  std::size_t compared = 0;
  std::size_t alike = 0;
  for (std::size_t k = 0; k < std::min(beams.size(), located.scan.ranges.size()); ++k) {
    const double range = located.scan.ranges[k];
    if (std::isfinite(range) && std::isfinite(beams[k].range)) {
      ++compared;
      alike += std::abs(range - beams[k].range) <= 5.0 * noise ? 1 : 0;
    }
  }
  return compared > 0 && alike * 10 >= compared * 9;
}

/// Fisher information of each pair's scan in a simulated recording; empty when it has no bound.
std::vector<Eigen::Matrix3d> information_of(const std::vector<LocatedScan>& scans,
                                            const std::vector<ScanPair>& pairs,
                                            const TruthAtScans& truth,
                                            const SimulationRecord& record,
                                            const RunDialog& dialog) {
  const double noise = record.laser.range_noise;
  if (!(noise > 0.0)) {
    return {};
  }
  const World world = make_world(record.world, record.seed);
  std::vector<Eigen::Matrix3d> information;
  for (const ScanPair& pair : pairs) {
    const LocatedScan& located = scans[pair.scan];
    const PoseAtTime world_from_base = [&](double stamp) {
      return truth.at(stamp).value_or(located.world_from_base);
    };
    const std::vector<BeamTruth> beams =
        trace_beams(world, record.laser, world_from_base, located.scan.stamp);
    if (!is_scan_of(beams, located, noise)) {
      dialog.warn("the scans are not those of the world that the bag names; no bound is told");
      return {};
    }
    information.push_back(fisher_information(beams, located.world_from_base, noise));
  }
  return information;
}

/// The frames and the clock that were found hold for all.
std::vector<LocatedScan> read_recording(const MatchPairsRequest& request,
                                        const Parameters& parameters, const Trajectory& truth,
                                        std::vector<SlamSetup>& setups, double& scan_time_offset,
                                        const RunDialog& dialog) {
  BagScans scans(request.recording, dialog);
  scans.prepare(parameters, setups.front().run);
  for (SlamSetup& setup : setups) {
    setup.run.base_frame = setups.front().run.base_frame;
    setup.run.odom_frame = setups.front().run.odom_frame;
  }
  scan_time_offset = scans.facts().scan_time_offset;
  std::vector<LocatedScan> located = read_scans(scans, TruthAtScans(truth, scan_time_offset));
  if (scans.facts().interrupted) {
    throw BagError("interrupted; nothing is written");
  }
  if (!scans.facts().damage.empty()) {
    throw BagError(scans.facts().damage + "; nothing is written");
  }
  if (scans.account().delivered == 0) {
    scans.throw_nothing_used();
  }
  dialog.inform(std::to_string(located.size()) + " of " + std::to_string(scans.account().received) +
                " scans can be used and have truth");
  return located;
}

}  // namespace

void match_pairs(const MatchPairsRequest& request, const RunDialog& dialog) {
  const Parameters parameters = gather_parameters(request);
  std::vector<SlamSetup> setups = make_setups(request, parameters);
  const Trajectory truth = read_tum(request.truth);
  require_writable_folder(request.out);
  double scan_time_offset = 0.0;
  const std::vector<LocatedScan> scans =
      read_recording(request, parameters, truth, setups, scan_time_offset, dialog);
  const EngineOptions& engine = setups.front().engine;
  const std::vector<ScanPair> pairs =
      draw_pairs(scans, request.pairs, engine.motion, static_cast<std::uint64_t>(request.seed));
  std::vector<std::shared_ptr<const ScanMatcher>> matchers;
  for (const SlamSetup& setup : setups) {
    matchers.push_back(setup.matcher);
  }
  std::vector<std::vector<PairMatch>> matches =
      match_pairs(scans, pairs, matchers, engine, request.threads, [&](std::size_t done) {
        dialog.show_progress(static_cast<double>(done) / static_cast<double>(pairs.size()),
                             std::to_string(done) + " pairs");
        return !dialog.is_interrupted();
      });
  if (matches.empty()) {
    throw EvaluationError("interrupted; nothing is written");
  }

  std::vector<Eigen::Matrix3d> information;
  if (const auto record = read_simulation_record(request.recording.bags)) {
    information =
        information_of(scans, pairs, TruthAtScans(truth, scan_time_offset), *record, dialog);
  }
  const PairTask task{request.recording.bags, request.pairs, SuccessLimits{}, request.seed,
                      request.threads};
  std::vector<MatcherOnPairs> results;
  for (std::size_t m = 0; m < setups.size(); ++m) {
    const PairStatistics statistics = summarize_pairs(pairs, matches[m], information, task.limits);
    results.push_back({matcher_short_name(setups[m].matcher_name), describe_setup(setups[m]),
                       std::move(matches[m]), statistics});
  }
  const std::string table = pairs_markdown(task, results);
  replace_files({{request.out + "/pairs.csv", pairs_csv(scans, pairs, results)},
                 {request.out + "/summary.json", pairs_json(task, results)},
                 {request.out + "/summary.md", table}});
  dialog.inform("\n" + table + "\nresults in " + request.out);
}

}  // namespace matchbox_slam
