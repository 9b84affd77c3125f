// Of tools/movie_file.hpp, map_movie.hpp and movie_view.hpp: movies that map_bag writes, taken
// apart by giflib and libpng, and what single frames show.

#include <gif_lib.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <memory>

#include "common/error_text.hpp"
#include "io/png_image.hpp"
#include "io/temporary_folder.hpp"
#include "matchbox_slam/io/file.hpp"
#include "ros/messages.hpp"
#include "tools/movie_map.hpp"
#include "tools/movie_view.hpp"
#include "tools/run_command.hpp"

namespace matchbox_slam {
namespace {

using Pixels = std::vector<std::uint8_t>;  // red, green and blue, row by row

/// The frames of a GIF as a browser shows them.
struct DecodedGif {
  int width = 0;
  int height = 0;
  std::vector<Pixels> frames;
  std::vector<int> hundredths;
};

DecodedGif decode(const std::string& path) {
  int error = 0;
  const std::unique_ptr<GifFileType, void (*)(GifFileType*)> gif(
      DGifOpenFileName(path.c_str(), &error),
      [](GifFileType* file) { static_cast<void>(DGifCloseFile(file, nullptr)); });
  if (gif == nullptr || DGifSlurp(gif.get()) != GIF_OK) {
    throw std::runtime_error("no GIF: " + path);
  }
  DecodedGif decoded{gif->SWidth, gif->SHeight, {}, {}};
  Pixels shown(static_cast<std::size_t>(3 * gif->SWidth * gif->SHeight));
  for (int i = 0; i < gif->ImageCount; ++i) {
    GraphicsControlBlock control{};
    DGifSavedExtensionToGCB(gif.get(), i, &control);
    const SavedImage& image = gif->SavedImages[i];
    for (int k = 0; k < image.ImageDesc.Width * image.ImageDesc.Height; ++k) {
      const int index = image.RasterBits[k];
      const int x = image.ImageDesc.Left + k % image.ImageDesc.Width;
      const int y = image.ImageDesc.Top + k / image.ImageDesc.Width;
      if (index != control.TransparentColor) {
        const GifColorType& color = gif->SColorMap->Colors[index];
        std::uint8_t* const pixel =
            &shown[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(gif->SWidth) +
                        static_cast<std::size_t>(x))];
        pixel[0] = color.Red;
        pixel[1] = color.Green;
        pixel[2] = color.Blue;
      }
    }
    decoded.frames.push_back(shown);
    decoded.hundredths.push_back(control.DelayTime);
  }
  return decoded;
}

class Movie : public testing::Test {
 protected:
  Movie() { ::setenv("LC_ALL", "C", 1); }

  Outcome run(const std::string& arguments) {
    return run_command(MATCHBOX_MAP_BAG, bag_ + " --out " + out_ + " " + arguments);
  }

  [[nodiscard]] std::string png(int number) const {
    return folder_ / ("frames/frame_0" + std::string(number < 10 ? "0" : "") +
                      std::to_string(number) + ".png");
  }

  TemporaryFolder folder_;
  std::string bag_ = folder_ / "small.bag";
  std::string out_ = folder_ / "out";
  std::string gif_ = folder_ / "map.gif";
};

TEST_F(Movie, AGifShowsWhatTheFolderOfPngsDoes) {
  write_small_bag(bag_);
  ASSERT_EQ(run("--movie " + gif_).exit_code, 0);
  std::filesystem::create_directory(folder_ / "frames");
  replace_file(png(49), "of a longer movie");
  replace_file(png(50), "of a longer movie");
  replace_file(folder_ / "frames/my_frame.png", "of somebody else");
  ASSERT_EQ(run("--movie " + (folder_ / "frames")).exit_code, 0);
  EXPECT_FALSE(std::filesystem::exists(png(50)));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "frames/my_frame.png"));
  const DecodedGif gif = decode(gif_);
  ASSERT_EQ(gif.frames.size(), 50U) << "one a scan";
  for (int i = 0; i < 50; ++i) {
    const auto number = static_cast<std::size_t>(i);
    const PngImage frame = read_png(read_file(png(i)));
    ASSERT_EQ(frame.width, gif.width);
    ASSERT_EQ(frame.height, gif.height);
    EXPECT_EQ(gif.hundredths[number], i < 49 ? 10 : 300);
    int farthest = 0;
    std::size_t different = 0;
    for (std::size_t k = 0; k < frame.samples.size(); ++k) {
      const int by = std::abs(frame.samples[k] - gif.frames[number][k]);
      farthest = std::max(farthest, by);
      different += by > 0 ? 1 : 0;
    }
    EXPECT_LE(farthest, 60) << "colours of edges are taken for the nearest ones";
    EXPECT_LT(different, frame.samples.size() / 50);
  }
  EXPECT_NE(gif.frames.front(), gif.frames.back());
}

