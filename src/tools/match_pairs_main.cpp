// rosrun matchbox_slam match_pairs: measures scan matching alone, on pairs of scans.

#include <CLI/CLI.hpp>

#include "tools/bag_flags.hpp"
#include "tools/option_flags.hpp"
#include "tools/pair_matching.hpp"
#include "tools/run_program.hpp"
#include "tools/terminal.hpp"

namespace {

using namespace matchbox_slam;

void declare_options(CLI::App& app, MatchPairsRequest& request, Parameters& pairs, bool& quiet) {
  app.add_option("BAG", request.recording.bags, "Bag files of one recording")->required();
  app.add_option("--truth", request.truth, "True trajectory of the base, in the TUM format")
      ->required()
      ->type_name("FILE");
  app.add_option("--out", request.out, "Folder for the results; made if need be")
      ->required()
      ->type_name("DIR");
  add_repeated(app, "--matcher", request.matchers,
               "Scan matcher, such as olson; default: the configured one", "NAME");
  add_option_flags<PairOptions>(app, "Pairs", pairs);
  add_optional(app, "--seed", request.seed, "Of pairs, guesses and matchers (default 1)", "N")
      ->check(CLI::Range(0, 2147483647));
  app.add_option("--threads", request.threads,
                 "Pairs that are matched at the same time (default 1)")
      ->check(CLI::Range(1, 1024))
      ->type_name("N");
  app.add_option(
         "--debug", request.debug,
         "Folder for pictures of the first 20 pairs' Hough domains, spectra and correlation")
      ->type_name("DIR");
  add_repeated(app, "--config", request.config_files, "YAML with parameters", "FILE");
  add_repeated(app, "--set", request.overrides, "A parameter", "KEY=VALUE");
  add_bag_flags(app, request.recording);
  app.add_flag("--quiet", quiet, "Only warnings and errors");
}

}  // namespace

int main(int argc, char** argv) {
  const InterruptGuard interrupt;
  MatchPairsRequest request;
  Parameters pairs;
  bool quiet = false;
  return run_program(
      "match_pairs",
      "Matches pairs of scans whose true motion is known, from a guess that is wrong by a known "
      "amount, and tells error, success, time and the honesty of the covariances.",
      [&](CLI::App& app) { declare_options(app, request, pairs, quiet); }, argc, argv,
      [&] {
        request.pairs = read_options<PairOptions>(pairs, "");
        Terminal terminal(quiet);
        match_pairs(request, dialog_on(terminal, interrupt));
      });
}
