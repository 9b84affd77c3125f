#include "io/map_picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "io/map_style.hpp"
#include "io/scale_bar.hpp"

namespace matchbox_slam {
namespace {

/// Of several drives, one after the other and again; they differ in lightness, too.
constexpr std::array<Color, 6> kDriveColors{
    {{20, 95, 215}, {230, 120, 10}, {15, 130, 75}, {130, 50, 170}, {90, 180, 230}, {150, 90, 40}}};
constexpr double kLoopRadius = 3.4;
constexpr double kStartRadius = 6.0;

constexpr int kPleasantSize = 1400;      ///< small maps are drawn about this large [pixels]
constexpr int kLargestSize = 4000;       ///< [pixels]
constexpr int kLargestCell = 12;         ///< [pixels]
constexpr int kNarrowest = 760;          ///< [pixels], so that the legend fits
constexpr int kMargin = 12;              ///< around the map [pixels]
constexpr int kFooter = 28;              ///< for scale bar and legend [dots]
constexpr int kFontSize = 10;            ///< [dots]
constexpr double kScaleBarShare = 0.18;  ///< of the picture's width, at most

/// Which part of the map is shown, and where its cells and metres are in the picture.
class View {
 public:
  View(const CellBox& cells, const GridGeometry& geometry) : cells_(cells), geometry_(geometry) {
    const int longest = std::max(cells.width(), cells.height());
    pixels_per_cell_ = std::clamp(kPleasantSize / longest, 1, kLargestCell);
    cells_per_pixel_ = (longest + kLargestSize - 1) / kLargestSize;
    ink_ = std::max(1.0, static_cast<double>(std::max(map_width(), map_height())) / kPleasantSize);
    width_ = std::max(static_cast<int>(kNarrowest * ink_), map_width() + 2 * kMargin);
    left_ = (width_ - map_width()) / 2;
  }

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return map_height() + 2 * kMargin + footer_height(); }
  [[nodiscard]] int footer_height() const { return kFooter * dot(); }
  [[nodiscard]] int map_width() const { return pixels_for(cells_.width()); }
  [[nodiscard]] int map_height() const { return pixels_for(cells_.height()); }
  [[nodiscard]] int map_left() const { return left_; }
  [[nodiscard]] int map_top() const { return kMargin; }

  /// How much thicker than usual to draw: who looks at a large picture looks at it from afar.
  [[nodiscard]] double ink() const { return ink_; }

  /// What the footer is measured in [pixels].
  [[nodiscard]] int dot() const { return static_cast<int>(std::lround(2.0 * ink_)); }

  [[nodiscard]] Stroke scaled(const Stroke& stroke) const {
    return {stroke.color, ink_ * stroke.width, ink_ * stroke.dash};
  }

  [[nodiscard]] double pixels_per_metre() const {
    return static_cast<double>(pixels_per_cell_) / (cells_per_pixel_ * geometry_.resolution());
  }

  /// Edge of the squares, from the map's lower left pixel on, that show the same cells [pixels].
  [[nodiscard]] int square() const { return pixels_per_cell_; }

  /// The cells that a pixel of the map shows, counted from the map's lower left pixel.
  [[nodiscard]] CellBox cells_at(int right, int up) const {
    const Cell min{cells_.min.x + right / pixels_per_cell_ * cells_per_pixel_,
                   cells_.min.y + up / pixels_per_cell_ * cells_per_pixel_};
    return {min, {min.x + cells_per_pixel_, min.y + cells_per_pixel_}};
  }

  [[nodiscard]] Eigen::Vector2d to_picture(const Pose2& pose) const {
    const Eigen::Vector2d corner = geometry_.corner(cells_.min);
    return {left_ + (pose.x - corner.x()) * pixels_per_metre(),
            map_top() + map_height() - (pose.y - corner.y()) * pixels_per_metre()};
  }

 private:
  [[nodiscard]] int pixels_for(int cells) const {
    return (cells + cells_per_pixel_ - 1) / cells_per_pixel_ * pixels_per_cell_;
  }

