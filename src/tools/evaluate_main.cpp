#include <CLI/CLI.hpp>

#include "tools/evaluate_ate.hpp"
#include "tools/evaluate_map.hpp"
#include "tools/evaluate_relations.hpp"
#include "tools/evaluate_rpe.hpp"
#include "tools/run_program.hpp"

namespace {

void declare_options(CLI::App& app) {
  app.require_subcommand(1);
  matchbox_slam::add_ate_command(app);
  matchbox_slam::add_rpe_command(app);
  matchbox_slam::add_relations_command(app);
#ifdef MATCHBOX_MAP_QUALITY  // where OpenCV is installed
  matchbox_slam::add_map_command(app);
#endif
}

}  // namespace

int main(int argc, char** argv) {
  return matchbox_slam::run_program("evaluate",
                                    "Measures the accuracy of trajectories and the quality of "
                                    "maps, of this package or of any other.",
                                    declare_options, argc, argv, [] {});
}
