#include <gtest/gtest.h>
#include <png.h>

#include <cmath>
#include <limits>

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

TEST(Picture, CrossingsAreNotDarkerThanTheRest) {
  Picture picture(40, 40, kWhite);
  picture.draw_line({{5.5, 20.5}, {35.5, 20.5}, {20.5, 35.5}, {20.5, 5.5}}, {kBlack, 0.5, 0.0});
  const int single = darkness(picture, 10, 20);
  EXPECT_LT(single, 255);
  EXPECT_EQ(darkness(picture, 20, 20), single);
}

TEST(Picture, DashesLeaveHalfOfTheLineOut) {
  Picture picture(220, 20, kWhite);
  picture.draw_line({{10, 10}, {90, 10}, {210, 10}}, {kBlack, 1.0, 10.0});
  EXPECT_GT(darkness(picture, 15, 10), 100);
  EXPECT_EQ(darkness(picture, 25, 10), 0);
  EXPECT_GT(darkness(picture, 95, 10), 100);
  EXPECT_EQ(darkness(picture, 105, 10), 0);
}

TEST(Picture, DrawsOnlyWhatIsInsideHoweverFarALineLeads) {
  Picture picture(20, 20, kWhite);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  picture.draw_line({{-1e8, 10.0}, {nan, 3.0}, {10.0, nan}, {1e18, 3.0}, {1e8, 10.0}},
                    {kBlack, 2.0, 0.0});
  EXPECT_EQ(ink(picture), 40.0);
  picture.draw_line({{-50, -50}, {-50, 90}}, {kBlack, 2.0, 0.0});
  picture.draw_line({{1e9, 1e9}, {2e9, 1e9}}, {kBlack, 2.0, 5.0});
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

TEST(Picture, TextHasItsDotsInItsPlace) {
  Picture picture(30, 20, kWhite);
  picture.draw_text(3, 2, "1", 2, kBlack);
  EXPECT_EQ(darkness(picture, 3 + 2 * 2, 2), 255);  // the tip of the one
  EXPECT_EQ(darkness(picture, 3, 2), 0);
  EXPECT_EQ(darkness(picture, 3 + 2 * 1, 2 + 2), 255);  // its nose, to the left
  EXPECT_EQ(darkness(picture, 3 + 2 * 3, 2 + 2), 0);
  EXPECT_EQ(darkness(picture, 3 + 2, 2 + 2 * 6), 255);  // its foot
  EXPECT_EQ(ink(picture), 4.0 * 10.0);
  EXPECT_EQ(Picture::text_width("12", 2), 22);
  EXPECT_EQ(Picture::text_width("", 2), 0);
}

TEST(EncodePng, IsDecodedToTheSamePixels) {
  Picture picture(3, 2, Color{10, 20, 30});
  picture.fill(2, 1, 3, 2, Color{200, 100, 50});
  const std::string png = encode_png(picture);
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  ASSERT_NE(png_image_begin_read_from_memory(&image, png.data(), png.size()), 0);
  EXPECT_EQ(image.width, 3U);
  EXPECT_EQ(image.height, 2U);
  image.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> bytes(PNG_IMAGE_SIZE(image));
  ASSERT_NE(png_image_finish_read(&image, nullptr, bytes.data(), 0, nullptr), 0);
  EXPECT_EQ(bytes, picture.bytes());
  EXPECT_EQ(bytes[15], 200);
}

}  // namespace
}  // namespace matchbox_slam
