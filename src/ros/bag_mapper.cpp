#include "matchbox_slam/ros/bag_mapper.hpp"

#include <algorithm>
#include <iomanip>
#include <set>
#include <sstream>
#include <utility>

#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/map_file.hpp"
#include "matchbox_slam/io/map_picture.hpp"
#include "matchbox_slam/io/tum.hpp"
#include "matchbox_slam/io/yaml_parameters.hpp"
#include "matchbox_slam/ros/bag_survey.hpp"
#include "matchbox_slam/ros/run_report.hpp"
#include "matchbox_slam/ros/scan_queue.hpp"
#include "matchbox_slam/ros/slam_run.hpp"
#include "matchbox_slam/ros/slam_setup.hpp"

namespace matchbox_slam {

namespace {

constexpr std::size_t kReadAhead = 512;  // messages

std::string seconds_text(double seconds) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(1) << seconds << " s";
  return text.str();
}

/// Defaults of the structs < files < flags of their own < --set.
Parameters gather_parameters(const MapBagRequest& request) {
  Parameters parameters = read_yaml_parameters(request.config_files);
  if (request.matcher) {
    parameters.set("matcher", *request.matcher);
  }
  if (request.seed) {
    parameters.set("seed", static_cast<std::int64_t>(*request.seed));
  }
  if (request.base_frame) {
    parameters.set("base_frame", *request.base_frame);
  }
  if (request.odom_frame) {
    parameters.set("odom_frame", *request.odom_frame);
  }
  if (request.no_odometry) {
    parameters.set("use_odometry", false);
  }
  parameters.merge(parse_overrides(request.overrides));
  return parameters;
}

std::optional<std::string> given(const Parameters& parameters, const std::string& name,
                                 const std::string& value) {
  return parameters.find(name) != nullptr ? std::optional(value) : std::nullopt;
}

/// The frames that were asked for, which must differ before the bag can tell about the others.
void check_asked_frames(const Parameters& parameters, RunOptions options) {
  options.base_frame = given(parameters, "base_frame", options.base_frame).value_or("");
  options.odom_frame = given(parameters, "odom_frame", options.odom_frame).value_or("");
  check_frames(options);
}

/// One run over one bag: what it works with, and what it is told on the way.
class BagMapping {
 public:
  BagMapping(const MapBagRequest& request, const MapBagDialog& dialog)
      : request_(request),
        dialog_(dialog),
        started_(resource_usage()),
        parameters_(gather_parameters(request)),
        setup_(make_slam_setup(parameters_, loader_)),
        reader_(request.bags) {
    require_writable_folder(request.out);
  }

  void prepare();
  void read();
  void write();

 private:
  void choose_clock(const BagSurvey& survey);
  void take(const BagMessage& message);
  void process_ready();
  void jump(const TimeJump& jump);
  void warn_of_skipped();
  void warn_of_map_link();
  void show_progress(const ros::Time& time);
  void require_used_scans() const;
  void require_not_interrupted() const;

