#pragma once

#include <array>
#include <cstdint>

namespace matchbox_slam {

constexpr int kGlyphWidth = 5;
constexpr int kGlyphHeight = 9;

/// Rows from the top, in each the leftmost dot is the bit of value 16.
using Glyph = std::array<std::uint8_t, kGlyphHeight>;

/// The dots of a-z, 0-9, '.' and '-'; none for any other character.
[[nodiscard]] const Glyph& glyph_of(char character);

}  // namespace matchbox_slam
