#include "run/slam_session.hpp"

#include <fmt/core.h>

#include <cmath>
#include <utility>
#include <variant>

#include "common/number_text.hpp"
#include "run/start_map.hpp"

namespace matchbox_slam {

namespace {

/// From which range [m] on readings of this laser were none in the newest key scan of it, where
/// that is less than by default.
std::optional<double> limit_of(const KeyScans& keys, const ScanInput& input) {
  const PlacedScans& all = keys.all();
  for (auto key = all.rbegin(); key != all.rend(); ++key) {
    if (key->scan->laser() != input.laser || key->scan->is_of_image()) {
      continue;
    }
    const std::optional<MeasuredScan> measured = key->scan->measured();
    const bool has_limit = measured && measured->scan.range_max == input.scan.range_max &&
                           measured->options.max_range < ProjectionOptions{}.max_range;
    return has_limit ? std::optional<double>(measured->options.max_range) : std::nullopt;
  }
  return std::nullopt;
}

/// Why a drive is another than that of a saved map.
std::string text_of_another_drive(double stamp, std::optional<double> saved) {
  std::string why;
  if (saved) {
    why = fmt::format(", as its first scan is {:.3f}{} than the last one of the map",
                      std::abs(stamp - *saved), stamp > *saved ? " s newer" : " s older");
  }
  return fmt::format("; this is another drive{}: the robot is searched for in the map", why);
}

}  // namespace

SlamSession::SlamSession(LiveConfiguration configuration, RunRecords records, RunDialog dialog,
                         std::string how_to_set)
    : run_(std::move(configuration), records),
      dialog_(std::move(dialog)),
      how_to_set_(std::move(how_to_set)) {}

// --- how it begins ---

void SlamSession::go_on_with(SavedStart saved) {
  run_.start_from(saved.map);
  is_continued_ = true;
  may_map_have_limit_ = true;
  saved_ = std::move(saved);
}

void SlamSession::begin_with(LoadMapFile initial) {
  initial_ = std::move(initial);
  if (is_continued_) {
    return;
  }
  for (const RunEvent& event : beginning()) {
    apply(event);
  }
}

std::vector<RunEvent> SlamSession::beginning() const {
  if (!initial_) {
    return {Reset{}};
  }
  std::vector<RunEvent> events{*initial_};
  if (is_start_given()) {
    events.emplace_back(configured_start(setup().run));
  } else if (!setup().engine.slam.update_map && !initial_->map->key_scans.empty()) {
    events.emplace_back(BeAnywhere{});
  }
  return events;
}

bool SlamSession::is_start_given() const {
  const LiveConfiguration& configuration = run_.configuration();
  return configuration.is_given("start_x") || configuration.is_given("start_y") ||
         configuration.is_given("start_theta");
}

/// Of another drive it is when the robot was switched off between, and its odometry begins anew.
void SlamSession::take_up(const ScanInput& input) {
  SavedStart saved = *std::exchange(saved_, std::nullopt);
  const double stamp = input.scan.stamp;
  const std::optional<double> last = saved.map.motion.stamp;
  const bool has_key_scans = !saved.map.key_scans.empty();
  const bool is_restarted = saved.may_odometry_tell;
  // What is saved now and then is as old as that.
  const bool same_drive =
      run_.take_up(std::move(saved.map), stamp, kLongestPause + setup().node.autosave_period,
                   is_restarted ? odometry_of(input) : std::nullopt);
  // Where the same program was only started again they told of its first start.
  const bool is_told = !same_drive && !is_restarted && is_start_given();
  if (is_told) {
    run_.apply(configured_start(setup().run));
  }
  dialog_.inform(fmt::format(
      "going on with {}{}", saved.file,
      same_drive
          ? fmt::format(", whose drive goes on after its scan of {:.3f} s with that of {:.3f} s",
                        last.value_or(0.0), stamp)
      : has_key_scans && !is_told
          ? text_of_another_drive(stamp, last)
          : "; the robot is taken to be where start_x, start_y and start_theta say"));
}

/// The beams that met nothing in the map meet nothing now: where that was found it took a while.
void SlamSession::take_up_limit(const ScanInput& input) {
  may_map_have_limit_ = false;
  if (run_.configuration().is_given("scan/max_range") || setup().run.scan_topics.size() > 1) {
    return;
  }
  if (const std::optional<double> limit = limit_of(run_.key_scans(), input)) {
    Parameters changes;
    changes.set("scan/max_range", *limit);
    run_.apply(Reconfigure{std::move(changes)});
    dialog_.inform(
        fmt::format("scan/max_range is set to {:.3f} m, as for the scans of the same laser in the "
                    "map; for another value {}scan/max_range=VALUE",
                    *limit, how_to_set_));
  }
}

// --- scans and events ---

std::optional<ScanOutcome> SlamSession::process(const ScanInput& input) {
  if (saved_ && !run_.is_paused()) {
    take_up(input);
  }
  if (may_map_have_limit_ && !run_.is_paused()) {
    take_up_limit(input);
  }
  std::optional<ScanOutcome> outcome = run_.process(input);
  if (outcome) {
    tell(*outcome);
  }
  return outcome;
}

void SlamSession::apply(const RunEvent& event) {
  const auto* told = std::get_if<SetPose>(&event);
  if (saved_ && told != nullptr) {
    SavedStart saved = *std::exchange(saved_, std::nullopt);
    run_.take_up_at(std::move(saved.map), *told);
    dialog_.inform(
        fmt::format("going on with {}; where the robot is in it has been told", saved.file));
    return;
  }
  run_.apply(event);
  if (gives_up_map(event)) {
    may_map_have_limit_ = std::holds_alternative<LoadMapFile>(event);
    saved_.reset();
    told_of_left_out_ = false;
  }
}

bool SlamSession::jump_back(const std::string& jumped, bool stopped) {
  if (stopped) {
    dialog_.warn(jumped + "stopping there, as time_jump is 'stop'");
    return false;
  }
  if (setup().run.time_jump == "go_on") {
    dialog_.warn(jumped +
                 "the map goes on, as time_jump is 'go_on'; with 'reset' a new one begins");
    run_.step_back();
    return false;
  }
  dialog_.warn(jumped + "starting a new map, as time_jump is 'reset'");
  saved_.reset();
  run_.jump_back();
  if (initial_) {
    for (const RunEvent& event : beginning()) {
      run_.apply(event);
    }
  }
  return true;
}

void SlamSession::begin_drive(double stamp) {
  dialog_.inform(fmt::format(
      "another drive begins after {} scans: the robot is searched for in the map", run_.scans()));
  run_.begin_drive(stamp);
}

std::vector<RunEvent> SlamSession::cut_no_returns(double from, bool has_begun) {
  if (run_.configuration().is_given("scan/max_range")) {
    return {};
  }
  const std::string found = "where they meet nothing, beams of a laser read one range plus noise";
  const std::string limit = fixed_text(from, 3);
  if (setup().run.scan_topics.size() > 1) {
    dialog_.warn(
        fmt::format("{}, which draws walls where none are; to cut them {}scan/max_range={}{}",
                    found, how_to_set_, limit, has_begun ? ", and let the map begin anew" : ""));
    return {};
  }
  Parameters changes;
  changes.set("scan/max_range", from);
  std::vector<RunEvent> events{Reconfigure{std::move(changes)}};
  const bool begins_anew = has_begun && run_.resets() == 0 && !is_continued_;
  if (begins_anew) {
    events.emplace_back(Reset{});
  }
  dialog_.warn(fmt::format("{}; scan/max_range is set to {} m, from which on they are no return{}",
                           found, limit, begins_anew ? ", and the map begins anew" : ""));
  return events;
}

// --- what people are told ---

void SlamSession::tell(const ScanOutcome& outcome) {
  if (outcome.left_out > 0 && !std::exchange(told_of_left_out_, true)) {
    dialog_.warn(
        "a scan is left out of the map, which would have more cells than map/max_cells allows; is "
        "its pose a wild one?");
  }
  if (outcome.gave_up_component) {
    dialog_.warn(
        "the map apart of the fewest key scans is given up, as 16 are kept; the robot was lost too "
        "often");
  }
  for (const int number : run_.laser_news()) {
    const SecondaryLaser& laser = run_.secondary_lasers().at(number);
    (laser.is_used ? dialog_.inform : dialog_.warn)(text_of(laser, run_.scan_topic(number)));
  }
}

void SlamSession::advise() {
  const auto warn_once = [this](const std::string& text, bool& told) {
    if (!text.empty() && !std::exchange(told, true)) {
      dialog_.warn(text);
    }
  };
  warn_once(robot_beams(), told_of_robot_beams_);
  warn_once(few_returns(), told_of_few_returns_);
}

std::string SlamSession::robot_beams() const {
  const std::vector<double> sectors = run_.robot_beams();
  return sectors.empty()
             ? ""
             : text_of_robot_beams(sectors, setup().engine.scan.masked_angles, how_to_set_);
}

std::string SlamSession::few_returns() const { return text_of_few_returns(run_.returns()); }

}  // namespace matchbox_slam
