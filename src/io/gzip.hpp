#pragma once

#include <zlib.h>

#include <string>

#include "matchbox_slam/io/file.hpp"

namespace matchbox_slam {

/// Turns bytes that come piece by piece into the gzip format, which carries their length and
/// checksum. Throws std::runtime_error for more than 4 GB.
class Compressor {
 public:
  /// @param sink  gets what is compressed, piece by piece.
  explicit Compressor(ByteSink sink);
  ~Compressor() { deflateEnd(&stream_); }
  Compressor(const Compressor&) = delete;
  Compressor& operator=(const Compressor&) = delete;

  void add(const std::string& bytes);

  /// To be called once, at the end.
  void finish();

 private:
  void deflate_all(const std::string& bytes, int flush);

  z_stream stream_{};
  ByteSink sink_;
};

/// The same of bytes in one piece.
[[nodiscard]] std::string compress(const std::string& bytes);

/// What `compress` was given. Throws DamagedFile naming `path` when that is cut off or damaged, or
/// would take more than 4 GB.
[[nodiscard]] std::string decompress(const std::string& compressed, const std::string& path);

}  // namespace matchbox_slam
