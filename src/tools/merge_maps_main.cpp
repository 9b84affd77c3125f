// rosrun matchbox_slam merge_maps: makes one map of several saved ones.

#include <CLI/CLI.hpp>

#include "tools/bag_flags.hpp"
#include "tools/map_merger.hpp"
#include "tools/run_program.hpp"
#include "tools/terminal.hpp"

namespace {

using namespace matchbox_slam;

void declare_options(CLI::App& app, MergeMapsRequest& request) {
  app.add_option("MAP", request.maps,
                 "Saved maps, two or more: map.slam of map_bag or of ~save_map. What is made of "
                 "them is in the frame of the first one")
      ->required();
  app.add_option("--out", request.out, "Folder for the results; made if need be")
      ->required()
      ->type_name("DIR");
  app.add_flag("--overwrite", request.overwrite,
               "Write over one of the maps, where --out is the folder that it is in");
  add_repeated(app, "--config", request.config_files, "YAML with parameters", "FILE");
  add_repeated(app, "--set", request.overrides, "A parameter", "KEY=VALUE");
  app.add_flag("--quiet", request.quiet, "Only warnings and errors");
}

}  // namespace

int main(int argc, char** argv) {
  const InterruptGuard interrupt;
  MergeMapsRequest request;
  return run_program(
      "merge_maps", "Makes one map of the saved maps of several drives or robots, where they meet.",
      [&](CLI::App& app) { declare_options(app, request); }, argc, argv,
      [&] {
        Terminal terminal(request.quiet);
        merge_maps(request, dialog_on(terminal, interrupt));
      });
}
