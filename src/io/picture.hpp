#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace matchbox_slam {

struct Color {
  std::uint8_t red = 0;
  std::uint8_t green = 0;
  std::uint8_t blue = 0;
};

/// How a line is drawn. With `dash` > 0 it is broken into dashes and gaps of that length.
struct Stroke {
  Color color;
  double width = 1.0;  ///< [pixels]
  double dash = 0.0;   ///< [pixels]
};

/// Pixels in RGB, and antialiased drawing on them. Coordinates are in pixels, x to the right, y
/// down; pixel (i, j) covers [i, i+1) x [j, j+1). Whatever lies outside is left out.
class Picture {
 public:
  /// @param width, height  [pixels], > 0.
  Picture(int width, int height, Color background);

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }

  /// Three bytes a pixel, row by row from the top.
  [[nodiscard]] const std::vector<std::uint8_t>& bytes() const { return bytes_; }

  /// Unchecked.
  [[nodiscard]] Color color_at(int x, int y) const;

  /// Fills pixels from (left, top) up to but without (right, bottom).
  void fill(int left, int top, int right, int bottom, Color color);

  /// A line through `points`, everywhere of the same strength, also where it crosses itself. Points
  /// that are not finite, or more than 1e9 pixels away, are left out.
  void draw_line(const std::vector<Eigen::Vector2d>& points, const Stroke& stroke);

  void draw_disc(const Eigen::Vector2d& center, double radius, Color color);

  /// Text in a built-in font of a-z, 0-9, '.' and '-'; other characters are blank.
  /// @param top_left  corner of the first character's cell [pixels].
  /// @param scale     pixels a dot of the font.
  void draw_text(int left, int top, const std::string& text, int scale, Color color);

  /// [pixels]
  [[nodiscard]] static int text_width(const std::string& text, int scale);

 private:
  void blend(int x, int y, Color color, double opacity);

  int width_;
  int height_;
  std::vector<std::uint8_t> bytes_;
};

/// The picture as a PNG file's bytes. Throws std::runtime_error when libpng fails.
[[nodiscard]] std::string encode_png(const Picture& picture);

}  // namespace matchbox_slam
