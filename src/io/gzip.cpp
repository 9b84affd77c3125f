#include "io/gzip.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <utility>

namespace matchbox_slam {
namespace {

constexpr int kGzipWindow = 15 + 16;  // zlib's own numbers: the largest window, a gzip head
constexpr int kMemoryLevel = 8;
// Of 1 to 9: a fifth to a third of the time of the usual 6, for 6 to 17 % more bytes of a map.
constexpr int kCompressionLevel = 1;
constexpr std::size_t kMostBytes = 4'000'000'000;  // zlib counts in 32 bit

using Buffer = std::array<char, std::size_t{1} << 16>;

/// All of it at once, which zlib counts in 32 bit.
void give_input(const std::string& bytes, z_stream& stream) {
  // zlib does not write to its input, but older versions do not say so. NOLINTNEXTLINE
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(std::min(bytes.size(), kMostBytes));
}

}  // namespace

Compressor::Compressor(ByteSink sink) : sink_(std::move(sink)) {
  if (deflateInit2(&stream_, kCompressionLevel, Z_DEFLATED, kGzipWindow, kMemoryLevel,
                   Z_DEFAULT_STRATEGY) != Z_OK) {
    throw std::runtime_error("cannot compress: there is not enough memory");
  }
}

void Compressor::add(const std::string& bytes) {
  if (bytes.size() > kMostBytes || stream_.total_in > kMostBytes - bytes.size()) {
    throw std::runtime_error("cannot compress more than 4 GB");
  }
  deflate_all(bytes, Z_NO_FLUSH);
}

void Compressor::deflate_all(const std::string& bytes, int flush) {
  Buffer buffer;
  give_input(bytes, stream_);
  do {
    stream_.next_out = reinterpret_cast<Bytef*>(buffer.data());
    stream_.avail_out = static_cast<uInt>(buffer.size());
    deflate(&stream_, flush);
    sink_({buffer.data(), buffer.size() - stream_.avail_out});
  } while (stream_.avail_out == 0);
}

void Compressor::finish() { deflate_all("", Z_FINISH); }

std::string compress(const std::string& bytes) {
  std::string compressed;
  Compressor compressor([&compressed](const std::string& piece) { compressed += piece; });
  compressor.add(bytes);
  compressor.finish();
  return compressed;
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
    throw DamagedFile(fmt::format("'{}' is no saved map, or is cut off or damaged", path));
  }
  return result;
}

}  // namespace matchbox_slam
