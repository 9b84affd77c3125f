#pragma once

#include <gif_lib.h>

#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

#include "io/picture.hpp"
#include "matchbox_slam/io/file.hpp"

namespace matchbox_slam {

/// Pictures of one size, one after the other and then from the first one again, as an animated GIF
/// of one palette. Of each picture only what has changed is kept. Members throw std::runtime_error
/// where it cannot be encoded.
class GifFile {
 public:
  /// @param main_colors  kept as they are, up to 32; others are taken for the nearest of these and
  ///                     of 216 that are spread evenly.
  /// @param sink         gets the file, piece by piece.
  GifFile(int width, int height, const std::vector<Color>& main_colors, ByteSink sink);
  ~GifFile();
  GifFile(const GifFile&) = delete;
  GifFile& operator=(const GifFile&) = delete;

  /// @param picture  of that size. @param hundredths  how long it is shown [0.01 s].
  void add(const Picture& picture, int hundredths);

  /// To be called once, at the end.
  void finish();

 private:
  [[nodiscard]] std::uint8_t index_of(const Color& color);
  [[nodiscard]] std::vector<std::uint8_t> indices_of(const Picture& picture);
  void begin();
  void put_changes(std::vector<std::uint8_t> pixels);
  void require(int success) const;
  void hand_on();

  int width_;
  int height_;
  std::vector<Color> palette_;  ///< the first one stands for what has not changed
  std::unordered_map<std::uint32_t, std::uint8_t> known_;  ///< indices of colors that were met
  std::vector<std::uint8_t> shown_;  ///< by the picture before; empty: there is none
  ByteSink sink_;
  std::string written_;  ///< that the sink has not got
  GifFileType* gif_;
};

}  // namespace matchbox_slam
