// rosrun matchbox_slam match_pairs: measures scan matching alone, on pairs of scans.

#include <CLI/CLI.hpp>

#include "tools/bag_flags.hpp"
#include "tools/option_flags.hpp"
#include "tools/pair_matching.hpp"
#include "tools/run_program.hpp"
#include "tools/terminal.hpp"

namespace {

using namespace matchbox_slam;

void declare_options(CLI::App& app, MatchPairsRequest& request, Parameters& pairs) {
  add_recording_flags(
      app, request, "Of pairs, guesses and matchers (default 1)",
      "Folder for pictures of the first 20 pairs' Hough domains, spectra and correlation");
  app.add_option("--truth", request.truth, "True trajectory of the base, in the TUM format")
      ->required()
      ->type_name("FILE");
  add_repeated(app, "--matcher", request.matchers,
               "Scan matcher, such as olson; default: the configured one", "NAME");
  add_option_flags<PairOptions>(app, "Pairs", pairs);
  add_number<int>(app, "--threads", request.threads, between(1, 1024),
                  "Pairs that are matched at the same time");
}

}  // namespace

int main(int argc, char** argv) {
  const InterruptGuard interrupt;
  MatchPairsRequest request;
  Parameters pairs;
  return run_program(
      "match_pairs",
      "Matches pairs of scans whose true motion is known, from a guess that is wrong by a known "
      "amount, and tells error, success, time and the honesty of the covariances.",
      [&](CLI::App& app) { declare_options(app, request, pairs); }, argc, argv,
      [&] {
        request.pairs = read_options<PairOptions>(pairs, "");
        Terminal terminal(request.quiet);
        match_pairs(request, dialog_on(terminal, interrupt));
      });
}
