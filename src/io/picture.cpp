#include "io/picture.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "io/png_image.hpp"

namespace matchbox_slam {
namespace {

/// Cairo counts in 24 bits before the point, where lines through farther points would wrap around.
constexpr double kFarthestPixel = 1e6;  ///< [pixels]

void require_success(cairo_status_t status, const std::string& work) {
  if (status != CAIRO_STATUS_SUCCESS) {
    throw std::runtime_error(fmt::format("cannot {}: {}", work, cairo_status_to_string(status)));
  }
}

std::uint32_t* row_of(cairo_surface_t* pixels, int y) {
  unsigned char* row = cairo_image_surface_get_data(pixels) +
                       static_cast<std::ptrdiff_t>(y) * cairo_image_surface_get_stride(pixels);
  return reinterpret_cast<std::uint32_t*>(row);  // as CAIRO_FORMAT_RGB24 is defined
}

std::string ascii(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return text;
}

}  // namespace

void Picture::Destroy::operator()(cairo_surface_t* surface) const {
  cairo_surface_destroy(surface);
}

void Picture::Destroy::operator()(cairo_t* context) const { cairo_destroy(context); }

Picture::Picture(int width, int height, Color background)
    : pixels_(cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height)),
      context_(cairo_create(pixels_.get())) {
  require_success(cairo_status(context_.get()),
                  fmt::format("draw a picture of {} x {} pixels", width, height));
  cairo_select_font_face(context_.get(), "@cairo:", CAIRO_FONT_SLANT_NORMAL,
                         CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_line_cap(context_.get(), CAIRO_LINE_CAP_ROUND);
  cairo_set_line_join(context_.get(), CAIRO_LINE_JOIN_ROUND);
  fill(0, 0, width, height, background);
}

int Picture::width() const { return cairo_image_surface_get_width(pixels_.get()); }

int Picture::height() const { return cairo_image_surface_get_height(pixels_.get()); }

Color Picture::color_at(int x, int y) const {
  cairo_surface_flush(pixels_.get());
  const std::uint32_t pixel = row_of(pixels_.get(), y)[x];
  return {static_cast<std::uint8_t>(pixel >> 16), static_cast<std::uint8_t>(pixel >> 8),
          static_cast<std::uint8_t>(pixel)};
}

void Picture::fill(int left, int top, int right, int bottom, Color color) {
  // Not by Cairo, which takes far longer where every pixel of a map is filled by itself.
  left = std::max(0, left);
  right = std::max(left, std::min(width(), right));
  const std::uint32_t pixel = static_cast<std::uint32_t>(color.red) << 16 |
                              static_cast<std::uint32_t>(color.green) << 8 | color.blue;
  cairo_surface_flush(pixels_.get());
  for (int y = std::max(0, top); y < std::min(height(), bottom); ++y) {
    std::uint32_t* row = row_of(pixels_.get(), y);
    std::fill(row + left, row + right, pixel);
  }
  cairo_surface_mark_dirty(pixels_.get());
}

void Picture::draw_line(const std::vector<Eigen::Vector2d>& points, const Stroke& stroke) {
  constexpr std::size_t kPiece = 10'000;  // points of a path, of which Cairo takes 450 bytes each
  use_color(stroke.color);
  cairo_set_line_width(context_.get(), stroke.width);
  double length = 0.0;  // of the pieces before
  const auto draw_path = [&](double piece) {
    cairo_set_dash(context_.get(), &stroke.dash, stroke.dash > 0.0 ? 1 : 0, length);
    cairo_stroke(context_.get());
    length += piece;
  };
  std::size_t count = 0;
  double piece = 0.0;
  Eigen::Vector2d last = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& point : points) {
    if (!(point.array().abs() <= kFarthestPixel).all()) {  // never for NaN
      continue;
    }
    cairo_line_to(context_.get(), point.x(), point.y());
    piece += count > 0 ? (point - last).norm() : 0.0;
    last = point;
    if (++count % kPiece == 0) {
      draw_path(std::exchange(piece, 0.0));
      cairo_move_to(context_.get(), point.x(), point.y());
    }
  }
  draw_path(piece);
}

void Picture::draw_disc(const Eigen::Vector2d& center, double radius, Color color) {
  draw_line({center, center}, {color, 2.0 * radius, 0.0});
}

void Picture::draw_text(double left, double middle, const std::string& text, double size,
                        Color color) {
  use_color(color);
  cairo_set_font_size(context_.get(), size);
  cairo_text_extents_t letter;
  cairo_text_extents(context_.get(), "x", &letter);
  cairo_move_to(context_.get(), left, middle - letter.y_bearing - 0.5 * letter.height);
  cairo_show_text(context_.get(), ascii(text).c_str());
  cairo_new_path(context_.get());
}

double Picture::text_width(const std::string& text, double size) {
  const Picture scratch(1, 1, {});
  cairo_set_font_size(scratch.context_.get(), size);
  cairo_text_extents_t extents;
  cairo_text_extents(scratch.context_.get(), ascii(text).c_str(), &extents);
  return extents.x_advance;
}

std::string Picture::to_png() const {
  cairo_surface_flush(pixels_.get());
  std::vector<std::uint8_t> samples(std::size_t{3} * static_cast<std::size_t>(width()) *
                                    static_cast<std::size_t>(height()));
  auto sample = samples.begin();
  for (int y = 0; y < height(); ++y) {
    const std::uint32_t* row = row_of(pixels_.get(), y);
    for (const std::uint32_t* pixel = row; pixel != row + width(); ++pixel) {
      *sample++ = static_cast<std::uint8_t>(*pixel >> 16);
      *sample++ = static_cast<std::uint8_t>(*pixel >> 8);
      *sample++ = static_cast<std::uint8_t>(*pixel);
    }
  }
  return drawn_png(width(), height(), samples);
}

void Picture::use_color(Color color) {
  cairo_set_source_rgb(context_.get(), color.red / 255.0, color.green / 255.0, color.blue / 255.0);
}

}  // namespace matchbox_slam
