#include "io/picture.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "io/bitmap_font.hpp"

namespace matchbox_slam {
namespace {

constexpr int kChannels = 3;
constexpr double kFarthest = 1e9;  ///< [pixels], farther away steps of a pixel drown in rounding
constexpr int kGlyphAdvance = kGlyphWidth + 1;

struct Segment {
  Eigen::Vector2d from;
  Eigen::Vector2d to;
};

double distance_to(const Segment& segment, const Eigen::Vector2d& point) {
  const Eigen::Vector2d along = segment.to - segment.from;
  const double squared_length = along.squaredNorm();
  const double fraction =
      squared_length > 0.0
          ? std::clamp((point - segment.from).dot(along) / squared_length, 0.0, 1.0)
          : 0.0;
  return (segment.from + fraction * along - point).norm();
}

/// How much of each pixel a line covers. Gathered for the whole line before it is blended, so that
/// joints and crossings are not darker than the rest.
class Coverage {
 public:
  Coverage(int width, int height)
      : width_(width),
        height_(height),
        values_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {}

  /// Adds a short piece with round ends.
  void add(const Segment& piece, double half_width) {
    const double reach = half_width + 1.0;
    const int left = std::max(0, floor_to_int(std::min(piece.from.x(), piece.to.x()) - reach));
    const int right =
        std::min(width_ - 1, floor_to_int(std::max(piece.from.x(), piece.to.x()) + reach));
    const int top = std::max(0, floor_to_int(std::min(piece.from.y(), piece.to.y()) - reach));
    const int bottom =
        std::min(height_ - 1, floor_to_int(std::max(piece.from.y(), piece.to.y()) + reach));
    for (int y = top; y <= bottom; ++y) {
      for (int x = left; x <= right; ++x) {
        const double distance = distance_to(piece, {x + 0.5, y + 0.5});
        const double covered = std::clamp(half_width + 0.5 - distance, 0.0, 1.0);
        std::uint8_t& value = values_[index(x, y)];
        value = std::max(value, static_cast<std::uint8_t>(std::lround(255.0 * covered)));
      }
    }
  }

  [[nodiscard]] double at(int x, int y) const { return values_[index(x, y)] / 255.0; }

 private:
  static int floor_to_int(double value) { return static_cast<int>(std::floor(value)); }

  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(x);
  }

  int width_;
  int height_;
  std::vector<std::uint8_t> values_;
};

/// The fractions of the segment between which it is inside the box from 0 to `size`, widened by
/// `margin`, by Liang and Barsky (1984). A trajectory may run off much farther than one can draw.
std::optional<std::pair<double, double>> clip(const Segment& segment, const Eigen::Vector2d& size,
                                              double margin) {
  double enter = 0.0;
  double leave = 1.0;
  const Eigen::Vector2d along = segment.to - segment.from;
  for (int axis = 0; axis < 2; ++axis) {
    const double low = -margin - segment.from[axis];
    const double high = size[axis] + margin - segment.from[axis];
    if (along[axis] == 0.0) {
      if (low > 0.0 || high < 0.0) {
        return std::nullopt;
      }
      continue;
    }
    const auto [first, last] = std::minmax({low / along[axis], high / along[axis]});
    enter = std::max(enter, first);
    leave = std::min(leave, last);
  }
  if (enter > leave) {
    return std::nullopt;
  }
  return std::make_pair(enter, leave);
}

/// Draws one segment of a line in short pieces.
/// @param start  length of the line before the segment [pixels], which decides where dashes are.
void add_segment(const Segment& segment, double start, const Stroke& stroke,
                 const Eigen::Vector2d& size, Coverage& coverage) {
  const auto inside = clip(segment, size, stroke.width + 2.0);
  if (!inside) {
    return;
  }
  const double length = (segment.to - segment.from).norm();
  const double period = 2.0 * stroke.dash;
  const double longest_piece = 8.0;
  double at = inside->first * length;
  const double end = inside->second * length;
  do {
    double next = std::min(end, at + longest_piece);
    bool is_drawn = true;
    if (stroke.dash > 0.0) {
      const double phase = std::fmod(start + at, period);
      is_drawn = phase < stroke.dash;
      const double until = is_drawn ? stroke.dash - phase : period - phase;
      next = std::min(next, at + std::max(until, 1e-3));
    }
    if (is_drawn) {
      const auto point = [&](double distance) -> Eigen::Vector2d {
        return segment.from +
               (length > 0.0 ? distance / length : 0.0) * (segment.to - segment.from);
      };
      coverage.add({point(at), point(next)}, 0.5 * stroke.width);
    }
    at = next;
  } while (at < end);
}

std::uint8_t mix(std::uint8_t under, std::uint8_t over, double opacity) {
  return static_cast<std::uint8_t>(std::lround(under + opacity * (over - under)));
}

}  // namespace

