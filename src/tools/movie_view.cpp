#include "tools/movie_view.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "io/map_style.hpp"
#include "io/scale_bar.hpp"
#include "tools/movie_map.hpp"

namespace matchbox_slam {
namespace {

constexpr int kMovieMargin = 8;       // around the map [pixels]
constexpr int kMovieFooter = 24;      // [pixels]
constexpr int kMovieFont = 13;        // [pixels]
constexpr int kNarrowestMovie = 360;  // [pixels], so that the caption fits
constexpr int kLargestMovieCell = 8;  // [pixels]
constexpr double kRobotRadius = 5.0;  // [pixels]
constexpr Stroke kMoviePath{kTrajectoryStroke.color, 1.6, 0.0};
constexpr Stroke kMovieLoop{kLoopStroke.color, 1.6, 0.0};
constexpr Color kOtherColor = kOdometryStroke.color;

static_assert(MovieMap::kMostCells + 2 * kMovieMargin + kMovieFooter <= MovieView::kMostPixels);

/// Adds what a frame shows, in cells of a level.
void include_frame(const MovieFrame& frame, int level, const GridGeometry& geometry, CellBox& box) {
  // Beyond this a pose is a mistake somewhere, and a movie of everything would show nothing.
  constexpr float kFarthest = 1.0e5F;
  const int coarser = level - frame.level;
  const CellBox& map = frame.map.cells();
  if (!map.empty()) {
    box.include({map.min.x >> coarser, map.min.y >> coarser});
    box.include({(map.max.x - 1) >> coarser, (map.max.y - 1) >> coarser});
  }
  for (const auto& piece : frame.path) {
    for (const MovieFrame::Point& point : piece) {
      if (point.cwiseAbs().maxCoeff() <= kFarthest) {
        box.include(geometry.cell_at(point.cast<double>()));
      }
    }
  }
}

int even(int number) { return number + number % 2; }

std::string count_text(std::size_t count, const std::string& what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

/// Also for those who count in minutes.
std::string time_text(double seconds) {
  const auto whole = static_cast<long>(seconds);
  return fmt::format("{}:{:02}", whole / 60, whole % 60);
}

}  // namespace

MovieView::MovieView(const std::vector<MovieFrame>& frames, double finest_resolution)
    : finest_resolution_(finest_resolution) {
  for (const MovieFrame& frame : frames) {
    level_ = std::max(level_, frame.level);
  }
  fit(frames);
  while (std::max(cells_.width(), cells_.height()) > MovieMap::kMostCells) {
    ++level_;
    fit(frames);
  }
  const int longest = std::max(cells_.width(), cells_.height());
  pixels_per_cell_ = std::clamp(MovieMap::kMostCells / longest, 1, kLargestMovieCell);
  const int map_width = pixels_per_cell_ * cells_.width();
  width_ = even(std::max(kNarrowestMovie, map_width + 2 * kMovieMargin));
  height_ = even(pixels_per_cell_ * cells_.height() + 2 * kMovieMargin + kMovieFooter);
  left_ = (width_ - map_width) / 2;
}

void MovieView::fit(const std::vector<MovieFrame>& frames) {
  const GridGeometry geometry(std::ldexp(finest_resolution_, level_));
  cells_ = {};
  for (const MovieFrame& frame : frames) {
    include_frame(frame, level_, geometry, cells_);
  }
  if (cells_.empty()) {
    cells_ = {{0, 0}, {1, 1}};
  }
}

Eigen::Vector2d MovieView::to_picture(const Eigen::Vector2d& point) const {
  const Eigen::Vector2d cells = point / std::ldexp(finest_resolution_, level_);
  return {left_ + pixels_per_cell_ * (cells.x() - cells_.min.x),
          kMovieMargin + pixels_per_cell_ * (cells_.max.y - cells.y())};
}

void MovieView::draw_cells(const MovieFrame& frame, Picture& picture) const {
  const auto width = static_cast<std::size_t>(cells_.width());
  std::vector<Shade> shades(width * static_cast<std::size_t>(cells_.height()), kUnseenShade);
  const int coarser = level_ - frame.level;
  // Of cells that become one the darkest counts: thin walls must not fade.
  frame.map.for_each_run([&](int y, int from, int to, Shade shade) {
    const auto row = static_cast<std::size_t>((y >> coarser) - cells_.min.y) * width;
    const int last = ((to - 1) >> coarser) - cells_.min.x;
    for (int x = (from >> coarser) - cells_.min.x; x <= last; ++x) {
      Shade& drawn = shades[row + static_cast<std::size_t>(x)];
      drawn = std::max(drawn, shade);
    }
  });
  const int size = pixels_per_cell_;
  for (int y = 0; y < cells_.height(); ++y) {
    const auto row = shades.begin() + static_cast<std::ptrdiff_t>(y) * cells_.width();
    const int bottom = kMovieMargin + size * (cells_.height() - y);
    for (int x = 0; x < cells_.width();) {
      const auto end =
          std::find_if(row + x, row + cells_.width(), [&](Shade shade) { return shade != row[x]; });
      const auto next = static_cast<int>(end - row);
      if (row[x] != kUnseenShade) {
        picture.fill(left_ + size * x, bottom - size, left_ + size * next, bottom,
                     color_of_shade(row[x]));
      }
      x = next;
    }
  }
}

void MovieView::draw_paths(const MovieFrame& frame, Picture& picture) const {
  std::vector<Eigen::Vector2d> line;
  for (const auto& piece : frame.path) {
    line.clear();
    for (const MovieFrame::Point& point : piece) {
      line.push_back(to_picture(point.cast<double>()));
    }
    if (&piece == &frame.path.back() && frame.robot) {
      line.push_back(to_picture(frame.robot->translation()));
    }
    picture.draw_line(line, kMoviePath);
  }
  for (const auto& [from, to] : frame.loops) {
    const Eigen::Vector2d end = to_picture(to.cast<double>());
    picture.draw_line({to_picture(from.cast<double>()), end}, kMovieLoop);
    picture.draw_disc(end, 1.5 * kMovieLoop.width, kMovieLoop.color);
  }
}

void MovieView::draw_robot(const Pose2& pose, double radius, const Color& color,
                           Picture& picture) const {
  const Eigen::Vector2d center = to_picture(pose.translation());
  const Eigen::Vector2d ahead =
      center + 2.2 * radius * Eigen::Vector2d(std::cos(pose.theta), -std::sin(pose.theta));
  picture.draw_disc(center, radius + 1.5, kFreeColor);
  picture.draw_line({center, ahead}, {kFreeColor, 5.5, 0.0});
  picture.draw_line({center, ahead}, {color, 2.5, 0.0});
  picture.draw_disc(center, radius, color);
}

void MovieView::draw_robots(const MovieFrame& frame, Picture& picture) const {
  for (const WeightedPose& other : frame.others) {
    draw_robot(other.map_from_base, kRobotRadius * (0.5 + 0.5 * std::sqrt(other.weight)),
               kOtherColor, picture);
  }
  if (frame.robot) {
    draw_robot(*frame.robot, kRobotRadius, kTrajectoryStroke.color, picture);
  }
}

void MovieView::draw_caption(const MovieFrame& frame, Picture& picture) const {
  const int top = height_ - kMovieFooter;
  const int middle = top + kMovieFooter / 2;
  picture.fill(0, top, width_, height_, kFreeColor);
  picture.fill(0, top, width_, top + 1, kRuleColor);
  const double pixels_per_metre = pixels_per_cell_ / std::ldexp(finest_resolution_, level_);
  draw_scale_bar({kMovieMargin, middle, 0.2 * width_, pixels_per_metre, 1, kMovieFont}, picture);
  std::string text = time_text(frame.time);
  if (!frame.loops.empty()) {
    text = fmt::format("{}, {}", count_text(frame.loops.size(), "loop"), text);
  }
  if (frame.state != TrackingState::kTracking) {
    text = fmt::format("{}, {}", to_string(frame.state), text);
  }
  picture.draw_text(width_ - kMovieMargin - Picture::text_width(text, kMovieFont), middle, text,
                    kMovieFont, kTextColor);
}

Picture MovieView::draw(const MovieFrame& frame) const {
  Picture picture(width_, height_, kUnknownColor);
  draw_cells(frame, picture);
  draw_paths(frame, picture);
  draw_robots(frame, picture);
  draw_caption(frame, picture);
  return picture;
}

std::vector<Color> MovieView::main_colors() {
  std::vector<Color> colors = {kTextColor, kRuleColor, kMoviePath.color, kMovieLoop.color,
                               kOtherColor};
  for (int shade = kUnseenShade; shade <= kDarkestShade; ++shade) {
    colors.push_back(color_of_shade(static_cast<Shade>(shade)));
  }
  return colors;
}

}  // namespace matchbox_slam
