#include "tools/pair_matching.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>

#include "bag/simulation_record.hpp"
#include "common/interrupted.hpp"
#include "evaluation/error_statistics.hpp"
#include "evaluation/pair_statistics.hpp"
#include "io/hough_picture.hpp"
#include "io/tum.hpp"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/matching/hough/hough_transform.hpp"
#include "ros/matcher_loader.hpp"
#include "run/slam_setup.hpp"
#include "simulation/cramer_rao_bound.hpp"
#include "tools/pair_report.hpp"

namespace matchbox_slam {
namespace {

/// The configuration once for each matcher; without names, the configured one.
std::vector<SlamSetup> make_setups(const MatchPairsRequest& request, const Parameters& parameters) {
  const MatcherLoader loader;
  if (request.matchers.empty()) {
    return {make_slam_setup(parameters, loader, SetupOf::kProgram)};
  }
  std::vector<SlamSetup> setups;
  std::set<std::string> names;
  for (const std::string& matcher : request.matchers) {
    Parameters with_matcher = parameters;
    with_matcher.set("matcher", matcher);
    setups.push_back(make_slam_setup(with_matcher, loader, SetupOf::kProgram));
    if (!names.insert(setups.back().matcher_name).second) {
      throw ConfigurationError(
          fmt::format("--matcher: '{}' is given twice; to compare configurations of one matcher, "
                      "run once for each, into two folders",
                      matcher));
    }
  }
  return setups;
}

/// True poses by the clock that stamps of scans have after their correction.
class TruthAtScans {
 public:
  TruthAtScans(Trajectory truth, double scan_time_offset)
      : truth_(std::move(truth)), offset_(scan_time_offset) {}

