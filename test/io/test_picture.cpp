#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <sstream>
#include <vector>

#include "common/error_text.hpp"
#include "io/picture.hpp"
#include "matchbox_slam/geometry/angles.hpp"

namespace matchbox_slam {
namespace {

constexpr Color kWhite{255, 255, 255};
constexpr Color kBlack{0, 0, 0};

int darkness(const Picture& picture, int x, int y) { return 255 - picture.color_at(x, y).green; }

/// Sum over all pixels, in pixels that are wholly dark.
double ink(const Picture& picture) {
  double sum = 0.0;
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      sum += darkness(picture, x, y) / 255.0;
    }
  }
  return sum;
}

TEST(Picture, FillsUpToButWithoutTheLastPixel) {
  Picture picture(5, 4, kWhite);
  picture.fill(1, 2, 3, 3, kBlack);
  EXPECT_EQ(darkness(picture, 1, 2), 255);
  EXPECT_EQ(darkness(picture, 2, 2), 255);
  EXPECT_EQ(ink(picture), 2.0);
  picture.fill(-10, -10, 100, 100, kBlack);
  EXPECT_EQ(ink(picture), 20.0);
}

TEST(Picture, LineCoversItsWidthEverywhereTheSame) {
  Picture picture(60, 40, kWhite);
  picture.draw_line({{10, 10}, {50, 10}}, {kBlack, 4.0, 0.0});
  EXPECT_EQ(darkness(picture, 30, 8), 255);
  EXPECT_EQ(darkness(picture, 30, 11), 255);
  EXPECT_EQ(darkness(picture, 30, 6), 0);
  EXPECT_EQ(darkness(picture, 30, 13), 0);
  EXPECT_NEAR(ink(picture), 40.0 * 4.0 + 4.0 * kPi, 3.0);
}

TEST(Picture, ALineThatComesBackIsNotDarker) {
  Picture picture(40, 40, kWhite);
  picture.draw_line({{5.5, 20.5}, {35.5, 20.5}, {15.5, 20.5}}, {kBlack, 0.5, 0.0});
  const int single = darkness(picture, 10, 20);
  EXPECT_NEAR(single, 128, 10);
  EXPECT_EQ(darkness(picture, 25, 20), single);
}

TEST(Picture, DashesLeaveHalfOfTheLineOut) {
  Picture picture(220, 20, kWhite);
  picture.draw_line({{10, 10}, {90, 10}, {210, 10}}, {kBlack, 1.0, 10.0});
  EXPECT_GT(darkness(picture, 15, 10), 100);
  EXPECT_EQ(darkness(picture, 25, 10), 0);
  EXPECT_GT(darkness(picture, 95, 10), 100);
  EXPECT_EQ(darkness(picture, 105, 10), 0);
}

TEST(Picture, ALineOfManyPointsIsDrawnAsOneOfFew) {
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i <= 25'000; ++i) {
    points.emplace_back(10.0 + 0.008 * i, 10.0);
  }
  for (const double dash : {0.0, 7.0}) {
    Picture many(220, 20, kWhite);
    Picture few(220, 20, kWhite);
    many.draw_line(points, {kBlack, 4.0, dash});
    few.draw_line({{10, 10}, {210, 10}}, {kBlack, 4.0, dash});
    for (int x = 0; x < 220; ++x) {
      EXPECT_NEAR(darkness(many, x, 10), darkness(few, x, 10), 2) << dash << " " << x;
    }
  }
}

TEST(Picture, DrawsOnlyWhatIsInsideHoweverFarALineLeads) {
  Picture picture(20, 20, kWhite);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  picture.draw_line({{-1e6, 10.0}, {nan, 3.0}, {10.0, nan}, {1e18, 3.0}, {1e6, 10.0}},
                    {kBlack, 2.0, 0.0});
  EXPECT_EQ(ink(picture), 40.0);
  picture.draw_line({{-50, -50}, {-50, 90}}, {kBlack, 2.0, 0.0});
  picture.draw_line({{1e6, 1e6}, {2e9, 1e9}}, {kBlack, 2.0, 5.0});
  picture.draw_line({}, {kBlack, 2.0, 0.0});
  EXPECT_EQ(ink(picture), 40.0);
}

