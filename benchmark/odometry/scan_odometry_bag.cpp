// rosrun matchbox_slam scan_odometry_bag BAG --out DIR: laser odometry over a bag without a
// roscore, by the queue and the class that ScanMatcherNode uses. Writes scan_odometry.tum,
// odometry.tum (of the bag) and report.json.

#include <CLI/CLI.hpp>
#include <ctime>
#include <nlohmann/json.hpp>

#include "bag/bag_scans.hpp"
#include "evaluation/error_statistics.hpp"
#include "io/tum.hpp"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/yaml_parameters.hpp"
#include "node/scan_matcher_diagnostics.hpp"
#include "ros/matcher_loader.hpp"
#include "run/scan_matcher_setup.hpp"
#include "tools/bag_flags.hpp"
#include "tools/json_text.hpp"
#include "tools/run_program.hpp"
#include "tools/run_report.hpp"
#include "tools/terminal.hpp"

namespace {

using namespace matchbox_slam;

struct Request {
  BagRequest recording;
  std::string out;
  std::vector<std::string> config_files;
  std::vector<std::string> overrides;
};

void declare_options(CLI::App& app, Request& request) {
  app.add_option("BAG", request.recording.bags, "Bag files of one recording")->required();
  app.add_option("--out", request.out, "Folder for the results")->required()->type_name("DIR");
  add_repeated(app, "--config", request.config_files, "YAML with parameters", "FILE");
  add_repeated(app, "--set", request.overrides, "A parameter of the node, such as matcher=hough",
               "KEY=VALUE");
  add_bag_flags(app, request.recording);
}

/// What the run yielded.
struct Record {
  std::vector<StampedPose2> estimate;
  std::vector<StampedPose2> odometry;  ///< of the bag
  MatchRecord matches;
  std::vector<float> scan_seconds;
  std::size_t most_bytes = 0;  ///< of the local maps
  Eigen::Vector3d last_sigma = Eigen::Vector3d::Zero();
};

void process(const ScanInput& input, LaserOdometry& odometry, Record& record) {
  const std::clock_t begin = std::clock();  // of this one thread, whatever else the machine does
  const LaserOdometryOutcome outcome = odometry.process(input);
  record.scan_seconds.push_back(static_cast<float>(std::clock() - begin) / CLOCKS_PER_SEC);
  record.matches.add(outcome, 0.0);
  record.estimate.push_back({outcome.stamp, outcome.odom_from_base});
  if (input.odometry) {
    record.odometry.push_back({outcome.stamp, input.odometry->odom_from_base});
  }
  if (outcome.is_key_scan) {
    record.most_bytes = std::max(record.most_bytes, odometry.bytes());
  }
  record.last_sigma = outcome.covariance.diagonal().cwiseSqrt();
}

nlohmann::json report_of(const Record& record, const ScanAccount& account) {
  nlohmann::json statuses;
  for (const auto& [status, count] : record.matches.statuses()) {
    statuses[to_string(status)] = count;
  }
  const ErrorStatistics scan = statistics_of(record.scan_seconds);
  return nlohmann::json::object(
      {{"scans", {{"received", account.received}, {"used", account.delivered}}},
       {"matches", statuses},
       {"unconstrained", record.matches.unconstrained()},
       {"key_scans", record.matches.key_scans()},
       {"restarts", record.matches.restarts()},
       {"local_maps_mb", static_cast<double>(record.most_bytes) / (1024.0 * 1024.0)},
       {"scan_ms", {{"p50", 1e3 * scan.median}, {"p95", 1e3 * scan.p95}, {"max", 1e3 * scan.max}}},
       {"last_sigma", {record.last_sigma.x(), record.last_sigma.y(), record.last_sigma.z()}}});
}

void run(const Request& request, const RunDialog& dialog) {
  const MatcherLoader loader;
  Parameters parameters = read_yaml_parameters(request.config_files);
  parameters.merge(parse_overrides(request.overrides));
  // The guess's frame is found in the bag; the node has to be told.
  const ParameterValue* guess = parameters.find("guess");
  if (guess != nullptr && *guess == ParameterValue(std::string("odometry"))) {
    parameters.set("guess_frame", "found in the bag");
  }
  const ScanMatcherSetup setup = make_scan_matcher_setup(parameters, loader);
  require_writable_folder(request.out);
  BagScans scans(request.recording, dialog);
  const Parameters frames = frame_parameters(request.recording);
  auto options = read_options<RunOptions>(frames, "");
  options.scan_time_offset = to_string(setup.node.scan_time_offset);
  options = scans.prepare(frames, options);

  LaserOdometry odometry(setup.odometry, setup.matcher, setup.guess,
                         static_cast<std::uint64_t>(setup.node.seed));
  Record record;
  while (const std::optional<ScanQueue::Item> item = scans.next()) {
    if (const auto* scan = std::get_if<ReadyScan>(&*item)) {
      process(scan->input, odometry, record);
    } else {
      throw BagError("time jumps back in the bag; give --start and --duration around that");
    }
  }
  if (record.estimate.empty()) {
    scans.throw_nothing_used();
  }
  write_tum(request.out + "/scan_odometry.tum", Trajectory(record.estimate));
  write_tum(request.out + "/odometry.tum", Trajectory(record.odometry));
  replace_file(request.out + "/report.json", json_text(report_of(record, scans.account())) + "\n");
}

}  // namespace

int main(int argc, char** argv) {
  const InterruptGuard interrupt;
  Request request;
  return run_program(
      "scan_odometry_bag", "Laser odometry over a bag.",
      [&](CLI::App& app) { declare_options(app, request); }, argc, argv,
      [&] {
        Terminal terminal(true);
        run(request, dialog_on(terminal, interrupt));
      });
}
