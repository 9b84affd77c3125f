#include "io/gzip.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <stdexcept>

#include "matchbox_slam/io/file.hpp"

namespace matchbox_slam {
namespace {

constexpr int kGzipWindow = 15 + 16;  // zlib's own numbers: the largest window, a gzip head
constexpr int kMemoryLevel = 8;
constexpr std::size_t kMostBytes = 4'000'000'000;  // zlib counts in 32 bit

using Buffer = std::array<char, std::size_t{1} << 16>;

/// All of it at once, which zlib counts in 32 bit.
void give_input(const std::string& bytes, z_stream& stream) {
  // zlib does not write to its input, but older versions do not say so. NOLINTNEXTLINE
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(std::min(bytes.size(), kMostBytes));
}

}  // namespace

std::string compress(const std::string& bytes) {
  if (bytes.size() > kMostBytes) {
    throw std::runtime_error("cannot compress " + std::to_string(bytes.size()) +
                             " bytes; allowed: up to 4 GB");
  }
  z_stream stream{};
  if (deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, kGzipWindow, kMemoryLevel,
                   Z_DEFAULT_STRATEGY) != Z_OK) {
    throw std::runtime_error("cannot compress: there is not enough memory");
  }
  std::string result(deflateBound(&stream, bytes.size()), '\0');
  give_input(bytes, stream);
  stream.next_out = reinterpret_cast<Bytef*>(result.data());
  stream.avail_out = static_cast<uInt>(result.size());
  deflate(&stream, Z_FINISH);
  result.resize(stream.total_out);
  deflateEnd(&stream);
  return result;
}

std::string decompress(const std::string& compressed, const std::string& path) {
  z_stream stream{};
  if (inflateInit2(&stream, kGzipWindow) != Z_OK) {
    throw std::runtime_error("cannot decompress: there is not enough memory");
  }
  std::string result;
  Buffer buffer;
  give_input(compressed, stream);
  int state = Z_OK;
  while (state == Z_OK && result.size() <= kMostBytes) {
    stream.next_out = reinterpret_cast<Bytef*>(buffer.data());
    stream.avail_out = static_cast<uInt>(buffer.size());
    state = inflate(&stream, Z_NO_FLUSH);
    result.append(buffer.data(), buffer.size() - stream.avail_out);
  }
  inflateEnd(&stream);
  if (state != Z_STREAM_END) {
    throw FileError("'" + path + "' is no saved map, or is cut off or damaged");
  }
  return result;
}

}  // namespace matchbox_slam