  const MapBagRequest& request_;
  const MapBagDialog& dialog_;
  ResourceUsage started_;
  MatcherLoader loader_;
  Parameters parameters_;
  SlamSetup setup_;
  BagReader reader_;
  RunFacts facts_;
  std::optional<ScanQueue> queue_;
  std::optional<SlamRun> run_;
  std::set<SkipReason> told_;
  std::string first_skip_;
  bool told_of_map_link_ = false;
  bool stopped_ = false;
  std::optional<ros::Time> first_time_;
  ros::Time last_time_;
};

void BagMapping::prepare() {
  check_asked_frames(parameters_, setup_.run);
  facts_.bags = request_.bags;
  facts_.threads = request_.threads;
  facts_.scan_topic = choose_scan_topic(reader_, request_.scan_topic);
  const BagSurvey survey = survey_bag(reader_, facts_.scan_topic, request_.period,
                                      setup_.run.map_frame, dialog_.is_interrupted);
  require_not_interrupted();
  if (survey.scan_frame.empty()) {
    throw BagError("the bag holds no scan on topic " + facts_.scan_topic +
                   " in the period asked for; it lasts " +
                   seconds_text((reader_.end_time() - reader_.begin_time()).toSec()));
  }
  const BagFrames frames = choose_frames(
      survey, given(parameters_, "base_frame", setup_.run.base_frame),
      given(parameters_, "odom_frame", setup_.run.odom_frame), setup_.run.use_odometry);
  setup_.run.base_frame = frames.base;
  setup_.run.odom_frame = frames.odom.value_or("");
  check_frames(setup_.run);
  dialog_.inform("scan topic " + facts_.scan_topic + ", scan frame " + survey.scan_frame +
                 ", base frame " + frames.base +
                 (frames.odom ? ", odometry frame " + *frames.odom : ", without odometry"));
  choose_clock(survey);
  queue_.emplace(queue_settings(setup_.run, facts_.scan_time_offset));
  run_.emplace(setup_);
}

void BagMapping::choose_clock(const BagSurvey& survey) {
  facts_.estimated_clock_offset = survey.scan_time_offset;
  const double estimate = survey.scan_time_offset.value_or(0.0);
  const bool differs = std::abs(estimate) > kClockOffsetWorthTelling;
  const std::optional<double> fixed = fixed_scan_time_offset(setup_.run);
  facts_.scan_time_offset = fixed.value_or(differs ? estimate : 0.0);
  if (differs && std::abs(estimate - facts_.scan_time_offset) > kClockOffsetWorthTelling) {
    dialog_.warn("the clocks of scans and tf differ: scans are " +
                 seconds_text(std::abs(estimate)) + (estimate > 0.0 ? " behind" : " ahead") +
                 "; to correct that give --set scan_time_offset=auto");
  } else if (facts_.scan_time_offset != 0.0) {
    dialog_.inform("stamps of scans are moved by " + seconds_text(facts_.scan_time_offset) +
                   " to the clock of tf");
  }
}

void BagMapping::read() {
  std::unique_ptr<BagStream> stream = reader_.stream(facts_.scan_topic, request_.period);
  if (request_.threads > 1) {
    stream = read_ahead(std::move(stream), kReadAhead);
  }
  try {
    while (!stopped_ && !facts_.interrupted) {
      const std::optional<BagMessage> message = stream->next();
      if (!message) {
        break;
      }
      take(*message);
      process_ready();
      facts_.interrupted = dialog_.is_interrupted();
    }
  } catch (const BagError& error) {
    facts_.damage = error.what();
  }
  queue_->finish();
  process_ready();
  facts_.ignored_map_link = queue_->transforms().ignored_map_link();
  facts_.invalid_transforms = queue_->transforms().invalid_count();
}

void BagMapping::take(const BagMessage& message) {
  if (const auto* transforms = std::get_if<BagTransforms>(&message.content)) {
    queue_->add_transforms(*transforms->message, transforms->is_static, message.time);
    warn_of_map_link();
    return;
  }
  queue_->add_scan(*std::get<sensor_msgs::LaserScan::ConstPtr>(message.content), message.time);
  first_time_ = first_time_ ? first_time_ : message.time;
  last_time_ = message.time;
  show_progress(message.time);
}

void BagMapping::process_ready() {
  while (const std::optional<ScanQueue::Item> item = queue_->next()) {
    if (const auto* scan = std::get_if<ReadyScan>(&*item)) {
      run_->process(scan->input);
    } else {
      jump(std::get<TimeJump>(*item));
    }
  }
  warn_of_skipped();
}

void BagMapping::jump(const TimeJump& jump) {
  const std::string jumped = "time jumps back by " + seconds_text(jump.seconds) + " after " +
                             std::to_string(run_->trajectory().size()) + " scans: ";
  if (jump.stopped) {
    dialog_.warn(jumped + "stopping there, as time_jump is 'stop'");
    stopped_ = true;
  } else {
    dialog_.warn(jumped + "starting a new map, as time_jump is 'reset'");
    run_->reset();
    queue_->discard_delivered();
    ++facts_.resets;
  }
}

void BagMapping::warn_of_skipped() {
  for (const SkippedScan& skipped : queue_->take_skipped()) {
    if (told_.insert(skipped.reason).second) {
      dialog_.warn(skipped.text);
    }
    if (first_skip_.empty()) {
      first_skip_ = skipped.text;
    }
  }
}

void BagMapping::warn_of_map_link() {
  const std::string& link = queue_->transforms().ignored_map_link();
  if (!told_of_map_link_ && !link.empty()) {
    dialog_.warn("tf in the bag that touches the map frame is ignored: " + link);
    told_of_map_link_ = true;
  }
}

void BagMapping::show_progress(const ros::Time& time) {
  const double begin = (*first_time_).toSec();
  const double length = std::min(reader_.end_time().toSec() - begin, request_.period.duration);
  const double done = time.toSec() - begin;
  dialog_.show_progress(length > 0.0 ? std::min(done / length, 1.0) : 1.0,
                        std::to_string(queue_->account().received) + " scans");
}

void BagMapping::require_not_interrupted() const {
  if (dialog_.is_interrupted()) {
    throw BagError("interrupted before the first scan was used; nothing is written");
  }
}

void BagMapping::require_used_scans() const {
  if (run_->trajectory().empty()) {
    require_not_interrupted();
    throw BagError("none of " + std::to_string(queue_->account().received) +
                   " scans could be used; the first: " +
                   (first_skip_.empty() ? "none was read" : first_skip_) +
                   (facts_.damage.empty() ? "" : "; " + facts_.damage));
  }
}

void BagMapping::write() {
  require_used_scans();
  const Trajectory trajectory(run_->trajectory());
  const Trajectory odometry(run_->odometry());
  const SlamMap& map = run_->map();
  facts_.bag_seconds = (last_time_ - *first_time_).toSec();
  write_map(request_.out + "/map", make_map_image(map.occupancy));
  const std::string picture = encode_png(draw_map(map.occupancy, trajectory, odometry));
  const ResourceUsage now = resource_usage();
  facts_.used = {now.wall_seconds - started_.wall_seconds, now.cpu_seconds - started_.cpu_seconds,
                 now.peak_memory};
  const ScanAccount& account = queue_->account();
  replace_files({{request_.out + "/trajectory.tum", to_tum(trajectory)},
                 {request_.out + "/odometry.tum", to_tum(odometry)},
                 {request_.out + "/map.png", picture},
                 {request_.out + "/report.json", to_json(facts_, account, *run_, setup_)}});
  dialog_.inform(std::to_string(account.delivered) + " of " + std::to_string(account.received) +
                 " scans used in " + seconds_text(facts_.used.wall_seconds) + ", " +
                 seconds_text(facts_.bag_seconds) + " of bag; results in " + request_.out);
  if (facts_.interrupted) {
    dialog_.warn("interrupted: the results cover the bag up to there");
  }
  if (!facts_.damage.empty()) {
    throw BagError(facts_.damage + "; the results cover the part before");
  }
}

}  // namespace

void map_bag(const MapBagRequest& request, const MapBagDialog& dialog) {
  BagMapping mapping(request, dialog);
  mapping.prepare();
  mapping.read();
  mapping.write();
}

}  // namespace matchbox_slam
