#pragma once

#include <optional>

#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/map/scan_inserter.hpp"
#include "matchbox_slam/matching/scan_matcher.hpp"

namespace matchbox_slam {

struct DoubtOptions {
  bool enabled = true;
  double contradiction = 0.1;
  double most_contradiction = 0.3;
  double score_drop = 0.8;
  double least_net = 0.1;
  double look_xy = 0.5;
  double look_theta = 1.0;
  double least_score = 0.4;
  double most_rival = 0.9;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor&& option) {
    option(self.enabled, "enabled", any(), "",
           "Whether matches are doubted, looked at again, and the robot may count as lost; false: "
           "every match is believed.");
    option(self.contradiction, "contradiction", between(0.0, 1.0), "",
           "A match is looked at again when more of its beams than this share cross walls of the "
           "map, or when its score is too low; what the second look finds contradicts less.");
    option(
        self.most_contradiction, "most_contradiction", between(0.0, 1.0), "",
        "A match is rejected when more than this share of its beams cross walls, the second look "
        "finds nothing better, and the newest key scans do not say that the map is wrong.");
    option(self.score_drop, "score_drop", between(0.0, 1.0), "",
           "A match is looked at again, too, when it scores less than this share of what is usual "
           "lately, though what it sees is mapped; and after a doubt it confirms no pose.");
    option(self.least_net, "least_net", between(-1.0, 1.0), "",
           "A match is rejected when its score less its contradiction is lower, the second look "
           "finds nothing better, and the newest key scans do not say that the map is wrong.");
    option(self.look_xy, "look_xy", between(0.01, 2.0), "m",
           "Standard deviation of the position that a second look adds to the prior's.");
    option(self.look_theta, "look_theta", between(0.01, 3.2), "rad",
           "Standard deviation of the heading that a second look adds to the prior's.");
    option(self.least_score, "least_score", between(0.0, 1.0), "",
           "What a second look finds is taken from this score on.");
    option(self.most_rival, "most_rival", between(0.0, 1.0), "",
           "What a second look finds is not taken when another place scores more than this share "
           "of it.");
  }
};

/// How much a match is to be believed.
enum class Certainty {
  kSure,        ///< as the first look found it
  kSecondLook,  ///< doubtful at first, and found by a wider look
  kNewGround,   ///< matches nowhere, as what it sees is not mapped yet; the prediction is believed
  kDoubtful,    ///< doubtful, and the wider look found nothing better
};

/// A word for logs and reports, such as "second_look".
[[nodiscard]] const char* to_string(Certainty certainty);

/// A match, and how sure it is.
struct WeighedMatch {
  MatchResult match;
  Certainty certainty = Certainty::kSure;
  /// How well the scan fits what is mapped where it was found, 0...1: the score on the map's field,
  /// whatever the matcher scores against, over the share of the scan that lies on mapped ground.
  /// Known in doubt, and when there was a second look.
  double fit = 0.0;
  bool jumped = false;     ///< found clearly away from the prediction, and not beyond doubt
  bool upheld = false;     ///< doubtful at first, and what a second look found was no better
  bool overruled = false;  ///< what the map contradicts is believed as the newest key scans do not
};

/// What is known before a match: its score is compared with the usual one.
struct Expectation {
  double usual_score = 0.0;  ///< of matches lately; 0: none is known
  bool is_in_doubt = false;
  double contradicted_way = 0.0;  ///< [m] driven since a match that the map does not contradict
};

/// Matches, weighs the answer by its contradiction, and where it is doubtful looks again with a
/// prior that may be wrong: by exact search (Olson 2009), whatever the matcher. A first look
/// that the wider one does not better is believed, unless too much speaks against it. An answer
/// that stays doubtful is rejected, with a covariance that covers that: the wide prior's. Odometry
/// alone, whose score is 0, is believed. Cost: of a match; in doubt of
/// another one over a window of some 1.5 m and 115 degrees, which ends after so many look-ups as
/// take some 10 ms; what is found then does not convince.
[[nodiscard]] WeighedMatch match_and_weigh(const ScanMatcher& matcher, const MatchProblem& problem,
                                           const OccupancyGrid& occupancy,
                                           const Expectation& expected,
                                           const DoubtOptions& options);

/// A match by exact search in the window of the prior, where it convinces and fits what is mapped
/// as well as is usual.
[[nodiscard]] std::optional<WeighedMatch> match_if_convincing(const MatchProblem& problem,
                                                              const OccupancyGrid& occupancy,
                                                              const Expectation& expected,
                                                              const DoubtOptions& options);

/// Whether a pose is so far from where the prediction has the robot that it would have jumped.
[[nodiscard]] bool is_jump(const Pose2& found, const Pose2& predicted);

/// Whether a pose is turned so far from the prediction, well below a quarter of a turn, that
/// another arm of a crossing of corridors may have been taken for the right one.
[[nodiscard]] bool is_turned_far(const Pose2& found, const Pose2& predicted);

/// The match with what the map says against it. Beams that end on a wall's back count twice: they
/// went through that wall, and what they fit is not what they saw.
[[nodiscard]] MatchResult with_contradiction(MatchResult match, const MatchProblem& problem,
                                             const OccupancyGrid& occupancy);

/// What speaks for a match less what speaks against it: its score less its contradiction.
[[nodiscard]] double net_score(const MatchResult& match);

/// Whether a match is one that is known to be right by itself: a good fit in one place alone, with
/// hardly a beam through walls, by a search that was not ended early.
[[nodiscard]] bool is_convincing(const MatchResult& match, const DoubtOptions& options);

/// Whether a scan was not taken there: its beams would go through walls, or it lies on mapped
/// ground and does not fit.
[[nodiscard]] bool is_out_of_place(const PointScan& scan, const Pose2& map_from_base,
                                   const SlamMap& map, const DoubtOptions& options);

/// By exact search in the window of the prior.
[[nodiscard]] MatchResult search_exactly(const MatchProblem& problem);

/// The same with the contradiction told.
[[nodiscard]] MatchResult search_exactly(const MatchProblem& problem,
                                         const OccupancyGrid& occupancy);

}  // namespace matchbox_slam
