#include "tools/pair_report.hpp"

#include <fmt/core.h>

#include <cmath>
#include <iomanip>
#include <locale>
#include <nlohmann/json.hpp>
#include <sstream>

#include "common/number_text.hpp"
#include "tools/json_text.hpp"
#include "tools/provenance.hpp"

namespace matchbox_slam {
namespace {

using nlohmann::json;

constexpr double kMilli = 1e3;
constexpr double kMicro = 1e6;

void write_pose(std::ostream& text, const Pose2& pose) {
  text << ',' << pose.x << ',' << pose.y << ',' << pose.theta;
}

/// A bound that does not exist is the word "infinite".
json finite(double value) { return std::isfinite(value) ? json(value) : json("infinite"); }

json json_of(const std::optional<BoundStatistics>& bound) {
  if (!bound) {
    return nullptr;
  }
  return json::object({{"error_to_bound", bound->ratio ? json(*bound->ratio) : json(nullptr)},
                       {"bound_translation_mm", finite(bound->translation * kMilli)},
                       {"bound_heading_mrad", finite(bound->heading * kMilli)}});
}

json json_of(const MatcherOnPairs& matcher) {
  const PairStatistics& statistics = matcher.statistics;
  json entry = json::object({{"matcher", matcher.name},
                             {"pairs", statistics.pairs},
                             {"accepted", statistics.accepted},
                             {"success_rate", statistics.success_rate()},
                             {"translation_mm", to_json(statistics.translation, kMilli)},
                             {"heading_mrad", to_json(statistics.heading, kMilli)},
                             {"time_ms", to_json(statistics.seconds, kMilli)},
                             {"nees_mean", nullptr},
                             {"nees_median", nullptr}});
  if (statistics.covariance) {
    entry["nees_mean"] = statistics.covariance->mean_nees;
    entry["nees_median"] = statistics.covariance->median_nees;
  }
  entry["search"] = {{"success_rate", statistics.search_success_rate()},
                     {"translation_mm", to_json(statistics.search.translation, kMilli)},
                     {"heading_mrad", to_json(statistics.search.heading, kMilli)}};
  entry["cramer_rao"] = json_of(statistics.known_world_bound);
  entry["cramer_rao_unknown_walls"] = json_of(statistics.unknown_walls_bound);
  entry["configuration"] = values_of(matcher.configuration);
  return entry;
}

std::string ratio_of(const std::optional<BoundStatistics>& bound) {
  return bound && bound->ratio ? fixed_text(*bound->ratio, 2) : "–";
}

std::string row_of(const MatcherOnPairs& matcher) {
  const PairStatistics& s = matcher.statistics;
  const auto both = [](const ErrorStatistics& statistics, int decimals) {
    return fmt::format("{} / {}", fixed_text(statistics.median * kMilli, decimals),
                       fixed_text(statistics.p95 * kMilli, decimals));
  };
  return fmt::format("| {} | {:.1f} | {} | {} | {:.1f} | {} | {} | {} | {} | {} | {} |\n",
                     matcher.name, 100.0 * s.success_rate(), both(s.translation, 2),
                     both(s.heading, 3), 100.0 * s.search_success_rate(),
                     both(s.search.translation, 2), both(s.search.heading, 3), both(s.seconds, 3),
                     s.covariance ? fixed_text(s.covariance->mean_nees, 2) : "–",
                     ratio_of(s.known_world_bound), ratio_of(s.unknown_walls_bound));
}

}  // namespace

std::string pairs_csv(const std::vector<LocatedScan>& scans, const std::vector<ScanPair>& pairs,
                      const std::vector<MatcherOnPairs>& matchers) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << "matcher,reference_stamp,scan_stamp,guess_x,guess_y,guess_theta,x,y,theta,search_x,"
          "search_y,search_theta,var_x,var_y,var_theta,status,time_us\n";
  for (const MatcherOnPairs& matcher : matchers) {
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const ScanPair& pair = pairs[i];
      const auto& [result, seconds] = matcher.matches[i];
      text << matcher.name << std::fixed << std::setprecision(6) << ','
           << scans[pair.reference].scan.stamp << ',' << scans[pair.scan].scan.stamp
           << std::setprecision(9);
      write_pose(text, pair.guess);
      write_pose(text, result.map_from_base);
      write_pose(text, result.searched_map_from_base());
      text << std::scientific << std::setprecision(6) << ',' << result.covariance(0, 0) << ','
           << result.covariance(1, 1) << ',' << result.covariance(2, 2) << ','
           << to_string(result.status) << std::fixed << std::setprecision(1) << ','
           << seconds * kMicro << '\n';
    }
  }
  return text.str();
}

std::string pairs_json(const PairTask& task, const std::vector<MatcherOnPairs>& matchers) {
  json entries = json::array();
  for (const MatcherOnPairs& matcher : matchers) {
    entries.push_back(json_of(matcher));
  }
  json summary = json::object({{"bags", task.facts.bag.bags},
                               {"scan_topic", join(task.facts.bag.scan_topics)},
                               {"scan_time_offset_s", task.facts.bag.scan_time_offset},
                               {"truth", task.facts.truth},
                               {"scans", task.facts.scans},
                               {"scans_with_truth", task.facts.scans_with_truth},
                               {"pairs", task.options.pairs},
                               {"gap", task.options.gap},
                               {"gap_s", task.facts.gap_seconds},
                               {"beams", task.facts.beams},
                               {"reach_m", task.facts.reach},
                               {"error_xy_m", task.options.error_xy},
                               {"error_theta_rad", task.options.error_theta},
                               {"error_draw", task.options.error_draw},
                               {"told_xy_m", task.options.told_xy},
                               {"told_theta_rad", task.options.told_theta},
                               {"success_xy_m", task.limits.xy},
                               {"success_theta_rad", task.limits.theta},
                               {"seed", task.seed},
                               {"threads", task.threads},
                               {"matchers", entries}});
  add_provenance(summary);
  return json_text(summary) + "\n";
}

std::string pairs_markdown(const PairTask& task, const std::vector<MatcherOnPairs>& matchers) {
  std::string text = fmt::format(
      "{} pairs of scans {} apart, guess off by up to {:.3f} m and {:.3f} rad, seed {}. Success: "
      "within {:.0f} mm and {:.0f} mrad of the truth. NEES: 3 is an honest covariance. Error / "
      "bound: 1 is the least that the noise of the scan allows (Cramér–Rao) in a world that is "
      "known, and in one whose straight walls only the other scan tells. Search alone: where the "
      "search ended, before its answer was refined.\n\n",
      task.options.pairs, task.options.gap, task.options.error_xy, task.options.error_theta,
      task.seed, task.limits.xy * kMilli, task.limits.theta * kMilli);
  text +=
      "| matcher | success % | error mm, median / 95 % | mrad, median / 95 % | search alone: "
      "success "
      "% | mm, median / 95 % | mrad, median / 95 % | time ms, median / 95 % | mean NEES | error / "
      "bound | of unknown walls |\n|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const MatcherOnPairs& matcher : matchers) {
    text += row_of(matcher);
  }
  return text;
}

}  // namespace matchbox_slam