TEST_F(Movie, IsBoundedHoweverLongTheDrive) {
  SmallBag recipe;
  recipe.scans = 700;
  write_small_bag(bag_, recipe);
  ASSERT_EQ(run("--movie " + gif_).exit_code, 0);
  const DecodedGif gif = decode(gif_);
  EXPECT_EQ(gif.frames.size(), 89U) << "every eighth scan, and the last one";
  EXPECT_LE(std::max(gif.width, gif.height), 800);
  EXPECT_GE(std::max(gif.width, gif.height), 380);
  EXPECT_EQ(gif.width % 2 + gif.height % 2, 0);
  const std::string bytes = read_file(gif_);
  ASSERT_EQ(run("--threads 2 --movie " + gif_).exit_code, 0);
  EXPECT_TRUE(read_file(gif_) == bytes);
}

TEST_F(Movie, MakesItsFolder) {
  write_small_bag(bag_);
  for (const std::string& name : {folder_ / "new/there/map.gif", folder_ / "new/frames"}) {
    const Outcome outcome = run("--movie " + name);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
    EXPECT_TRUE(std::filesystem::exists(name));
  }
}

TEST_F(Movie, IsRefusedBeforeTheWorkWhereItCannotBe) {
  write_small_bag(bag_);
  replace_file(folder_ / "file", "");
  const auto expect_refused = [&](const std::string& movie, int exit_code,
                                  const std::string& words) {
    const Outcome outcome = run("--movie '" + movie + "'");
    EXPECT_EQ(outcome.exit_code, exit_code) << outcome.output;
    EXPECT_TRUE(contains(outcome.output, words)) << outcome.output;
    EXPECT_EQ(std::count(outcome.output.begin(), outcome.output.end(), '\n'), 1) << outcome.output;
    EXPECT_FALSE(std::filesystem::exists(out_ + "/trajectory.tum"));
  };
  expect_refused("", 2, "--movie: '' is not allowed; allowed: a name that ends in .gif, or a fol");
  expect_refused(folder_ / "map.MP4", 2, "/map.MP4' is not allowed; allowed: a name that ends in ");
  expect_refused(folder_ / "file/map.gif", 1, "cannot create the folder '" + (folder_ / "file"));
  expect_refused(folder_ / "file/frames", 1, folder_ / "file/frames");
  const Outcome converted =
      run_command(MATCHBOX_MAP_BAG, bag_ + " --convert " + (folder_ / "o.bag") + " --movie a.gif");
  EXPECT_EQ(converted.exit_code, 2);
  EXPECT_TRUE(contains(converted.output, "--convert: --movie is for maps")) << converted.output;
}

/// A square of free ground with a wall on top.
MovieFrame frame_of_room(int cells) {
  OccupancyGrid grid(0.05);
  for (int y = 0; y < cells; ++y) {
    for (int x = 0; x < cells; ++x) {
      grid.blend({x, y}, y == cells - 1 ? 1.0 : 0.0, 1.0);
    }
  }
  MovieFrame frame;
  frame.map = MapShades(grid);
  return frame;
}