  CellBox cells_;
  GridGeometry geometry_;
  int pixels_per_cell_;
  int cells_per_pixel_;
  double ink_;
  int width_;
  int left_;
};

/// The observed cells, grown to hold the trajectory.
CellBox shown_cells(const OccupancyGrid& map, const Trajectory& trajectory) {
  // Beyond this a pose is a mistake somewhere, and a picture of everything would show nothing.
  constexpr double kFarthest = 1.0e5;
  CellBox box = map.known_bounds();
  for (const StampedPose2& stamped : trajectory.poses()) {
    if (std::max(std::abs(stamped.pose.x), std::abs(stamped.pose.y)) > kFarthest) {
      continue;
    }
    box.include(map.geometry().cell_at(stamped.pose.translation()));
  }
  return box.empty() ? CellBox{{0, 0}, {1, 1}} : box;
}

/// Where one pixel shows several cells, a wall among them counts most: thin walls must not fade.
Color color_of(const OccupancyGrid& map, const CellBox& cells) {
  bool is_known = false;
  double highest = 0.0;
  for (int y = cells.min.y; y < cells.max.y; ++y) {
    for (int x = cells.min.x; x < cells.max.x; ++x) {
      if (map.is_known({x, y})) {
        is_known = true;
        highest = std::max(highest, map.occupancy({x, y}));
      }
    }
  }
  return is_known ? color_of_darkness(darkness_of(highest)) : kUnknownColor;
}

bool is_same(const Color& a, const Color& b) {
  return a.red == b.red && a.green == b.green && a.blue == b.blue;
}

void draw_cells(const OccupancyGrid& map, const View& view, Picture& picture) {
  // A trajectory may lead far out of the map, where it would take long to find nothing.
  const CellBox known = map.known_bounds();
  const int size = view.square();
  for (int up = 0; up < view.map_height(); up += size) {
    const int bottom = view.map_top() + view.map_height() - up;
    const auto fill = [&](int from, int to, const Color& color) {
      picture.fill(view.map_left() + from, bottom - size, view.map_left() + to, bottom, color);
    };
    int begin = 0;  // of squares of one colour side by side
    Color color;
    for (int right = 0; right < view.map_width(); right += size) {
      const Color here = color_of(map, intersection(view.cells_at(right, up), known));
      if (right > 0 && !is_same(here, color)) {
        fill(begin, right, color);
        begin = right;
      }
      color = here;
    }
    fill(begin, view.map_width(), color);
  }
}

std::vector<Eigen::Vector2d> line_of(const Trajectory& trajectory, const Pose2& map_from_frame,
                                     const View& view) {
  std::vector<Eigen::Vector2d> points;
  points.reserve(trajectory.size());
  for (const StampedPose2& stamped : trajectory.poses()) {
    points.push_back(view.to_picture(map_from_frame * stamped.pose));
  }
  return points;
}

void draw_start(const Eigen::Vector2d& center, double ink, Picture& picture) {
  picture.draw_disc(center, ink * (kStartRadius + 1.5), kFreeColor);
  picture.draw_disc(center, ink * kStartRadius, kStartColor);
}

/// Returns whether there is any.
bool draw_loops(const PoseGraph& graph, const View& view, Picture& picture) {
  bool has_loops = false;
  for (const PoseEdge& edge : graph.edges) {
    if (edge.kind == EdgeKind::kLoop && is_used(edge)) {
      const Eigen::Vector2d end = view.to_picture(graph.poses[edge.to]);
      picture.draw_line({view.to_picture(graph.poses[edge.from]), end}, view.scaled(kLoopStroke));
      picture.draw_disc(end, view.ink() * kLoopRadius, kLoopStroke.color);
      has_loops = true;
    }
  }
  return has_loops;
}

/// Draws the legend's entries from right to left, so that they end at the picture's edge.
class Legend {
 public:
  Legend(const View& view, int middle, Picture& picture)
      : view_(view), right_(view.width() - 2 * kMargin), middle_(middle), picture_(picture) {}

  void add_start() {
    const double radius = view_.ink() * kStartRadius;
    const int left = add_text("start", static_cast<int>(2.0 * radius));
    draw_start({left + radius, static_cast<double>(middle_)}, view_.ink(), picture_);
  }

  void add_line(const std::string& text, const Stroke& stroke) {
    const int sample = 18 * view_.dot();
    const int left = add_text(text, sample);
    const double y = middle_;
    picture_.draw_line({{left, y}, {left + sample, y}}, view_.scaled(stroke));
  }

