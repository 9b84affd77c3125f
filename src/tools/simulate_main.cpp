// rosrun matchbox_slam simulate: drives a simulated robot through a simulated world and records a
// bag.

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bag/simulated_bag.hpp"
#include "geometry/trajectory.hpp"
#include "io/tum.hpp"
#include "matchbox_slam/io/file.hpp"
#include "simulation/make_world.hpp"
#include "simulation/presets.hpp"
#include "simulation/simulated_run.hpp"
#include "tools/bag_flags.hpp"
#include "tools/option_flags.hpp"
#include "tools/run_program.hpp"
#include "tools/terminal.hpp"

namespace {

using namespace matchbox_slam;

/// The command line as it was given.
struct Request {
  std::string world;
  int seed = 1;
  std::optional<int> noise_seed;
  std::string bag;
  std::string truth;
  bool inverted_laser = false;
  std::vector<double> second_laser;
  std::vector<double> second_laser_error;
  std::string sensor = "utm30";
  std::string odometry_kind = "good";
  Parameters laser;
  Parameters drive;
  Parameters odometry;
  Parameters time;
  Parameters changes;
  Parameters recording;
  std::vector<std::string> faults;
};

void declare_options(CLI::App& app, Request& request) {
  app.add_option("--world", request.world, one_of(world_names()).text())
      ->required()
      ->type_name("NAME");
  add_number<int>(app, "--seed", request.seed, at_least(0.0),
                  "Of world and noise; the same seed gives the same bag");
  add_number<int>(app, "--noise-seed", request.noise_seed, at_least(0.0),
                  "Of the noise alone, and of faults: another drive through the same world");
  app.add_option("--bag", request.bag, "Bag to write")->required()->type_name("OUT.bag");
  app.add_option(
         "--truth", request.truth,
         "True trajectory to write: pose of the base in the world at the stamp of each scan")
      ->required()
      ->type_name("OUT.tum");
  app.add_option("--sensor", request.sensor,
                 "Which options of the laser are set; any may be given besides: " +
                     preset_help(sensor_presets()))
      ->type_name("NAME");
  app.add_option("--odometry", request.odometry_kind,
                 "Likewise of the odometry: " + preset_help(odometry_presets()))
      ->type_name("NAME");
  app.add_flag("--inverted-laser", request.inverted_laser,
               "The laser hangs upside down; the same as --mount-roll 3.14159...");
  CLI::Option* second =
      app.add_option("--second-laser", request.second_laser,
                     "Another laser of the same kind, on /second_scan: where it is on the base [m, "
                     "m, rad], such as -0.3,0,3.14")
          ->type_name("X,Y,YAW")
          ->delimiter(',')
          ->expected(3);
  app.add_option("--second-laser-error", request.second_laser_error,
                 "By how much tf has it elsewhere [m, m, rad]")
      ->type_name("X,Y,YAW")
      ->delimiter(',')
      ->expected(3)
      ->needs(second);
  add_option_flags<LaserOptions>(app, "Laser", request.laser);
  add_option_flags<DriveOptions>(app, "Path", request.drive);
  add_option_flags<OdometryOptions>(app, "Odometry", request.odometry);
  add_option_flags<RunTimeOptions>(app, "Time", request.time);
  add_option_flags<WorldChangeOptions>(app, "Changes of the world", request.changes);
  add_option_flags<SimulatedBagOptions>(app, "Recording", request.recording);
  app.add_option(
         "--fault", request.faults,
         "What goes wrong, KIND:TIME:DURATION:AMOUNT, such as freeze:20:1.5; TIME in seconds "
         "from the start on, or 'random'; may be given again. " +
             fault_help())
      ->type_name("FAULT")
      ->group("Faults");
}

/// The preset's values, but for those that are given.
Parameters preset_and_given(const std::vector<Preset>& presets, const std::string& flag,
                            const std::string& name, const Parameters& given) {
  Parameters all = preset_named(presets, flag, name).values;
  all.merge(given);
  return all;
}

SimulationOptions read_simulation_options(Request request) {
  request.laser = preset_and_given(sensor_presets(), "--sensor", request.sensor, request.laser);
  request.odometry =
      preset_and_given(odometry_presets(), "--odometry", request.odometry_kind, request.odometry);
  if (request.inverted_laser) {
    if (request.laser.find("mount_roll") != nullptr) {
      throw ConfigurationError("--inverted-laser and --mount-roll exclude each other");
    }
    request.laser.set("mount_roll", kPi);
  }
  SimulationOptions options;
  options.laser = read_options<LaserOptions>(request.laser, "");
  options.drive = read_options<DriveOptions>(request.drive, "");
  options.odometry = read_options<OdometryOptions>(request.odometry, "");
  options.time = read_options<RunTimeOptions>(request.time, "");
  check_laser_options(options.laser);
  if (!request.second_laser.empty()) {
    const std::vector<double>& at = request.second_laser;
    std::vector<double> error = request.second_laser_error;
    error.resize(3, 0.0);
    options.second_laser =
        SecondLaserOptions{{at[0], at[1], wrap_angle(at[2])},
                           {at[0] + error[0], at[1] + error[1], wrap_angle(at[2] + error[2])}};
  }
  for (const std::string& text : request.faults) {
    options.faults.push_back(parse_fault(text));
  }
  return options;
}

/// Throws FileError unless a file can be written there.
void require_writable_file(const std::string& path) {
  if (std::filesystem::is_directory(path)) {
    throw FileError(path + ": cannot be written: there is a folder of that name");
  }
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  require_writable_folder(folder.empty() ? "." : folder.string());
}

void require_two_files(const std::string& bag, const std::string& truth) {
  if (std::filesystem::weakly_canonical(bag) == std::filesystem::weakly_canonical(truth)) {
    throw ConfigurationError(fmt::format(
        "--bag and --truth name the same file, '{}'; allowed: two different files", bag));
  }
}

WorldChangeOptions read_changes(const Parameters& parameters) {
  const auto changes = read_options<WorldChangeOptions>(parameters, "");
  if (changes.moved + changes.taken > 1.0) {
    throw ConfigurationError(
        fmt::format("--moved {} and --taken {} are shares of the same things; allowed: 1 together",
                    changes.moved, changes.taken));
  }
  return changes;
}

/// By the clock of the laser, as all that is derived from scans is.
Trajectory truth_of(const SimulatedRun& run, double clock_offset) {
  std::vector<StampedPose2> poses;
  for (std::size_t i = 0; i < run.scans.size(); ++i) {
    poses.push_back({run.scans[i].stamp - clock_offset, run.world_from_base[i]});
  }
  return Trajectory(std::move(poses));
}

void simulate(const Request& request, const InterruptGuard& interrupt) {
  require_two_files(request.bag, request.truth);
  const SimulationOptions options = read_simulation_options(request);
  auto recording = read_options<SimulatedBagOptions>(request.recording, "");
  recording.no_odometry = recording.no_odometry || request.odometry_kind == kNoOdometry;
  const auto seed = static_cast<std::uint64_t>(request.seed);
  const auto noise_seed = static_cast<std::uint64_t>(request.noise_seed.value_or(request.seed));
  const WorldChangeOptions changes = read_changes(request.changes);
  const World before = make_world(request.world, seed);
  const auto [world, moved, taken, built] = changed(before, changes);
  require_writable_file(request.truth);
  require_writable_file(request.bag);
  const auto is_interrupted = [&] { return interrupt.is_interrupted(); };
  SimulatedBagWriter bag(request.bag, recording);
  const SimulatedRun run = simulate_run(world, world.route(), options, noise_seed, is_interrupted);
  bag.write(run, {request.world, seed, options.laser, run.faults, changes}, is_interrupted);
  write_tum(request.truth, truth_of(run, recording.clock_offset));
  std::cout << request.bag << ": " << run.scans.size() << " scans in "
            << run.scans.back().stamp - run.scans.front().stamp << " s\n"
            << request.truth << ": the truth\n";
  if (changes.any()) {
    std::cout << "changed: " << moved << " of " << before.things().size() << " things moved, "
              << taken << " taken, " << built << " walls built\n";
  }
  std::cout.flush();
}

}  // namespace

int main(int argc, char** argv) {
  const InterruptGuard interrupt;
  Request request;
  return matchbox_slam::run_program(
      "simulate",
      "Drives a simulated robot through a simulated world and records a bag like those of the MIT "
      "Stata Center, and the truth.",
      [&](CLI::App& app) { declare_options(app, request); }, argc, argv,
      [&] { simulate(request, interrupt); });
}
