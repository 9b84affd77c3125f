#pragma once

#include <cairo.h>

#include <Eigen/Core>
#include <cstdint>
#include <memory>
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

/// Pixels in RGB, and antialiased drawing on them by Cairo. Coordinates are in pixels, x to the
/// right, y down; pixel (i, j) covers [i, i+1) x [j, j+1). Whatever lies outside is left out.
class Picture {
 public:
  /// @param width, height  [pixels], from 1 to 32767. Throws std::runtime_error for more.
  Picture(int width, int height, Color background);

  [[nodiscard]] int width() const;
  [[nodiscard]] int height() const;

  /// Unchecked.
  [[nodiscard]] Color color_at(int x, int y) const;

  /// Fills pixels from (left, top) up to but without (right, bottom).
  void fill(int left, int top, int right, int bottom, Color color);

  /// A line through `points`, everywhere of the same strength, also where it crosses itself. Points
  /// that are not finite, or more than 1e6 pixels away, are left out.
  void draw_line(const std::vector<Eigen::Vector2d>& points, const Stroke& stroke);

  void draw_disc(const Eigen::Vector2d& center, double radius, Color color);

  /// Text in a font that Cairo brings along, the same on every machine. It has the characters of
  /// ASCII; any other is drawn as '?'.
  /// @param middle  half the height of the small letters [pixels].
  /// @param size    of the font [pixels].
  void draw_text(double left, double middle, const std::string& text, double size, Color color);

  /// [pixels]
  [[nodiscard]] static double text_width(const std::string& text, double size);

  /// As a PNG file's bytes. Throws std::runtime_error when it fails.
  [[nodiscard]] std::string to_png() const;

 private:
  void use_color(Color color);

  struct Destroy {
    void operator()(cairo_surface_t* surface) const;
    void operator()(cairo_t* context) const;
  };
  std::unique_ptr<cairo_surface_t, Destroy> pixels_;
  std::unique_ptr<cairo_t, Destroy> context_;
};

}  // namespace matchbox_slam
