#include "tools/run_report.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "evaluation/error_statistics.hpp"
#include "tools/json_text.hpp"
#include "tools/provenance.hpp"

namespace matchbox_slam {

namespace {

using nlohmann::json;

/// To the microsecond; what is beyond is not measured.
double rounded(double value) { return std::round(value * 1e6) / 1e6; }

json milliseconds(const std::vector<float>& seconds) {
  const ErrorStatistics durations = statistics_of(seconds);
  return json::object({{"p50", rounded(1e3 * durations.median)},
                       {"p95", rounded(1e3 * durations.p95)},
                       {"p99", rounded(1e3 * durations.p99)},
                       {"max", rounded(1e3 * durations.max)}});
}

json scan_counts(const ScanAccount& account, const SlamRun& run) {
  json skipped = json::object();
  for (const auto& [reason, count] : account.skipped) {
    skipped[to_string(reason)] = count;
  }
  json matches = json::object();
  for (const auto& [status, count] : run.statuses()) {
    matches[status] = count;
  }
  json certainties = json::object();
  for (const auto& [certainty, count] : run.certainties()) {
    certainties[to_string(certainty)] = count;
  }
  json states = json::object();
  for (const auto& [state, count] : run.states()) {
    states[to_string(state)] = count;
  }
  const ErrorStatistics evidence = statistics_of(run.evidences());
  return json::object({{"received", account.received},
                       {"used", account.delivered},
                       {"skipped_total", account.skipped_total()},
                       {"skipped", skipped},
                       {"inserted", run.inserted()},
                       {"left_out", run.left_out()},
                       {"matches", matches},
                       {"certainty", certainties},
                       {"state", states},
                       {"maps_apart", run.disconnected_components()},
                       {"maps_apart_given_up", run.components_given_up()},
                       {"evidence", json::object({{"p50", rounded(evidence.median)},
                                                  {"p95", rounded(evidence.p95)},
                                                  {"max", rounded(evidence.max)}})}});
}

json frames(const RunOptions& options) {
  return json::object({{"base", options.base_frame},
                       {"odom", options.use_odometry ? json(options.odom_frame) : json(nullptr)},
                       {"map", options.map_frame}});
}

json map_facts(const SlamMap& map) {
  const CellBox box = map.occupancy.known_bounds();
  const auto bytes = static_cast<double>(map.occupancy.bytes() + map.field.bytes());
  return json::object({{"width", box.empty() ? 0 : box.width()},
                       {"height", box.empty() ? 0 : box.height()},
                       {"resolution", map.occupancy.geometry().resolution()},
                       {"memory_mb", rounded(bytes / (1024.0 * 1024.0))}});
}

/// Those beside the first.
json laser_facts(const SlamRun& run) {
  json lasers = json::array();
  for (const auto& [number, laser] : run.secondary_lasers()) {
    const LaserPlace place = place_of(laser);
    const Pose2& pose = place.base_from_laser;
    lasers.push_back({{"topic", run.scan_topic(number)},
                      {"used", laser.is_used},
                      {"contradictory", use_of(laser) == LaserUse::kContradictory},
                      {"matches", laser.mount.samples().size()},
                      {"agreeing", laser.mount.agreeing()},
                      {"x_m", rounded(pose.x)},
                      {"y_m", rounded(pose.y)},
                      {"yaw_rad", rounded(pose.theta)},
                      {"sigma_x_m", rounded(place.sigma.x())},
                      {"sigma_y_m", rounded(place.sigma.y())},
                      {"sigma_yaw_rad", rounded(place.sigma.z())},
                      {"from_tf_m", rounded(place.from_tf)},
                      {"from_tf_rad", rounded(place.turned)},
                      {"delay_s", rounded(place.delay)},
                      {"sigma_delay_s", rounded(place.delay_sigma)}});
  }
  return lasers;
}

/// Those of this run: that were found and can be, and how many that cannot; and how many more the
/// map brought that it went on with.
json loop_facts(const SlamRun& run) {
  const PlacedScans& keys = run.key_scans().all();
  const std::vector<ClosedLoop>& loops = run.loop_state().loops;
  const LoopCount count = run.new_loops();
  json closed = json::array();
  std::for_each(loops.end() - static_cast<std::ptrdiff_t>(count.found), loops.end(),
                [&](const ClosedLoop& loop) {
                  if (loop.is_inlier) {
                    closed.push_back({{"stamp", keys[loop.newest].scan->stamp()},
                                      {"stamp_there", keys[loop.found.key].scan->stamp()},
                                      {"score", rounded(loop.found.score)},
                                      {"rival_share", rounded(loop.found.rival_share)},
                                      {"log_odds", rounded(loop.found.log_odds)},
                                      {"chi_square", rounded(loop.chi_square)},
                                      {"moved_m", rounded(loop.moved)}});
                  }
                });
  return json::object({{"tried", count.tries},
                       {"closed", count.closed},
                       {"refused", count.found - count.closed},
                       {"closed_before", run.brought_loops().closed},
                       {"each", closed}});
}

void add_cost(const RunFacts& facts, const SlamRun& run, json& report) {
  const double wall = facts.used.wall_seconds;
  report["match_ms"] = milliseconds(run.match_seconds());
  std::vector<float> all;
  json by_state = json::object();
  for (const auto& [state, seconds] : run.scan_seconds()) {
    all.insert(all.end(), seconds.begin(), seconds.end());
    by_state[to_string(state)] = milliseconds(seconds);
  }
  report["scan_ms"] = milliseconds(all);
  report["scan_ms"]["by_state"] = by_state;
  report["bag_s"] = rounded(facts.bag.seconds);
  report["wall_s"] = rounded(wall);
  report["cpu_s"] = rounded(facts.used.cpu_seconds);
  report["real_time_factor"] = wall > 0.0 ? rounded(facts.bag.seconds / wall) : 0.0;
  report["peak_rss_mb"] = rounded(facts.used.peak_memory);
}

/// What was unusual about the bag and the run.
void add_incidents(const RunFacts& facts, json& report) {
  report["scan_time_offset_s"] = facts.bag.scan_time_offset;
  report["estimated_clock_offset_s"] = facts.bag.estimated_clock_offset
                                           ? json(rounded(*facts.bag.estimated_clock_offset))
                                           : json(nullptr);
  report["ignored_map_link"] =
      facts.bag.ignored_map_link.empty() ? json(nullptr) : json(facts.bag.ignored_map_link);
  report["invalid_transforms"] = facts.bag.invalid_transforms;
  report["invalid_odometry"] = facts.bag.invalid_odometry;
  report["resets"] = facts.resets;
  report["interrupted"] = facts.bag.interrupted;
  report["damage"] = facts.bag.damage.empty() ? json(nullptr) : json(facts.bag.damage);
}

}  // namespace

std::string to_json(const RunFacts& facts, const ScanAccount& account, const SlamRun& run) {
  const SlamSetup& setup = run.setup();
  json report = json::object();
  add_provenance(report);
  report["bags"] = facts.bag.bags;
  report["scan_topic"] = join(facts.bag.scan_topics);
  report["frames"] = frames(setup.run);
  report["matcher"] = setup.matcher_name;
  report["seed"] = setup.run.seed;
  report["threads"] = facts.bag.threads;
  report["scans"] = scan_counts(account, run);
  add_cost(facts, run, report);
  report["map"] = map_facts(run.drawn_map());
  report["loops"] = loop_facts(run);
  report["further_lasers"] = laser_facts(run);
  add_incidents(facts, report);
  report["clock_steps"] = run.clock_steps();
  report["configuration"] = values_of(describe_setup(setup));
  return json_text(report) + "\n";
}

}  // namespace matchbox_slam
