#include "tools/map_merger.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <regex>
#include <set>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "io/map_picture.hpp"
#include "io/tum.hpp"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/saved_map.hpp"
#include "merging/map_merging.hpp"
#include "ros/matcher_loader.hpp"
#include "run/live_configuration.hpp"
#include "run/map_saver.hpp"
#include "run/mergeable_map.hpp"
#include "run/resource_usage.hpp"
#include "run/shown_map.hpp"
#include "tools/json_text.hpp"
#include "tools/out_folder.hpp"
#include "tools/provenance.hpp"
#include "tools/recording_request.hpp"
#include "tools/scan_table.hpp"

namespace matchbox_slam {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Of the n-th map that is written, without its folder.
std::string map_name(std::size_t number) {
  return number == 0 ? "map" : fmt::format("map_{}", number + 1);
}

std::string trajectory_name(std::size_t input) {
  return fmt::format("trajectory_{}.tum", input + 1);
}

/// "a, b and c"
std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    text += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + names[i];
  }
  return text;
}

void require_maps(const MergeMapsRequest& request) {
  if (request.maps.size() < 2) {
    throw ConfigurationError("MAP: 1 map is nothing to merge; give two or more");
  }
  for (std::size_t i = 0; i < request.maps.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      std::error_code unknown;  // of what is not there reading tells
      if (fs::equivalent(request.maps[i], request.maps[j], unknown)) {
        throw ConfigurationError(
            fmt::format("MAP: {} is given twice; give each map once", request.maps[i]));
      }
    }
  }
}

/// Whether results may have the name: a map apart of an input makes more maps than there are
/// inputs.
bool is_map_name(const std::string& name) {
  return std::regex_match(name, std::regex("map(_[0-9]+)?\\.slam"));
}

void require_out(const MergeMapsRequest& request) {
  if (request.out.empty()) {
    throw ConfigurationError("--out: '' is no name of a folder");
  }
  for (const std::string& map : request.maps) {
    if (!request.overwrite && is_map_name(fs::path(map).filename().string())) {
      require_other_folder(map, request.out);
    }
  }
}

/// Saved maps that become one.
class MapMerger {
 public:
  MapMerger(const MergeMapsRequest& request, const RunDialog& dialog);

  void merge();
  void write() const;

 private:
  void take_cells_of_first();
  void add_map(std::size_t number, FileReplacement& files) const;
  void add_trajectory(std::size_t input, FileReplacement& files) const;
  [[nodiscard]] Trajectory trajectory_in(const MergedMap& map, std::size_t input) const;
  [[nodiscard]] std::size_t map_of(std::size_t input) const;
  [[nodiscard]] std::vector<std::string> names_in(const MergedMap& map) const;
  [[nodiscard]] json facts_of(std::size_t number) const;
  [[nodiscard]] std::string report() const;
  [[nodiscard]] std::vector<std::string> leftovers() const;
  void tell() const;

  const MergeMapsRequest& request_;
  const RunDialog& dialog_;
  ResourceUsage started_ = resource_usage();
  MatcherLoader loader_;
  LiveConfiguration configuration_;
  EngineOptions options_;
  bool is_out_new_ = false;
  std::optional<FolderLock> out_lock_;
  std::vector<EngineState> inputs_;
  std::vector<MergedMap> maps_;
};

Parameters parameters_of(const MergeMapsRequest& request) {
  RecordingRequest parameters;
  parameters.config_files = request.config_files;
  parameters.overrides = request.overrides;
  return gather_parameters(parameters);
}

MapMerger::MapMerger(const MergeMapsRequest& request, const RunDialog& dialog)
    : request_(request),
      dialog_(dialog),
      configuration_(parameters_of(request), loader_, SetupOf::kProgram),
      options_(configuration_.setup().engine) {
  require_maps(request);
  require_out(request);
  for (const std::string& path : request.maps) {
    inputs_.push_back(read_mergeable_map(path, options_));
  }
  take_cells_of_first();
  is_out_new_ = !fs::exists(request.out);
  require_writable_folder(request.out);
  out_lock_.emplace(request.out);
}

