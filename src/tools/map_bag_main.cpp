// rosrun matchbox_slam map_bag: maps a bag without a roscore.

#include <fmt/core.h>
#include <malloc.h>

#include <CLI/CLI.hpp>
#include <set>
#include <string>

#include "bag/bag_conversion.hpp"
#include "run/run_options.hpp"
#include "tools/bag_flags.hpp"
#include "tools/bag_mapper.hpp"
#include "tools/run_program.hpp"
#include "tools/terminal.hpp"

namespace {

using namespace matchbox_slam;

void declare_options(CLI::App& app, MapBagRequest& request) {
  add_recording_flags(
      app, request,
      fmt::format("Of the random numbers (default: as configured, else {})", RunOptions{}.seed),
      "Folder for pictures of the first 20 key scans' Hough domains, spectra and "
      "correlation, each with its predecessor's");
  CLI::Option* map =
      app.add_option(
             "--map", request.map,
             "Map to go on with: a map.slam of map_bag or of ~save_map, or the .yaml of an image")
          ->type_name("FILE");
  app.add_flag("--overwrite", request.overwrite,
               "Write over that map, where --out is the folder that it is in")
      ->needs(map);
  app.add_option("--pose", request.pose,
                 "Where the robot is in that map at the first scan [m, rad], to 0.3 m and 0.2 rad; "
                 "else it is where start_x, start_y and start_theta are set to, or is searched for")
      ->type_name("X,Y,THETA")
      ->needs(map);
  app.add_option(
         "--matcher", request.matcher,
         fmt::format("Scan matcher (default: as configured, else {})", RunOptions{}.matcher))
      ->type_name("NAME");
  app.add_option("--events", request.events,
                 "YAML with what happens between scans: poses told, resets, pauses, changes of "
                 "options; the node writes such a file as events_file")
      ->type_name("FILE");
  app.add_option(
         "--movie", request.movie,
         "Movie of the map as it grows: a GIF, or a folder for its frames as PNGs, which is "
         "made if need be, and where those of a longer movie before are removed; see "
         "doc/first_map.md")
      ->type_name("OUT.gif|DIR");
  app.get_option("--out")->required(false)->description(
      "Folder for the results; made if need be; to be given unless --convert is");
  app.add_option(
         "--convert", request.convert,
         "Map nothing, but write what is read as a bag of ROS 1: the scans of --scan-topic, "
         "else of all topics, tf, odometry and IMU; without --out and what is for maps")
      ->type_name("OUT.bag");
  add_number<int>(app, "--threads", request.recording.threads, between(1, 1024),
                  "From 2 on, the bag is read by a thread of its own");
}

/// Whether to convert. Throws ConfigurationError where that, or what is given with it, makes no
/// sense.
bool is_conversion(const CLI::App& app) {
  if (app.count("--convert") == 0) {
    if (app.count("--out") == 0) {
      throw ConfigurationError(
          "give a folder for the map with --out, or a bag to write with --convert; see --help");
    }
    return false;
  }
  static const std::set<std::string> kAllowedOptions = {
      "BAG", "--convert", "--scan-topic", "--start", "--duration", "--threads", "--quiet"};
  for (const CLI::Option* option : app.get_options()) {
    if (option->count() > 0 && kAllowedOptions.count(option->get_name()) == 0) {
      throw ConfigurationError(
          fmt::format("--convert: {} is for maps, and none is made; leave one of them out",
                      option->get_name()));
    }
  }
  return true;
}

void convert(const MapBagRequest& request, const RunDialog& dialog) {
  const ConvertedBag converted = convert_bag(request.recording, request.convert, dialog);
  dialog.inform(fmt::format("{}: {} scans, {} messages of tf and {} of odometry and IMU",
                            request.convert, converted.scans, converted.transforms,
                            converted.others));
  if (!converted.damage.empty()) {
    throw BagError(converted.damage + "; the bag holds the part before");
  }
}

void set_up_malloc() {
  constexpr int kMegabyte = 1 << 20;
  // The mapping and what works beside it pass maps to each other: with an arena for each thread
  // both would keep what the other has freed.
  mallopt(M_ARENA_MAX, 1);
  // What is freed is asked for again with the next scan, and pages that the system hands out anew
  // take a scan in a hundred 0.3 ms (campus of 3 km, 1040 beams, p99 1.9 in place of 1.55 ms).
  mallopt(M_MMAP_THRESHOLD, 4 * kMegabyte);
  mallopt(M_TRIM_THRESHOLD, 64 * kMegabyte);
}

}  // namespace

int main(int argc, char** argv) {
  set_up_malloc();
  const InterruptGuard interrupt;
  MapBagRequest request;
  const CLI::App* given = nullptr;
  return run_program(
      "map_bag", "Maps the laser scans of a recording and writes map, trajectory and a report.",
      [&](CLI::App& app) {
        declare_options(app, request);
        given = &app;
      },
      argc, argv,
      [&] {
        request.recording.is_repetition = !request.events.empty();
        const bool converts = is_conversion(*given);
        Terminal terminal(request.quiet);
        if (converts) {
          convert(request, dialog_on(terminal, interrupt));
        } else {
          map_bag(request, dialog_on(terminal, interrupt));
        }
      });
}
