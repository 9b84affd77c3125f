#include "tools/bag_mapper.hpp"

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "io/hough_picture.hpp"
#include "io/map_picture.hpp"
#include "io/tum.hpp"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/map_file.hpp"
#include "matchbox_slam/io/yaml_parameters.hpp"
#include "ros/matcher_loader.hpp"
#include "run/slam_run.hpp"
#include "run/slam_setup.hpp"
#include "tools/run_report.hpp"

namespace matchbox_slam {
namespace {

/// Defaults of the structs < files < flags of their own < --set.
Parameters gather_parameters(const MapBagRequest& request) {
  Parameters parameters = read_yaml_parameters(request.config_files);
  if (request.matcher) {
    parameters.set("matcher", *request.matcher);
  }
  if (request.seed) {
    parameters.set("seed", static_cast<std::int64_t>(*request.seed));
  }
  parameters.merge(frame_parameters(request.recording));
  parameters.merge(parse_overrides(request.overrides));
  return parameters;
}

/// The first key scans of a map.
class FirstKeyScans {
 public:
  void add(const std::shared_ptr<const KeyScan>& key) {
    if (key_scans_.size() <= kMostHoughPictures) {
      key_scans_.push_back(key);
    }
  }
  void clear() { key_scans_.clear(); }

  /// What the Hough matcher sees of each one and its predecessor, one picture each.
  [[nodiscard]] std::vector<FileContents> draw(const std::string& folder,
                                               const HoughAlignmentOptions& options) const {
    std::vector<FileContents> files;
    for (std::size_t i = 1; i < key_scans_.size(); ++i) {
      files.push_back(
          hough_picture_file(folder, i - 1, key_scans_[i - 1]->scan, key_scans_[i]->scan, options));
    }
    return files;
  }

 private:
  std::vector<std::shared_ptr<const KeyScan>> key_scans_;
};

std::size_t count_of(MatchStatus status, const SlamRun& run) {
  const auto found = run.statuses().find(status);
  return found == run.statuses().end() ? 0 : found->second;
}

/// What to tell people when fewer than half of the scans matched; else nothing.
std::string text_of_few_matches(const SlamRun& run) {
  const std::size_t matched = count_of(MatchStatus::kAccepted, run);
  const std::size_t tried = run.scans() - 1;  // the first one starts the map
  if (2 * matched >= tried) {
    return "";
  }
  std::string text = "only " + std::to_string(matched) + " of " + std::to_string(tried) +
                     " scans match the map; the others are placed by the prediction alone";
  const auto add = [&](std::size_t count, const std::string& reason) {
    if (count > 0) {
      text += "; " + std::to_string(count) + " " + reason;
    }
  };
  add(count_of(MatchStatus::kRejectedTooFewPoints, run),
      "have too few hits: see slam/min_points and what scan/* leaves out");
  add(count_of(MatchStatus::kRejectedLowScore, run),
      "fit nowhere near the prediction: see motion/* and the matcher's window");
  add(count_of(MatchStatus::kRejectedNoReference, run) - 1,
      "met no map: see slam/update_map and what scan/* leaves out");
  return text;
}

/// One run over one bag.
class BagMapping {
 public:
  BagMapping(const MapBagRequest& request, const RunDialog& dialog)
      : out_(request.out),
        debug_(request.debug),
        dialog_(dialog),
        started_(resource_usage()),
        parameters_(gather_parameters(request)),
        setup_(make_slam_setup(parameters_, loader_)),
        scans_(request.recording, dialog) {
    require_writable_folder(out_);
    if (!debug_.empty()) {
      require_writable_folder(debug_);
    }
  }

  void map();
  void write();

 private:
  void map(const ReadyScan& scan);
  void jump(const TimeJump& jump);

  const std::string& out_;
  const std::string& debug_;
  const RunDialog& dialog_;
  ResourceUsage started_;
  MatcherLoader loader_;
  Parameters parameters_;
  SlamSetup setup_;
  BagScans scans_;
  std::optional<SlamRun> run_;
  FirstKeyScans first_key_scans_;
  std::size_t resets_ = 0;
  bool told_of_left_out_ = false;
};

void BagMapping::map() {
  scans_.prepare(parameters_, setup_.run);
  run_.emplace(setup_);
  while (const std::optional<ScanQueue::Item> item = scans_.next()) {
    if (const auto* scan = std::get_if<ReadyScan>(&*item)) {
      map(*scan);
    } else {
      jump(std::get<TimeJump>(*item));
    }
  }
}

void BagMapping::map(const ReadyScan& scan) {
  const ScanOutcome outcome = run_->process(scan.input);
  if (outcome.inserted && !debug_.empty()) {
    first_key_scans_.add(run_->key_scans().back());
  }
  if (outcome.left_out && !told_of_left_out_) {
    dialog_.warn(kLeftOut);
    told_of_left_out_ = true;
  }
}

void BagMapping::jump(const TimeJump& jump) {
  const std::string jumped = text_of(jump, run_->trajectory().size());
  if (jump.stopped) {
    dialog_.warn(jumped + "stopping there, as time_jump is 'stop'");
    scans_.stop();
  } else {
    dialog_.warn(jumped + "starting a new map, as time_jump is 'reset'");
    run_->reset();
    first_key_scans_.clear();
    scans_.discard_delivered();
    ++resets_;
  }
}

void BagMapping::write() {
  if (run_->trajectory().empty()) {
    scans_.throw_nothing_used();
  }
  const Trajectory trajectory(run_->trajectory());
  const Trajectory odometry(run_->odometry());
  const SlamMap& map = run_->map();
  const ScanAccount& account = scans_.account();
  const std::string picture = draw_map(map.occupancy, trajectory, odometry).to_png();
  const ResourceUsage now = resource_usage();
  const RunFacts facts{scans_.facts(),
                       resets_,
                       {now.wall_seconds - started_.wall_seconds,
                        now.cpu_seconds - started_.cpu_seconds, now.peak_memory}};
  std::vector<FileContents> files = map_files(out_ + "/map", make_map_image(map.occupancy));
  files.insert(files.end(), {{out_ + "/trajectory.tum", to_tum(trajectory)},
                             {out_ + "/odometry.tum", to_tum(odometry)},
                             {out_ + "/map.png", picture},
                             {out_ + "/report.json", to_json(facts, account, *run_, setup_)}});
  replace_files(files);
  if (!debug_.empty()) {
    replace_files(first_key_scans_.draw(debug_, setup_.hough.alignment));
  }
  dialog_.inform(std::to_string(account.delivered) + " of " + std::to_string(account.received) +
                 " scans used, " + std::to_string(count_of(MatchStatus::kAccepted, *run_)) +
                 " matched, in " + seconds_text(facts.used.wall_seconds) + ", " +
                 seconds_text(facts.bag.seconds) + " of bag; results in " + out_);
  if (const std::string few = text_of_few_matches(*run_); !few.empty()) {
    dialog_.warn(few);
  }
  if (facts.bag.interrupted) {
    dialog_.warn("interrupted: the results cover the bag up to there");
  }
  if (!facts.bag.damage.empty()) {
    throw BagError(facts.bag.damage + "; the results cover the part before");
  }
}

}  // namespace

void map_bag(const MapBagRequest& request, const RunDialog& dialog) {
  BagMapping mapping(request, dialog);
  mapping.map();
  mapping.write();
}

}  // namespace matchbox_slam
