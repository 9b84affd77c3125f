#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "bag/byte_reader.hpp"

namespace matchbox_slam {

using Bytes = std::vector<std::uint8_t>;

/// What came of unpacking: of bytes that are cut off or damaged, those before.
struct Unpacked {
  Bytes bytes;
  std::string defect;  ///< why it is not all; empty: it is
};

/// Unpacks frames of zstd or of LZ4 to `most_bytes` at most; the memory grows with what there is.
[[nodiscard]] Unpacked unpack_zstd(const ByteReader& packed, std::size_t most_bytes);
[[nodiscard]] Unpacked unpack_lz4(const ByteReader& packed, std::size_t most_bytes);

/// Whether bytes begin as what zstd packs does.
[[nodiscard]] bool is_zstd(const ByteReader& bytes);

}  // namespace matchbox_slam
