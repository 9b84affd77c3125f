#include "io/png_image.hpp"

#include <fmt/core.h>
#include <png.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <stdexcept>

namespace matchbox_slam {
namespace {

// Beyond, a file of some kilobytes would fill the memory.
constexpr double kMostSamples = 4e8;

/// libpng's view of one image, which lends memory until it is done.
class Image {
 public:
  Image() { image_.version = PNG_IMAGE_VERSION; }
  Image(const Image&) = delete;
  Image& operator=(const Image&) = delete;
  ~Image() { png_image_free(&image_); }

  png_image& operator*() { return image_; }
  png_image* operator->() { return &image_; }

  void require(int success, const std::string& what) const {
    if (success == 0) {
      throw std::runtime_error(fmt::format("{} ({})", what, image_.message));
    }
  }

 private:
  png_image image_{};
};

/// The channels that the pixels have, whatever their depth.
std::uint32_t format_of(std::uint32_t format) {
  if ((format & PNG_FORMAT_FLAG_ALPHA) != 0) {
    return PNG_FORMAT_RGBA;
  }
  return (format & PNG_FORMAT_FLAG_COLOR) != 0 ? PNG_FORMAT_RGB : PNG_FORMAT_GRAY;
}

constexpr std::size_t kSignature = 8;  // bytes of a PNG before its first chunk

/// The file without what it says of the colours' meaning, which map_server does not look at, and
/// libpng would bend the pixels by.
std::string without_colour_space(const std::string& bytes) {
  constexpr std::size_t kChunkOverhead = 12;  // bytes of a chunk beside its contents
  constexpr std::array kTypes = {"gAMA", "cHRM", "sRGB", "iCCP"};
  std::string kept = bytes.substr(0, kSignature);
  std::size_t begin = kept.size();
  while (begin + kChunkOverhead <= bytes.size()) {
    std::size_t size = 0;
    for (std::size_t i = begin; i < begin + 4; ++i) {
      size = (size << 8U) | static_cast<unsigned char>(bytes[i]);
    }
    const std::string type = bytes.substr(begin + 4, 4);
    if (std::find(kTypes.begin(), kTypes.end(), type) == kTypes.end()) {
      kept += bytes.substr(begin, size + kChunkOverhead);
    }
    begin += size + kChunkOverhead;
  }
  return begin >= bytes.size() ? kept : kept + bytes.substr(begin);
}

std::string encoded(int width, int height, const std::vector<std::uint8_t>& samples,
                    std::uint32_t format, std::uint32_t flags) {
  Image image;
  image->width = static_cast<std::uint32_t>(width);
  image->height = static_cast<std::uint32_t>(height);
  image->format = format;
  image->flags = flags;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(*image);
  // Most of which is never touched. NOLINTNEXTLINE(modernize-avoid-c-arrays)
  const std::unique_ptr<char[]> bytes(new char[size]);
  image.require(
      png_image_write_to_memory(&*image, bytes.get(), &size, 0, samples.data(), 0, nullptr),
      fmt::format("cannot encode a PNG of {} x {} pixels", width, height));
  return {bytes.get(), size};
}

}  // namespace

bool is_png(const std::string& bytes) {
  return bytes.compare(0, kSignature, "\x89PNG\r\n\x1a\n") == 0;
}

PngImage read_png(const std::string& file) {
  const std::string bytes = without_colour_space(file);
  Image image;
  image.require(png_image_begin_read_from_memory(&*image, bytes.data(), bytes.size()),
                "is a damaged PNG");
  image->format = format_of(image->format);
  image->flags |= PNG_IMAGE_FLAG_16BIT_sRGB;  // else 16 bits were taken for linear, and bent
  PngImage result;
  result.width = static_cast<int>(image->width);
  result.height = static_cast<int>(image->height);
  result.channels = static_cast<int>(PNG_IMAGE_SAMPLE_CHANNELS(image->format));
  const double samples = static_cast<double>(image->width) * static_cast<double>(image->height) *
                         static_cast<double>(result.channels);
  if (samples > kMostSamples) {
    throw std::runtime_error(
        fmt::format("has {} x {} pixels of {} channels; allowed: 400 million samples in all",
                    image->width, image->height, result.channels));
  }
  result.samples.resize(static_cast<std::size_t>(samples));
  image.require(png_image_finish_read(&*image, nullptr, result.samples.data(), 0, nullptr),
                "is a PNG that is cut off or damaged");
  return result;
}

std::string gray_png(int width, int height, const std::vector<std::uint8_t>& pixels) {
  return encoded(width, height, pixels, PNG_FORMAT_GRAY, 0);
}

std::string drawn_png(int width, int height, const std::vector<std::uint8_t>& samples) {
  return encoded(width, height, samples, PNG_FORMAT_RGB, PNG_IMAGE_FLAG_FAST);
}

}  // namespace matchbox_slam
