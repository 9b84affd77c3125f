#include <CLI/CLI.hpp>

#include "evaluate_ate.hpp"
#include "run_program.hpp"

int main(int argc, char** argv) {
  CLI::App app("Measures the accuracy of trajectories, of this package or of any other.",
               "evaluate");
  app.require_subcommand(1);
  matchbox_slam::add_ate_command(app);
  return matchbox_slam::run_program(app, argc, argv, [] {});
}