 private:
  /// Returns where the symbol before the text begins.
  int add_text(const std::string& text, int symbol_width) {
    const int dot = view_.dot();
    const int size = kFontSize * dot;
    const int text_left = right_ - static_cast<int>(std::lround(Picture::text_width(text, size)));
    picture_.draw_text(text_left, middle_, text, size, kTextColor);
    const int symbol_left = text_left - 5 * dot - symbol_width;
    right_ = symbol_left - 12 * dot;
    return symbol_left;
  }

  const View& view_;
  int right_;
  int middle_;
  Picture& picture_;
};

/// With the scale bar.
Legend begin_footer(const View& view, Picture& picture) {
  const int top = view.height() - view.footer_height();
  const int middle = top + view.footer_height() / 2;
  picture.fill(0, top, view.width(), view.height(), kFreeColor);
  picture.fill(0, top, view.width(), top + 1, kRuleColor);
  draw_scale_bar({2 * kMargin, middle, kScaleBarShare * view.width(), view.pixels_per_metre(),
                  view.dot(), kFontSize * view.dot()},
                 picture);
  return {view, middle, picture};
}

void draw_footer(const View& view, bool has_trajectory, bool has_odometry, bool has_loops,
                 Picture& picture) {
  Legend legend = begin_footer(view, picture);
  if (has_trajectory) {
    legend.add_start();
    legend.add_line("corrected", kTrajectoryStroke);
  }
  if (has_loops) {
    legend.add_line("loop", kLoopStroke);
  }
  if (has_odometry) {
    legend.add_line("odometry", kOdometryStroke);
  }
}

}  // namespace

Picture draw_map(const OccupancyGrid& map, const Trajectory& trajectory, const Trajectory& odometry,
                 const PoseGraph& graph) {
  const View view(shown_cells(map, trajectory), map.geometry());
  Picture picture(view.width(), view.height(), kUnknownColor);
  draw_cells(map, view, picture);
  if (!odometry.empty()) {
    const Pose2 first = trajectory.empty() ? Pose2{} : trajectory.poses().front().pose;
    const Pose2 map_from_odom = first * odometry.poses().front().pose.inverse();
    picture.draw_line(line_of(odometry, map_from_odom, view), view.scaled(kOdometryStroke));
  }
  if (!trajectory.empty()) {
    picture.draw_line(line_of(trajectory, {}, view), view.scaled(kTrajectoryStroke));
    draw_start(view.to_picture(trajectory.poses().front().pose), view.ink(), picture);
  }
  const bool has_loops = draw_loops(graph, view, picture);
  draw_footer(view, !trajectory.empty(), !odometry.empty(), has_loops, picture);
  return picture;
}

Picture draw_drives(const OccupancyGrid& map, const std::vector<Trajectory>& drives,
                    const PoseGraph& graph) {
  const View view(shown_cells(map, {}), map.geometry());
  Picture picture(view.width(), view.height(), kUnknownColor);
  draw_cells(map, view, picture);
  const auto stroke_of = [](std::size_t drive) {
    return Stroke{kDriveColors[drive % kDriveColors.size()], kTrajectoryStroke.width, 0.0};
  };
  for (std::size_t i = 0; i < drives.size(); ++i) {
    if (!drives[i].empty()) {
      picture.draw_line(line_of(drives[i], {}, view), view.scaled(stroke_of(i)));
      draw_start(view.to_picture(drives[i].poses().front().pose), view.ink(), picture);
    }
  }
  const bool has_loops = draw_loops(graph, view, picture);
  Legend legend = begin_footer(view, picture);
  legend.add_start();
  if (has_loops) {
    legend.add_line("loop", kLoopStroke);
  }
  constexpr std::size_t kMostNamedDrives = 6;  // that the narrowest picture has room for
  for (std::size_t i = std::min(kMostNamedDrives, drives.size()); i-- > 0;) {
    if (!drives[i].empty()) {
      legend.add_line(std::to_string(i + 1), stroke_of(i));
    }
  }
  return picture;
}

PictureFrame frame_of_picture(const OccupancyGrid& map, const Trajectory& trajectory) {
  const View view(shown_cells(map, trajectory), map.geometry());
  return {view.pixels_per_metre(), view.to_picture({})};
}

}  // namespace matchbox_slam
