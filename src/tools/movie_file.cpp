#include "tools/movie_file.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <system_error>
#include <utility>

#include "matchbox_slam/common/options.hpp"
#include "tools/gif_file.hpp"
#include "tools/movie_view.hpp"

namespace matchbox_slam {
namespace {

constexpr int kFrameHundredths = 10;  // that each is shown [0.01 s]
constexpr int kLastFrameHundredths = 300;

std::string lower_extension(const std::string& name) {
  std::string extension = std::filesystem::path(name).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

/// A folder may have a point in its name; but who writes one of these wants something else.
bool is_other_film(const std::string& extension) {
  constexpr std::array kOtherExtensions = {".apng", ".avi", ".m4v", ".mkv",  ".mov",  ".mp4",
                                           ".mpeg", ".mpg", ".ogv", ".webm", ".webp", ".png"};
  return std::find(kOtherExtensions.begin(), kOtherExtensions.end(), extension) !=
         kOtherExtensions.end();
}

}  // namespace

MovieFile::MovieFile(std::string name)
    : name_(std::move(name)), is_gif_(lower_extension(name_) == ".gif") {
  if (name_.empty() || is_other_film(lower_extension(name_))) {
    throw ConfigurationError(
        fmt::format("--movie: '{}' is not allowed; allowed: a name that ends in .gif, or a folder "
                    "for PNGs, of which ffmpeg makes other films (doc/first_map.md)",
                    name_));
  }
}

void MovieFile::require_writable() const {
  if (!is_gif_) {
    require_writable_folder(name_);
    return;
  }
  if (const std::filesystem::path folder = std::filesystem::path(name_).parent_path();
      !folder.empty()) {
    require_writable_folder(folder.string());
  }
  require_writable_file(name_);
}

std::string MovieFile::frame_path(std::size_t number) const {
  return fmt::format("{}/frame_{:03}.png", name_, number);
}

void MovieFile::add(const std::vector<MovieFrame>& frames, double finest_resolution,
                    FileReplacement& files) const {
  const MovieView view(frames, finest_resolution);
  if (!is_gif_) {
    for (std::size_t i = 0; i < frames.size(); ++i) {
      files.add({frame_path(i), view.draw(frames[i]).to_png()});
    }
    return;
  }
  files.add(name_, [&](const ByteSink& sink) {
    GifFile gif(view.width(), view.height(), MovieView::main_colors(), sink);
    for (const MovieFrame& frame : frames) {
      gif.add(view.draw(frame), &frame == &frames.back() ? kLastFrameHundredths : kFrameHundredths);
    }
    gif.finish();
  });
}

void MovieFile::remove_older(const std::vector<MovieFrame>& frames) const {
  std::error_code ignored;
  for (std::size_t i = frames.size(); !is_gif_ && std::filesystem::remove(frame_path(i), ignored);
       ++i) {
  }
}

}  // namespace matchbox_slam
