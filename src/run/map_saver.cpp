#include "run/map_saver.hpp"

#include <fmt/core.h>

#include <filesystem>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "io/map_picture.hpp"
#include "matchbox_slam/io/file.hpp"
#include "run/shown_map.hpp"

namespace matchbox_slam {

namespace {

/// Each time anew: `map_file` may change while the mapping goes on.
std::string path_of(const MapToSave& now) { return absolute_path(now.setup.node.map_file); }

/// Lets work fail as files do that cannot be written.
template <typename Work>
auto as_file_error(const Work& work) {
  try {
    return work();
  } catch (const std::filesystem::filesystem_error& error) {
    const std::string path = error.path1().string();
    throw FileError(fmt::format("the map cannot be saved{}: {}",
                                path.empty() ? "" : fmt::format(" ('{}')", path),
                                error.code().message()));
  }
}

}  // namespace

MapRevision revision_of(const SlamRun& run) {
  return {run.resets(), run.clock_steps(), run.key_scans().size(), run.scans()};
}

MapToSave map_to_save(const SlamRun& run) {
  if (run.scans() == 0) {
    throw std::runtime_error("no scan was mapped yet; nothing is saved, so that no map is lost");
  }
  return {run.setup(), revision_of(run), run.snapshot(), Trajectory(run.in_map(run.path().poses())),
          Trajectory(run.in_map(run.odometry_path().poses()))};
}

void add_images(const std::string& path, const OccupancyGrid& shown, const std::string& picture,
                MapFormat format, FileReplacement& files) {
  for (const FileContents& file : map_files(path, make_map_image(shown), format)) {
    files.add(file);
  }
  files.add({path + ".png", picture});
}

void MapSaver::begin_from(const std::string& file, const MapRevision& now) {
  file_ = file;
  begun_ = now;
}

/// Whether the map went on from what the file holds.
bool MapSaver::is_own(const std::string& file, const MapRevision& now) const {
  return file_ == file && begun_.is_same_beginning(now);
}

/// What the file holds now stays beside it where the map did not go on from there.
void MapSaver::keep_other_map(const std::string& file, const MapRevision& now) const {
  if (is_own(file, now)) {
    return;
  }
  for (const auto& [held, kept] :
       {std::make_pair(file, file + ".1"),
        std::make_pair(path_of_changes(file), path_of_changes(file + ".1"))}) {
    if (std::filesystem::exists(held)) {
      keep_as(held, kept);
    }
  }
}

std::string MapSaver::save(const MapToSave& now) {
  return as_file_error([&] { return save_whole(now); });
}

std::string MapSaver::save_whole(const MapToSave& now) {
  const std::string path = path_of(now);
  const std::string file = path + ".slam";
  const MapFormat format = map_format(now.setup.run);
  // Each time: its folder may be cleared.
  require_writable_folder(std::filesystem::path(path).parent_path().string());
  FileReplacement files;
  const OccupancyGrid shown =
      shown_occupancy(now.map.map, now.map.key_scans.all(), now.setup.engine.map);
  add_images(
      path, shown,
      draw_map(shown, now.trajectory, now.odometry, graph_of(now.map.key_scans, now.map.loops))
          .to_png(),
      format, files);
  std::uintmax_t size = 0;
  MapPieces pieces;
  files.add(file, [&](const ByteSink& sink) {
    pieces = write_map_in_pieces(now.map, [&](const std::string& bytes) {
      size += bytes.size();
      sink(bytes);
    });
  });
  keep_other_map(file, now.revision);
  files.finish();
  if (!is_own(file, now.revision)) {
    begin_from(file, now.revision);
  }
  whole_.reset();  // until no changes of another one lie beside it
  std::filesystem::remove(path_of_changes(file));
  saved_ = now.revision;
  whole_ = WholeMap{std::move(pieces), size, 0, std::filesystem::last_write_time(file)};
  return fmt::format("{}{}, .yaml, .png and .slam", path,
                     format == MapFormat::kPng ? ".occupancy.png" : ".pgm");
}

/// Whether what has changed since the map was written as a whole could be written beside it.
bool MapSaver::can_add_changes(const MapToSave& now) const {
  const std::string file = path_of(now) + ".slam";
  std::error_code gone;
  return whole_ && is_own(file, now.revision) &&
         std::filesystem::file_size(file, gone) == whole_->size && !gone &&
         std::filesystem::last_write_time(file, gone) == whole_->written && !gone;
}

void MapSaver::save_changes(const MapToSave& now) {
  as_file_error([&] {
    if (can_add_changes(now)) {
      const std::string changes = changes_since(whole_->pieces, now.map);
      if (whole_->written_since + changes.size() < whole_->size) {
        replace_file(path_of_changes(file_), changes);
        whole_->written_since += changes.size();
        saved_ = now.revision;
        return;
      }
    }
    static_cast<void>(save_whole(now));
  });
}

}  // namespace matchbox_slam