/// What a map was drawn in does not matter, as all are drawn anew.
void MapMerger::take_cells_of_first() {
  const LikelihoodField& field = inputs_.front().map.field;
  const auto take = [this](const std::string& name, double of_first, double& option) {
    option = configuration_.is_given(name) ? option : of_first;
  };
  take("map/resolution", field.geometry().resolution(), options_.map.resolution);
  take("field/sigma", field.options().sigma, options_.field.sigma);
  take("field/reach", field.options().reach, options_.field.reach);
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    const double cell = inputs_[i].map.field.geometry().resolution();
    if (cell != options_.map.resolution) {
      dialog_.inform(fmt::format("{}: is drawn anew in cells of {} m in place of {} m",
                                 request_.maps[i], to_string(options_.map.resolution),
                                 to_string(cell)));
    }
  }
}

void MapMerger::merge() {
  maps_ = merged_maps(inputs_, options_, [this](std::size_t maps, double done) {
    if (dialog_.is_interrupted()) {
      std::error_code kept;
      if (is_out_new_) {
        fs::remove(request_.out, kept);  // it is empty
      }
      throw std::runtime_error(fmt::format(
          "interrupted while {} maps were searched in each other; nothing was written", maps));
    }
    dialog_.show_progress(done, fmt::format("{} maps searched in each other", maps));
  });
}

/// The one that holds what the robot of the input saw, or most of it.
std::size_t MapMerger::map_of(std::size_t input) const {
  std::pair<std::size_t, std::size_t> best{inputs_.size(), 0};  // part and map
  for (std::size_t number = 0; number < maps_.size(); ++number) {
    for (const MergedStretch& stretch : maps_[number].stretches) {
      if (stretch.input == input) {
        best = std::min(best, {stretch.component, number});
      }
    }
  }
  return best.second;
}

Trajectory MapMerger::trajectory_in(const MergedMap& map, std::size_t input) const {
  KeyScans keys;
  for (const MergedStretch& stretch : map.stretches) {
    for (std::size_t i = stretch.begin; stretch.input == input && i < stretch.end; ++i) {
      keys.add(map.component.key_scans.all()[i]);
    }
  }
  return key_scan_trajectory(keys);
}

void MapMerger::add_trajectory(std::size_t input, FileReplacement& files) const {
  const std::size_t number = map_of(input);
  add_tum_parts(
      fmt::format("{}/{}", request_.out, trajectory_name(input)),
      {trajectory_in(maps_[number], input).poses()},
      fmt::format("Of the key scans of {} in {}.slam: ", request_.maps[input], map_name(number)),
      files);
}

void MapMerger::add_map(std::size_t number, FileReplacement& files) const {
  const MergedMap& map = maps_[number];
  const std::string path = fmt::format("{}/{}", request_.out, map_name(number));
  const OccupancyGrid shown =
      shown_occupancy(map.component.map, map.component.key_scans.all(), options_.map);
  std::vector<Trajectory> drives;
  for (std::size_t input = 0; input < inputs_.size(); ++input) {
    drives.push_back(trajectory_in(map, input));
  }
  add_images(path, shown,
             draw_drives(shown, drives, graph_of(map.component.key_scans, map.loops)).to_png(),
             map_format(configuration_.setup().run), files);
  files.add(path + ".slam", [&](const ByteSink& sink) { write_saved_map(state_of(map), sink); });
}

/// Maps apart of one of the inputs, too.
std::vector<std::string> MapMerger::names_in(const MergedMap& map) const {
  std::set<std::pair<std::size_t, std::size_t>> parts;
  for (const MergedStretch& stretch : map.stretches) {
    parts.emplace(stretch.input, stretch.component);
  }
  std::vector<std::string> names;
  for (const auto& [input, part] : parts) {
    const bool is_apart = part > 0 && parts.count({input, 0}) == 0;
    if (part == 0 || is_apart) {
      names.push_back((is_apart ? "a map apart of " : "") + request_.maps[input]);
    }
  }
  return names;
}