TEST(Picture, DiscHasItsArea) {
  Picture picture(40, 40, kWhite);
  picture.draw_disc({20, 20}, 10.0, kBlack);
  EXPECT_NEAR(ink(picture), 100.0 * kPi, 2.0);
  picture.draw_disc({1000, -1000}, 5.0, kBlack);
  EXPECT_NEAR(ink(picture), 100.0 * kPi, 2.0);
}

/// Where there is ink.
struct DarkPart {
  int left = 1000;
  int right = -1;
  int top = 1000;
  int bottom = -1;
};

DarkPart dark_part_of(const Picture& picture) {
  DarkPart extent;
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      if (darkness(picture, x, y) > 0) {
        extent = {std::min(extent.left, x), std::max(extent.right, x), std::min(extent.top, y),
                  std::max(extent.bottom, y)};
      }
    }
  }
  return extent;
}

TEST(Picture, TextIsCentredOnItsSmallLettersAndAsWideAsItSays) {
  const std::string text = "xoxnx";
  Picture picture(200, 60, kWhite);
  picture.draw_text(20.0, 30.0, text, 30.0, kBlack);
  const DarkPart extent = dark_part_of(picture);
  EXPECT_NEAR(0.5 * (extent.top + extent.bottom + 1), 30.0, 1.0);
  EXPECT_NEAR(extent.bottom - extent.top, 14.0, 1.0);
  EXPECT_NEAR(extent.left, 20.0, 4.0);
  EXPECT_NEAR(extent.right, 20.0 + Picture::text_width(text, 30.0), 4.0);
  EXPECT_EQ(Picture::text_width("", 30.0), 0.0);
}

TEST(Picture, LettersDifferAndWhatIsNotInTheFontIsAQuestionMark) {
  const auto drawn = [](const std::string& text) {
    Picture picture(60, 40, kWhite);
    picture.draw_text(10.0, 20.0, text, 20.0, kBlack);
    return picture.to_png();
  };
  EXPECT_NE(drawn("a"), drawn("b"));
  EXPECT_NE(drawn("a"), drawn("A"));
  EXPECT_EQ(drawn("\xc3\xa4"), drawn("??"));
  EXPECT_EQ(drawn("\xff\n"), drawn("??"));  // not even UTF-8
}

TEST(Picture, PngFileIsDecodedToTheSamePixels) {
  Picture picture(3, 2, Color{10, 20, 30});
  picture.fill(2, 1, 3, 2, Color{200, 100, 50});
  const std::string png = picture.to_png();
  EXPECT_EQ(png, picture.to_png());
  std::istringstream file(png);
  const auto read = [](void* from, unsigned char* bytes, unsigned int count) {
    static_cast<std::istringstream*>(from)->read(reinterpret_cast<char*>(bytes), count);
    return CAIRO_STATUS_SUCCESS;
  };
  cairo_surface_t* decoded = cairo_image_surface_create_from_png_stream(read, &file);
  ASSERT_EQ(cairo_image_surface_get_width(decoded), 3);
  ASSERT_EQ(cairo_image_surface_get_height(decoded), 2);
  const auto pixel_at = [&](int x, int y) {
    std::uint32_t pixel = 0;
    const std::ptrdiff_t stride = cairo_image_surface_get_stride(decoded);
    const std::ptrdiff_t at = y * stride + std::ptrdiff_t{4} * x;
    std::memcpy(&pixel, cairo_image_surface_get_data(decoded) + at, sizeof pixel);
    return pixel & 0xFFFFFFU;
  };
  EXPECT_EQ(pixel_at(0, 0), 0x0A141EU);
  EXPECT_EQ(pixel_at(2, 0), 0x0A141EU);
  EXPECT_EQ(pixel_at(1, 1), 0x0A141EU);
  EXPECT_EQ(pixel_at(2, 1), 0xC86432U);
  cairo_surface_destroy(decoded);
}

TEST(Picture, TooLargeIsAnErrorThatSaysSo) {
  const std::string text = error_text<std::runtime_error>([] { Picture(40000, 2, kWhite); });
  EXPECT_TRUE(contains(text, "cannot draw a picture of 40000 x 2 pixels")) << text;
}

}  // namespace
}  // namespace matchbox_slam