  [[nodiscard]] std::optional<Pose2> at(double stamp) const {
    return truth_.at(stamp - offset_, kDefaultMaxGap);
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

/// The scans of a recording that have truth, and how they were found.
struct LocatedScans {
  std::vector<LocatedScan> scans;
  PairFacts facts;
};

/// All scans that have truth; of a recording in which time jumps back, those after the last jump.
std::vector<LocatedScan> locate_scans(BagScans& scans, const TruthAtScans& truth,
                                      const RunDialog& dialog) {
  std::vector<LocatedScan> located;
  std::size_t number = 0;
  while (std::optional<ScanQueue::Item> item = scans.next()) {
    if (const auto* jump = std::get_if<TimeJump>(&*item)) {
      dialog.warn(text_of(*jump, number) + (jump->stopped ? "stopping there, as time_jump is 'stop'"
                                                          : "leaving out what was before"));
      if (!jump->stopped) {
        located.clear();
        scans.discard_delivered();
      }
      continue;
    }
    auto* scan = std::get_if<ReadyScan>(&*item);
    if (scan == nullptr) {
      continue;
    }
    ScanInput& input = scan->input;
    if (const std::optional<Pose2> world_from_base = truth.at(input.scan.stamp)) {
      located.push_back({std::move(input.scan), input.base_from_laser, motion_during(input),
                         *world_from_base, number, input.laser_motion});
    }
    ++number;
  }
  return located;
}

void require_complete(const BagScans& scans) {
  if (scans.facts().interrupted) {
    throw Interrupted("interrupted; nothing is written");
  }
  if (!scans.facts().damage.empty()) {
    throw BagError(scans.facts().damage + "; nothing is written");
  }
  if (scans.account().delivered == 0) {
    scans.throw_nothing_used();
  }
}

/// The frames and the clock that are found hold for all setups.
LocatedScans read_recording(const MatchPairsRequest& request, const Parameters& parameters,
                            const Trajectory& truth, std::vector<SlamSetup>& setups,
                            const RunDialog& dialog) {
  BagScans scans(request.recording, dialog);
  const RunOptions found = scans.prepare(parameters, setups.front().run);
  for (SlamSetup& setup : setups) {
    setup.run.base_frame = found.base_frame;
    setup.run.odom_frame = found.odom_frame;
  }
  const double offset = scans.facts().scan_time_offset;
  LocatedScans located;
  located.scans = locate_scans(scans, TruthAtScans(truth, offset), dialog);
  require_complete(scans);
  located.facts = {scans.facts(), request.truth, scans.account().received, located.scans.size()};
  if (located.scans.empty()) {
    throw EvaluationError(fmt::format(
        "none of {} scans has truth: {} is from {:f} to {:f} s; is it in the clock of the scans?",
        scans.account().delivered, request.truth, truth.poses().front().stamp,
        truth.poses().back().stamp));
  }
  dialog.inform(fmt::format("{} of {} scans can be used and have truth", located.scans.size(),
                            scans.account().received));
  return located;
}

/// What a simulated recording says of its making; none when it was not simulated, cannot be
/// simulated anew, or has errors that a bound does not know, which is no reason not to match.
struct Simulation {
  SimulationRecord record;
  World world;
};

std::optional<Simulation> simulation_of(const MatchPairsRequest& request, const RunDialog& dialog) {
  try {
    const std::optional<SimulationRecord> record = read_simulation_record(request.recording.bags);
    if (!record || !(record->laser.range_noise > 0.0) || record->laser.range_noise_square > 0.0 ||
        record->laser.outliers > 0.0 || record->laser.parts > 1) {
      return std::nullopt;
    }
    return Simulation{*record, world_of(*record)};
  } catch (const ConfigurationError& error) {
    dialog.warn(
        fmt::format("no bound is told, as the bag's simulation is not known: {}", error.what()));
    return std::nullopt;
  }
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

/// What the beams of a scan truly met; none when the scan is not the simulation's.
std::optional<std::vector<BeamTruth>> beams_of(const LocatedScan& located,
                                               const TruthAtScans& truth,
                                               const Simulation& simulation) {
  const LaserOptions& laser = simulation.record.laser;
  const PoseAtTime world_from_base = [&](double stamp) {
    return truth.at(stamp).value_or(located.world_from_base);
  };
  std::vector<BeamTruth> beams =
      trace_beams(simulation.world, laser, world_from_base, located.scan.stamp);
  return is_scan_of(beams, located, laser.range_noise) ? std::optional(std::move(beams))
                                                       : std::nullopt;
}

/// Empty when the scans are not the simulation's.
PairInformation information_of(const std::vector<LocatedScan>& scans,
                               const std::vector<ScanPair>& pairs, const TruthAtScans& truth,
                               const Simulation& simulation, const RunDialog& dialog) {
  const double noise = simulation.record.laser.range_noise;
  PairInformation information;
  for (const ScanPair& pair : pairs) {
    const LocatedScan& reference = scans[pair.reference];
    const LocatedScan& located = scans[pair.scan];
    const auto reference_beams = beams_of(reference, truth, simulation);
    const auto beams = beams_of(located, truth, simulation);
    if (!reference_beams || !beams) {
      dialog.warn("no bound is told, as the scans are not those of the world that the bag names");
      return {};
    }
    information.known_world.push_back(
        fisher_information(*beams, located.scan, located.world_from_base, noise));
    information.unknown_walls.push_back(fisher_information_of_pair(
        *reference_beams, reference.scan, *beams, located.scan, located.world_from_base, noise));
  }
  return information;
}

/// Tells what the pairs are like.
void describe_pairs(const std::vector<LocatedScan>& scans, const std::vector<ScanPair>& pairs,
                    const EngineOptions& options, PairFacts& facts) {
  std::vector<double> gaps;
  std::vector<double> beams;
  std::vector<double> reaches;
  for (const ScanPair& pair : pairs) {
    const LocatedScan& located = scans[pair.scan];
    gaps.push_back(located.scan.stamp - scans[pair.reference].scan.stamp);
    beams.push_back(static_cast<double>(located.scan.ranges.size()));
    const PointScan projected = project_scan(located.scan, located.base_from_laser, located.motion,
                                             options.scan, located.laser_motion);
    reaches.push_back(hough_points(projected.points, 0.0).reach);
  }
  facts.gap_seconds = quantile(gaps, 0.5);
  facts.beams = static_cast<std::size_t>(quantile(beams, 0.5));
  facts.reach = quantile(reaches, 0.5);
}

/// What the Hough matcher sees of the first pairs, one picture each.
void draw_pairs_for_debugging(const std::vector<LocatedScan>& scans,
                              const std::vector<ScanPair>& pairs, const SlamSetup& setup,
                              const std::string& folder) {
  const auto project = [&](const LocatedScan& located) {
    return project_scan(located.scan, located.base_from_laser, located.motion, setup.engine.scan,
                        located.laser_motion);
  };
  std::vector<FileContents> files;
  for (std::size_t i = 0; i < std::min(kMostHoughPictures, pairs.size()); ++i) {
    files.push_back(hough_picture_file(folder, i, project(scans[pairs[i].reference]),
                                       project(scans[pairs[i].scan]), setup.hough.alignment));
  }
  replace_files(files);
}

std::vector<std::vector<PairMatch>> match_all(const LocatedScans& located,
                                              const std::vector<ScanPair>& pairs,
                                              const std::vector<SlamSetup>& setups, int threads,
                                              const RunDialog& dialog) {
  std::vector<std::shared_ptr<const ScanMatcher>> matchers;
  for (const SlamSetup& setup : setups) {
    matchers.push_back(setup.matcher);
  }
  const auto progress = [&](std::size_t done) {
    dialog.show_progress(static_cast<double>(done) / static_cast<double>(pairs.size()),
                         fmt::format("{} pairs", done));
    return !dialog.is_interrupted();
  };
  return match_pairs(located.scans, pairs, matchers, setups.front().engine, threads, progress);
}

}  // namespace

void match_pairs(const MatchPairsRequest& request, const RunDialog& dialog) {
  const Parameters parameters = gather_parameters(request);
  std::vector<SlamSetup> setups = make_setups(request, parameters);
  const Trajectory truth = read_tum(request.truth);
  if (truth.empty()) {
    throw EvaluationError(request.truth + " holds no poses");
  }
  require_writable_folders(request);
  LocatedScans located = read_recording(request, parameters, truth, setups, dialog);
  const std::optional<Simulation> simulation = simulation_of(request, dialog);
  const int seed = setups.front().run.seed;
  std::vector<ScanPair> pairs = draw_pairs(
      located.scans, request.pairs, setups.front().engine.motion, static_cast<std::uint64_t>(seed));
  describe_pairs(located.scans, pairs, setups.front().engine, located.facts);
  if (!request.debug.empty()) {
    draw_pairs_for_debugging(located.scans, pairs, setups.front(), request.debug);
  }
  std::vector<std::vector<PairMatch>> matches =
      match_all(located, pairs, setups, request.threads, dialog);

  pairs.resize(matches.front().size());  // fewer when interrupted

  PairInformation information;
  if (simulation) {
    const TruthAtScans at_scans(truth, located.facts.bag.scan_time_offset);
    information = information_of(located.scans, pairs, at_scans, *simulation, dialog);
  }
  PairTask task{located.facts, request.pairs, SuccessLimits{}, seed, request.threads};
  task.options.pairs = static_cast<int>(pairs.size());
  std::vector<MatcherOnPairs> results;
  for (std::size_t m = 0; m < setups.size(); ++m) {
    const PairStatistics statistics = summarize_pairs(pairs, matches[m], information, task.limits);
    results.push_back({matcher_short_name(setups[m].matcher_name), describe_setup(setups[m]),
                       std::move(matches[m]), statistics});
  }
  const std::string table = pairs_markdown(task, results);
  replace_files({{request.out + "/pairs.csv", pairs_csv(located.scans, pairs, results)},
                 {request.out + "/summary.json", pairs_json(task, results)},
                 {request.out + "/summary.md", table}});
  dialog.inform(fmt::format("\n{}\nresults in {}", table, request.out));
  if (task.options.pairs < request.pairs.pairs) {
    throw std::runtime_error(fmt::format("interrupted; the results cover {} of {} pairs",
                                         task.options.pairs, request.pairs.pairs));
  }
}

}  // namespace matchbox_slam
