#include "tools/gif_file.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <stdexcept>
#include <utility>

#include "matchbox_slam/map/grid_geometry.hpp"

namespace matchbox_slam {
namespace {

constexpr std::uint8_t kUnchanged = 0;
constexpr std::size_t kPaletteSize = 256;

std::vector<Color> palette_with(const std::vector<Color>& main_colors) {
  constexpr int kLevels = 6;
  constexpr int kStep = 255 / (kLevels - 1);
  std::vector<Color> palette(1);
  palette.insert(palette.end(), main_colors.begin(), main_colors.end());
  for (int i = 0; i < kLevels * kLevels * kLevels; ++i) {
    palette.push_back({static_cast<std::uint8_t>(kStep * (i / (kLevels * kLevels))),
                       static_cast<std::uint8_t>(kStep * (i / kLevels % kLevels)),
                       static_cast<std::uint8_t>(kStep * (i % kLevels))});
  }
  return palette;
}

int square(int number) { return number * number; }

int distance(const Color& a, const Color& b) {
  return square(a.red - b.red) + square(a.green - b.green) + square(a.blue - b.blue);
}

std::uint32_t key_of(const Color& color) {
  return static_cast<std::uint32_t>(color.red) << 16U |
         static_cast<std::uint32_t>(color.green) << 8U | color.blue;
}

int append_to(GifFileType* gif, const GifByteType* bytes, int count) {
  static_cast<std::string*>(gif->UserData)
      ->append(reinterpret_cast<const char*>(bytes), static_cast<std::size_t>(count));
  return count;
}

}  // namespace

GifFile::GifFile(int width, int height, const std::vector<Color>& main_colors, ByteSink sink)
    : width_(width), height_(height), palette_(palette_with(main_colors)), sink_(std::move(sink)) {
  int error = 0;
  gif_ = EGifOpen(&written_, append_to, &error);
  if (gif_ == nullptr) {
    throw std::runtime_error(std::string("cannot begin a GIF: ") + GifErrorString(error));
  }
}

GifFile::~GifFile() {
  if (gif_ != nullptr) {
    EGifCloseFile(gif_, nullptr);
  }
}

void GifFile::require(int success) const {
  if (success != GIF_OK) {
    throw std::runtime_error(std::string("cannot encode a GIF: ") + GifErrorString(gif_->Error));
  }
}

/// Not as it comes: an error must not pass through what is written in C.
void GifFile::hand_on() {
  sink_(written_);
  written_.clear();
}

std::uint8_t GifFile::index_of(const Color& color) {
  const auto [known, is_new] = known_.try_emplace(key_of(color), kUnchanged);
  if (is_new) {
    const auto nearest = std::min_element(
        palette_.begin() + 1, palette_.end(),
        [&](const Color& a, const Color& b) { return distance(a, color) < distance(b, color); });
    known->second = static_cast<std::uint8_t>(nearest - palette_.begin());
  }
  return known->second;
}

std::vector<std::uint8_t> GifFile::indices_of(const Picture& picture) {
  std::vector<std::uint8_t> indices;
  indices.reserve(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
  Color last;
  std::uint8_t index = index_of(last);
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      const Color color = picture.color_at(x, y);
      if (key_of(color) != key_of(last)) {
        index = index_of(color);
        last = color;
      }
      indices.push_back(index);
    }
  }
  return indices;
}

void GifFile::begin() {
  std::array<GifColorType, kPaletteSize> colors{};
  std::transform(palette_.begin(), palette_.end(), colors.begin(), [](const Color& color) {
    return GifColorType{color.red, color.green, color.blue};
  });
  const std::unique_ptr<ColorMapObject, void (*)(ColorMapObject*)> map(
      GifMakeMapObject(kPaletteSize, colors.data()), GifFreeMapObject);
  constexpr int kBitsPerColor = 8;
  constexpr std::array<GifByteType, 3> kEndlessLoop = {1, 0, 0};
  EGifSetGifVersion(gif_, true);
  require(EGifPutScreenDesc(gif_, width_, height_, kBitsPerColor, kUnchanged, map.get()));
  require(EGifPutExtensionLeader(gif_, APPLICATION_EXT_FUNC_CODE));
  require(EGifPutExtensionBlock(gif_, 11, "NETSCAPE2.0"));
  require(EGifPutExtensionBlock(gif_, kEndlessLoop.size(), kEndlessLoop.data()));
  require(EGifPutExtensionTrailer(gif_));
}

void GifFile::put_changes(std::vector<std::uint8_t> pixels) {
  CellBox changed = shown_.empty() ? CellBox{{0, 0}, {width_, height_}} : CellBox{};
  const auto width = static_cast<std::size_t>(width_);
  for (std::size_t i = 0; i < shown_.size(); ++i) {
    if (pixels[i] == shown_[i]) {
      pixels[i] = kUnchanged;
    } else {
      shown_[i] = pixels[i];
      changed.include({static_cast<int>(i % width), static_cast<int>(i / width)});
    }
  }
  if (changed.empty()) {
    changed = {{0, 0}, {1, 1}};
  }
  require(EGifPutImageDesc(gif_, changed.min.x, changed.min.y, changed.width(), changed.height(),
                           false, nullptr));
  for (int y = changed.min.y; y < changed.max.y; ++y) {
    require(EGifPutLine(
        gif_,
        &pixels[static_cast<std::size_t>(y) * width + static_cast<std::size_t>(changed.min.x)],
        changed.width()));
  }
  if (shown_.empty()) {
    shown_ = std::move(pixels);
  }
}

void GifFile::add(const Picture& picture, int hundredths) {
  if (shown_.empty()) {
    begin();
  }
  const GraphicsControlBlock control{DISPOSE_DO_NOT, false, hundredths, kUnchanged};
  std::array<GifByteType, 4> bytes{};
  EGifGCBToExtension(&control, bytes.data());
  require(EGifPutExtension(gif_, GRAPHICS_EXT_FUNC_CODE, bytes.size(), bytes.data()));
  put_changes(indices_of(picture));
  hand_on();
}

void GifFile::finish() {
  int error = 0;
  if (EGifCloseFile(std::exchange(gif_, nullptr), &error) != GIF_OK) {
    throw std::runtime_error(std::string("cannot end a GIF: ") + GifErrorString(error));
  }
  hand_on();
}

}  // namespace matchbox_slam
