#include "bag/log_lines.hpp"

#include <fmt/core.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "bag/bag_error.hpp"

namespace matchbox_slam {
namespace {

constexpr std::size_t kBufferSize = std::size_t{1} << 16;
constexpr std::size_t kLongestLine = std::size_t{1} << 20;

}  // namespace

LogLines::LogLines(const std::string& path)
    : file_(gzopen(path.c_str(), "rb")), buffer_(kBufferSize) {
  if (file_ == nullptr) {
    throw BagError(
        fmt::format("'{}' cannot be opened: {}", path, std::generic_category().message(errno)));
  }
}

LogLines::~LogLines() { gzclose(file_); }

bool LogLines::fill() {
  if (!damage_.empty()) {
    return false;
  }
  const int count = gzread(file_, buffer_.data(), static_cast<unsigned>(buffer_.size()));
  at_ = 0;
  end_ = count > 0 ? static_cast<std::size_t>(count) : 0;
  int state = Z_OK;
  const char* text = gzerror(file_, &state);
  if (state == Z_BUF_ERROR) {
    damage_ = "what gzip packed is cut off";
  } else if (state != Z_OK && state != Z_STREAM_END) {
    damage_ = std::string("it cannot be unpacked: ") + text;
  }
  return end_ > 0;
}

bool LogLines::next(std::string& line) {
  line.clear();
  has_end_ = false;
  bool has_begun = false;
  while (!has_end_ && (at_ < end_ || fill())) {
    has_begun = true;
    const auto begin = buffer_.begin() + static_cast<std::ptrdiff_t>(at_);
    const auto end = buffer_.begin() + static_cast<std::ptrdiff_t>(end_);
    const auto found = std::find(begin, end, '\n');
    const auto length =
        std::min(static_cast<std::size_t>(found - begin), kLongestLine - line.size());
    line.append(&*begin, length);
    at_ += length;
    if (line.size() == kLongestLine) {
      has_end_ = true;  // no line is so long; the rest is another one
    } else if (found != end) {
      has_end_ = true;
      ++at_;
    }
  }
  if (!line.empty() && line.back() == '\r') {
    line.pop_back();
  }
  number_ += has_begun ? 1 : 0;
  return has_begun;
}

}  // namespace matchbox_slam
