#include "bag/unpacking.hpp"

#include <fmt/core.h>
#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <cstring>
#include <memory>

namespace matchbox_slam {
namespace {

/// Makes room for more bytes where there is none, up to one beyond the most: with that one a frame
/// of the most bytes comes to its end.
void make_room(Unpacked& unpacked, std::size_t used, std::size_t packed_bytes,
               std::size_t most_bytes) {
  constexpr std::size_t kUsualRatio = 4;
  constexpr std::size_t kMinBytes = 1024;  // bytes
  Bytes& bytes = unpacked.bytes;
  if (used > most_bytes) {
    unpacked.defect = fmt::format("it unpacks to more than {} bytes", most_bytes);
  } else if (used == bytes.size()) {
    bytes.resize(std::min(std::max({kMinBytes, kUsualRatio * packed_bytes, 2 * bytes.size()}),
                          most_bytes + 1));
  }
}

struct Lz4Closer {
  void operator()(LZ4F_dctx* context) const { LZ4F_freeDecompressionContext(context); }
};

}  // namespace

Unpacked unpack_zstd(const ByteReader& packed, std::size_t most_bytes) {
  Unpacked unpacked;
  const std::unique_ptr<ZSTD_DCtx, std::size_t (*)(ZSTD_DCtx*)> context(ZSTD_createDCtx(),
                                                                        ZSTD_freeDCtx);
  ZSTD_inBuffer in{packed.data(), packed.size(), 0};
  std::size_t used = 0;
  make_room(unpacked, used, packed.size(), most_bytes);
  std::size_t hint = 1;  // 0 at the end of a frame
  while (unpacked.defect.empty() && (in.pos < in.size || hint != 0)) {
    ZSTD_outBuffer out{unpacked.bytes.data(), unpacked.bytes.size(), used};
    const std::size_t read_before = in.pos;
    hint = ZSTD_decompressStream(context.get(), &out, &in);
    if (ZSTD_isError(hint) != 0U) {
      unpacked.defect = ZSTD_getErrorName(hint);
    } else if (hint != 0 && in.pos == read_before && out.pos == used) {
      unpacked.defect = "it is cut off";
    }
    used = out.pos;
    make_room(unpacked, used, packed.size(), most_bytes);
  }
  unpacked.bytes.resize(std::min(used, most_bytes));
  return unpacked;
}

Unpacked unpack_lz4(const ByteReader& packed, std::size_t most_bytes) {
  Unpacked unpacked;
  LZ4F_dctx* raw_context = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&raw_context, LZ4F_VERSION)) != 0U) {
    return {{}, "there is not enough memory"};
  }
  const std::unique_ptr<LZ4F_dctx, Lz4Closer> context(raw_context);
  std::size_t read = 0;
  std::size_t used = 0;
  make_room(unpacked, used, packed.size(), most_bytes);
  std::size_t hint = 1;  // 0 at the end of a frame
  while (unpacked.defect.empty() && (read < packed.size() || hint != 0)) {
    std::size_t room = unpacked.bytes.size() - used;
    std::size_t taken = packed.size() - read;
    hint = LZ4F_decompress(context.get(), unpacked.bytes.data() + used, &room, packed.data() + read,
                           &taken, nullptr);
    if (LZ4F_isError(hint) != 0U) {
      unpacked.defect = LZ4F_getErrorName(hint);
      break;
    }
    if (hint != 0 && taken == 0 && room == 0) {
      unpacked.defect = "it is cut off";
    }
    read += taken;
    used += room;
    make_room(unpacked, used, packed.size(), most_bytes);
  }
  unpacked.bytes.resize(std::min(used, most_bytes));
  return unpacked;
}

bool is_zstd(const ByteReader& bytes) {
  return bytes.size() >= 4 && std::memcmp(bytes.data(), "\x28\xB5\x2F\xFD", 4) == 0;
}

}  // namespace matchbox_slam
