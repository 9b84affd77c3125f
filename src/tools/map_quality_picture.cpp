#include "tools/map_quality_picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace matchbox_slam {
namespace {

constexpr Color kPaperColor = {255, 255, 255};
constexpr Color kTextColor = {60, 64, 70};
constexpr Color kFreeColor = {255, 255, 255};
constexpr Color kUnknownColor = {222, 224, 228};
constexpr Color kOccupiedColor = {40, 44, 52};
constexpr Color kCornerColor = {214, 39, 40};
/// Neighbouring areas are to differ: light, so that walls and corners stay clear.
constexpr std::array<Color, 6> kAreaColors = {{{166, 206, 227},
                                               {178, 223, 138},
                                               {253, 191, 111},
                                               {202, 178, 214},
                                               {255, 255, 153},
                                               {141, 211, 199}}};

constexpr int kMargin = 8;          ///< [pixels]
constexpr double kFontSize = 18.0;  ///< [pixels]
constexpr int kLineHeight = 24;     ///< [pixels]
constexpr int kFooterHeight = 2 * kLineHeight + kMargin;
constexpr int kWantedHeight = 800;  ///< [pixels] of the highest map; small ones are enlarged to it
constexpr double kCornerRadius = 3.5;  ///< [pixels]

Color color_of(CellState state) {
  switch (state) {
    case CellState::kOccupied:
      return kOccupiedColor;
    case CellState::kFree:
      return kFreeColor;
    case CellState::kUnknown:
      break;
  }
  return kUnknownColor;
}

/// One map's place in the picture.
struct Frame {
  int left = 0;
  int top = 0;
  int map_height = 0;  ///< [cells]
  int scale = 1;       ///< [pixels] a cell

  void fill(const Cell& cell, Color color, Picture& picture) const {
    const int x = left + cell.x * scale;
    const int y = top + (map_height - 1 - cell.y) * scale;
    picture.fill(x, y, x + scale, y + scale, color);
  }

  [[nodiscard]] Eigen::Vector2d to_picture(const Eigen::Vector2d& cells) const {
    return {left + cells.x() * scale, top + (map_height - cells.y()) * scale};
  }
};

std::vector<std::string> caption_of(const MeasuredMap& measured) {
  return {measured.name, "corners " + std::to_string(measured.quality.corners.size()) + "  areas " +
                             std::to_string(measured.quality.enclosed_areas.size())};
}

void draw_cells(const MeasuredMap& measured, const Frame& frame, Picture& picture) {
  for (int y = 0; y < measured.map.height; ++y) {
    for (int x = 0; x < measured.map.width; ++x) {
      frame.fill({x, y}, color_of(measured.map.state({x, y})), picture);
    }
  }
  std::size_t number = 0;
  for (const EnclosedArea& area : measured.quality.enclosed_areas) {
    for (const Cell& cell : area) {
      if (measured.map.state(cell) != CellState::kOccupied) {  // specks within it stay to be seen
        frame.fill(cell, kAreaColors[number % kAreaColors.size()], picture);
      }
    }
    ++number;
  }
}

void draw(const MeasuredMap& measured, const Frame& frame, int caption_top, Picture& picture) {
  draw_cells(measured, frame, picture);
  for (const Eigen::Vector2d& corner : measured.quality.corners) {
    picture.draw_disc(frame.to_picture(corner), kCornerRadius, kCornerColor);
  }
  for (const std::string& line : caption_of(measured)) {
    picture.draw_text(frame.left, caption_top + 0.4 * kLineHeight, line, kFontSize, kTextColor);
    caption_top += kLineHeight;
  }
}

/// Of a map with its caption [pixels].
int column_width(const MeasuredMap& measured, int scale) {
  int width = measured.map.width * scale;
  for (const std::string& line : caption_of(measured)) {
    width = std::max(width, static_cast<int>(std::ceil(Picture::text_width(line, kFontSize))));
  }
  return width;
}

}  // namespace

Picture draw_map_qualities(const std::vector<MeasuredMap>& maps) {
  int highest = 0;
  for (const MeasuredMap& measured : maps) {
    highest = std::max(highest, measured.map.height);
  }
  const int scale = std::clamp(kWantedHeight / highest, 1, 16);
  int width = kMargin;
  for (const MeasuredMap& measured : maps) {
    width += column_width(measured, scale) + kMargin;
  }
  const int caption_top = highest * scale + 2 * kMargin;
  Picture picture(width, caption_top + kFooterHeight, kPaperColor);
  int left = kMargin;
  for (const MeasuredMap& measured : maps) {
    draw(measured, {left, kMargin, measured.map.height, scale}, caption_top, picture);
    left += column_width(measured, scale) + kMargin;
  }
  return picture;
}

}  // namespace matchbox_slam