json MapMerger::facts_of(std::size_t number) const {
  const MergedMap& map = maps_[number];
  const CellBox box = map.component.map.occupancy.known_bounds();
  json joints = json::array();
  for (const MergedJoint& joint : map.joints) {
    joints.push_back({{"stamp", joint.stamp},
                      {"stamp_there", joint.stamp_there},
                      {"key_scans_matched", joint.matched},
                      {"loops_tried", joint.tried},
                      {"loops_closed", joint.closed}});
  }
  return {{"file", map_name(number) + ".slam"},
          {"inputs", names_in(map)},
          {"key_scans", map.component.key_scans.size()},
          {"loops_closed", count_closed(map.loops.loops)},
          {"joints", joints},
          {"width", box.empty() ? 0 : box.width()},
          {"height", box.empty() ? 0 : box.height()},
          {"resolution", options_.map.resolution}};
}

std::string MapMerger::report() const {
  json report = json::object();
  add_provenance(report);
  report["inputs"] = json::array();
  for (std::size_t input = 0; input < inputs_.size(); ++input) {
    report["inputs"].push_back({{"file", request_.maps[input]},
                                {"key_scans", inputs_[input].key_scans.size()},
                                {"map", map_name(map_of(input)) + ".slam"},
                                {"trajectory", trajectory_name(input)}});
  }
  report["maps"] = json::array();
  for (std::size_t number = 0; number < maps_.size(); ++number) {
    report["maps"].push_back(facts_of(number));
  }
  const ResourceUsage now = resource_usage();
  report["wall_s"] = now.wall_seconds - started_.wall_seconds;
  report["cpu_s"] = now.cpu_seconds - started_.cpu_seconds;
  report["peak_rss_mb"] = now.peak_memory;
  report["configuration"] = values_of(describe_engine_options(options_));
  return json_text(report) + "\n";
}

void MapMerger::tell() const {
  for (std::size_t number = 0; number < maps_.size(); ++number) {
    const MergedMap& map = maps_[number];
    dialog_.inform(fmt::format("{}/{}.slam: {}; {} key scans, {} loops closed", request_.out,
                               map_name(number), listed(names_in(map)),
                               map.component.key_scans.size(), count_closed(map.loops.loops)));
  }
  for (std::size_t number = 1; number < maps_.size(); ++number) {
    dialog_.warn(
        fmt::format("{} met {} nowhere: a map of its own, {}.slam; to join them, let one robot "
                    "drive on through what the other one saw, for 15 m or more, and farther where "
                    "rooms and corridors are alike",
                    listed(names_in(maps_[number])), request_.maps.front(), map_name(number)));
  }
}

/// Of an earlier merge into the same folder, as its report has them: what would be taken for files
/// of this one.
std::vector<std::string> MapMerger::leftovers() const {
  const std::string report = request_.out + "/report.json";
  const json earlier =
      fs::exists(report) ? json::parse(read_file(report), nullptr, false) : json::object();
  std::vector<std::string> files;
  const auto count = [&](const char* of) {
    return earlier.is_object() && earlier.contains(of) ? earlier[of].size() : 0;
  };
  for (std::size_t number = maps_.size(); number < count("maps"); ++number) {
    for (const char* end : {".slam", ".pgm", ".yaml", ".png", ".occupancy.png"}) {
      files.push_back(fmt::format("{}/{}{}", request_.out, map_name(number), end));
    }
  }
  for (std::size_t input = inputs_.size(); input < count("inputs"); ++input) {
    files.push_back(fmt::format("{}/{}", request_.out, trajectory_name(input)));
  }
  files.erase(std::remove_if(files.begin(), files.end(),
                             [](const auto& file) { return !std::filesystem::exists(file); }),
              files.end());
  return files;
}

void MapMerger::write() const {
  const std::vector<std::string> left = leftovers();
  FileReplacement files;
  for (std::size_t number = 0; number < maps_.size(); ++number) {
    add_map(number, files);
  }
  for (std::size_t input = 0; input < inputs_.size(); ++input) {
    add_trajectory(input, files);
  }
  files.add({request_.out + "/report.json", report()});
  files.finish();
  if (!left.empty()) {
    dialog_.inform(fmt::format("what an earlier merge left in {} is in {} now", request_.out,
                               set_aside(left, request_.out + "/earlier")));
  }
  tell();
}

}  // namespace

void merge_maps(const MergeMapsRequest& request, const RunDialog& dialog) {
  MapMerger merger(request, dialog);
  merger.merge();
  merger.write();
}

}  // namespace matchbox_slam