template <typename IsOfKind>
int count(const Picture& picture, IsOfKind&& is_of_kind) {
  int count = 0;
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      count += is_of_kind(picture.color_at(x, y)) ? 1 : 0;
    }
  }
  return count;
}

bool is_orange(const Color& color) {
  return color.red > color.blue + 100 && color.green > color.blue + 40;
}
bool is_dark(const Color& color) { return color.red < 30 && color.green < 40; }

TEST(MovieView, ShowsWhereElseTheRobotMayBe) {
  MovieFrame frame = frame_of_room(100);
  frame.robot = Pose2{1.0, 1.0, 0.0};
  MovieFrame doubted = frame;
  doubted.others = {{{3.0, 3.0, 0.0}, 0.3}};
  const MovieView view({frame, doubted}, 0.05);
  EXPECT_EQ(count(view.draw(frame), is_orange), 0);
  const Picture picture = view.draw(doubted);
  EXPECT_GT(count(picture, is_orange), 40);
  const int pixels = view.width() / 100 * 20;  // a metre
  EXPECT_TRUE(
      is_orange(picture.color_at((view.width() - 5 * pixels) / 2 + 3 * pixels, 8 + 2 * pixels)));
}

TEST(MovieView, ThinWallsOfACoarserMapStayAndNoPictureIsTooLarge) {
  MovieFrame far = frame_of_room(100);
  far.path = {{{0.0F, 0.0F}, {2000.0F, -1500.0F}, {9.0e7F, 0.0F}}};
  const MovieFrame room = frame_of_room(700);
  const MovieView view({far, room}, 0.05);
  EXPECT_LE(view.width(), MovieView::kMostPixels);
  EXPECT_LE(view.height(), MovieView::kMostPixels);
  EXPECT_GT(std::max(view.width(), view.height()), MovieView::kMostPixels / 4);
  EXPECT_EQ(count(view.draw(room), is_dark), 11) << "35 m of wall at 3.2 m a pixel";
}

/// The walls of a room of 4 m, seen from its middle.
PlacedScan key_scan_at(const Pose2& pose) {
  PointScan points;
  for (int i = 0; i < 360; ++i) {
    const double angle = i * kPi / 180.0;
    const double range = 2.0 / std::max(std::abs(std::cos(angle)), std::abs(std::sin(angle)));
    ScanPoint point;
    point.position = {range * std::cos(angle), range * std::sin(angle)};
    points.points.push_back(point);
  }
  return {std::make_shared<const KeyScan>(points), pose};
}

TEST(MovieMap, IsDrawnAnewWhereKeyScansHaveMoved) {
  PlacedScans keys = {key_scan_at({}), key_scan_at({0.1, 0.0, 0.0})};
  MovieMap grown;
  grown.draw({keys.front()}, 0.05);
  grown.draw(keys, 0.05);
  const auto expect_as_fresh = [&](const MovieMap& map) {
    MovieMap fresh;
    fresh.draw(keys, 0.05);
    const CellBox cells = fresh.grid().known_bounds();
    ASSERT_EQ(map.level(), fresh.level());
    ASSERT_EQ(map.grid().known_bounds().width(), cells.width());
    for (int y = cells.min.y; y < cells.max.y; ++y) {
      for (int x = cells.min.x; x < cells.max.x; ++x) {
        ASSERT_EQ(map.grid().stored({x, y}), fresh.grid().stored({x, y}));
      }
    }
  };
  expect_as_fresh(grown);
  keys.back().map_from_base.y = 0.2;
  grown.draw(keys, 0.05);
  expect_as_fresh(grown);
  keys.erase(keys.begin());
  grown.draw(keys, 0.05);
  expect_as_fresh(grown);
  keys.push_back(key_scan_at({100.0, 0.0, 0.0}));
  grown.draw(keys, 0.05);
  EXPECT_EQ(grown.level(), 2) << "104 m are 520 cells of 0.2 m";
  expect_as_fresh(grown);
}

}  // namespace
}  // namespace matchbox_slam
