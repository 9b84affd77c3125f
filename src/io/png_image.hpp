#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace matchbox_slam {

/// The pixels of a PNG as they are in it, 8 bits each: those of 16 are cut to 8, colours of a
/// palette are looked up.
struct PngImage {
  int width = 0;
  int height = 0;
  int channels = 1;                   ///< 1: gray, 3: red, green, blue, 4: and alpha
  std::vector<std::uint8_t> samples;  ///< of each pixel all channels; row by row, the top one first
};

/// Whether these bytes begin as a PNG does.
[[nodiscard]] bool is_png(const std::string& bytes);

/// Takes a PNG apart. Throws std::runtime_error, telling what is wrong with "it".
[[nodiscard]] PngImage read_png(const std::string& file);

/// A gray PNG of 8 bits. @param pixels  row by row, the top one first.
[[nodiscard]] std::string gray_png(int width, int height, const std::vector<std::uint8_t>& pixels);

/// A PNG of something drawn, packed fast: without the search for the best filter of each row, which
/// takes most of the time and makes maps smaller by a tenth, small ones by two fifths.
/// @param samples  red, green and blue of each pixel; row by row, the top one first.
[[nodiscard]] std::string drawn_png(int width, int height,
                                    const std::vector<std::uint8_t>& samples);

}  // namespace matchbox_slam