Picture::Picture(int width, int height, Color background)
    : width_(width),
      height_(height),
      bytes_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * kChannels) {
  fill(0, 0, width, height, background);
}

Color Picture::color_at(int x, int y) const {
  const std::size_t at = (static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                          static_cast<std::size_t>(x)) *
                         kChannels;
  return {bytes_[at], bytes_[at + 1], bytes_[at + 2]};
}

void Picture::fill(int left, int top, int right, int bottom, Color color) {
  for (int y = std::max(0, top); y < std::min(height_, bottom); ++y) {
    for (int x = std::max(0, left); x < std::min(width_, right); ++x) {
      blend(x, y, color, 1.0);
    }
  }
}

void Picture::draw_line(const std::vector<Eigen::Vector2d>& points, const Stroke& stroke) {
  Coverage coverage(width_, height_);
  const Eigen::Vector2d size(width_, height_);
  std::optional<Eigen::Vector2d> last;
  double length = 0.0;
  for (const Eigen::Vector2d& point : points) {
    if (!(point.array().abs() <= kFarthest).all()) {  // NaN too
      continue;
    }
    if (last) {
      add_segment({*last, point}, length, stroke, size, coverage);
      length += (point - *last).norm();
    }
    last = point;
  }
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      blend(x, y, stroke.color, coverage.at(x, y));
    }
  }
}

void Picture::draw_disc(const Eigen::Vector2d& center, double radius, Color color) {
  const auto floor_to_int = [](double value) { return static_cast<int>(std::floor(value)); };
  const int left = std::max(0, floor_to_int(center.x() - radius - 1.0));
  const int right = std::min(width_ - 1, floor_to_int(center.x() + radius + 1.0));
  const int top = std::max(0, floor_to_int(center.y() - radius - 1.0));
  const int bottom = std::min(height_ - 1, floor_to_int(center.y() + radius + 1.0));
  for (int y = top; y <= bottom; ++y) {
    for (int x = left; x <= right; ++x) {
      const double distance = (Eigen::Vector2d(x + 0.5, y + 0.5) - center).norm();
      blend(x, y, color, std::clamp(radius + 0.5 - distance, 0.0, 1.0));
    }
  }
}

void Picture::draw_text(int left, int top, const std::string& text, int scale, Color color) {
  for (const char character : text) {
    const Glyph& glyph = glyph_of(character);
    for (int row = 0; row < kGlyphHeight; ++row) {
      for (int column = 0; column < kGlyphWidth; ++column) {
        const int bit = kGlyphWidth - 1 - column;
        if ((glyph[static_cast<std::size_t>(row)] >> bit & 1) != 0) {
          const int x = left + column * scale;
          const int y = top + row * scale;
          fill(x, y, x + scale, y + scale, color);
        }
      }
    }
    left += kGlyphAdvance * scale;
  }
}

int Picture::text_width(const std::string& text, int scale) {
  return text.empty() ? 0 : (static_cast<int>(text.size()) * kGlyphAdvance - 1) * scale;
}

void Picture::blend(int x, int y, Color color, double opacity) {
  if (opacity <= 0.0) {
    return;
  }
  std::uint8_t* pixel = &bytes_[(static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                                 static_cast<std::size_t>(x)) *
                                kChannels];
  pixel[0] = mix(pixel[0], color.red, opacity);
  pixel[1] = mix(pixel[1], color.green, opacity);
  pixel[2] = mix(pixel[2], color.blue, opacity);
}

}  // namespace matchbox_slam
