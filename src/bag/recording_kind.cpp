#include "bag/recording_kind.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <fstream>
#include <sstream>

#include "bag/carmen_line.hpp"
#include "bag/log_lines.hpp"
#include "common/number_text.hpp"

namespace matchbox_slam {
namespace {

using Format = RecordingKind::Format;

constexpr std::size_t kHeadBytes = 64;
constexpr int kHeadLines = 50;  // within which a log has a message, comments apart
constexpr std::size_t kMostHeadLines = 1000;

bool begins_with(const std::string& bytes, const std::string& beginning) {
  return bytes.rfind(beginning, 0) == 0;
}

std::string head_of(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  std::string bytes(kHeadBytes, '\0');
  stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<std::size_t>(std::max<std::streamsize>(stream.gcount(), 0)));
  return bytes;
}

RecordingKind other(std::string what_to_do) { return {Format::kOther, std::move(what_to_do)}; }

/// @param head  of a bag of ROS 1 of another version, such as "#ROSBAG V1.2".
std::string text_of_old_bag(const std::string& head, const std::string& path) {
  constexpr std::size_t kVersionPlace = 9;
  constexpr std::size_t kVersionSize = 3;
  const std::string version = head.substr(kVersionPlace, kVersionSize);
  return fmt::format("is a bag of version {}, which ROS wrote in its first years; {}", version,
                     version == "1.2"
                         ? fmt::format("convert it: rosbag filter '{}' NEW.bag True; where that "
                                       "asks for an index, rosbag reindex it first",
                                       path)
                         : "convert it with the release of ROS that recorded it");
}

/// MRPT begins with an object: the length of its class's name, whose highest bit is set, and that
/// name.
bool is_rawlog(const std::string& head) {
  constexpr unsigned kHighestBit = 0x80;
  const unsigned first = head.empty() ? 0U : static_cast<unsigned char>(head.front());
  const std::size_t length = first & ~kHighestBit;
  if ((first & kHighestBit) == 0 || length < 3 ||
      head.size() < 1 + std::min<std::size_t>(length, 20)) {
    return false;
  }
  const std::string name = head.substr(1, std::min<std::size_t>(length, 20));
  return (name.front() == 'C' || begins_with(name, "mrpt::")) &&
         std::all_of(name.begin(), name.end(), [](unsigned char letter) {
           return std::isalnum(letter) != 0 || letter == ':' || letter == '_';
         });
}

/// tinySLAM's recordings have a line of numbers for each scan of hundreds of beams.
bool is_line_of_numbers(const std::string& line) {
  constexpr std::size_t kMinNumbers = 100;
  std::istringstream words(line);
  std::size_t count = 0;
  for (std::string word; words >> word; ++count) {
    if (!finite_number(word)) {
      return false;
    }
  }
  return count >= kMinNumbers;
}

std::string unpack_with(const std::string& program, const std::string& packer,
                        const std::string& path) {
  return fmt::format("is packed by {}; unpack it: {} '{}'", packer, program, path);
}

/// By the magic bytes of what is no text; of kOther without text where there are none.
RecordingKind kind_by_magic(const std::string& head, const std::string& path) {
  using namespace std::string_literals;
  if (begins_with(head, "#ROSBAG V2.0")) {
    return {Format::kRos1Bag, {}};
  }
  if (begins_with(head, "#ROSBAG V")) {
    return other(text_of_old_bag(head, path));
  }
  if (begins_with(head, "SQLite format 3\0"s)) {
    return {Format::kSqlite, {}};
  }
  if (begins_with(head, "\x89MCAP")) {
    return {Format::kMcap, {}};
  }
  if (begins_with(head, "\x28\xB5\x2F\xFD")) {
    return other(
        unpack_with("unzstd", "zstd, as ros2 bag record does with --compression-mode file", path));
  }
  if (begins_with(head, "BZh")) {
    return other(unpack_with("bunzip2", "bzip2", path));
  }
  if (begins_with(head,
                  "\xFD"
                  "7zXZ")) {
    return other(unpack_with("unxz", "xz", path));
  }
  if (is_rawlog(head)) {
    return other(
        "is a rawlog of MRPT; play it with `rosrun mrpt_rawlog rawlog_play` and record "
        "that with `rosbag record -a`");
  }
  return {};
}

RecordingKind kind_by_lines(LogLines& lines) {
  std::string line;
  for (int left = kHeadLines; left > 0 && lines.number() < kMostHeadLines && lines.next(line);
       left -= begins_with(line, "#") ? 0 : 1) {
    if (is_carmen_line(line)) {
      return {Format::kCarmenLog, {}};
    }
    if (is_line_of_numbers(line)) {
      return other(
          "looks like a recording of tinySLAM, numbers alone; write each scan as a line "
          "of CARMEN, `FLASER N ranges x y theta x y theta stamp host stamp`");
    }
  }
  return {};
}

}  // namespace

RecordingKind recording_kind(const std::string& path) {
  const std::string head = head_of(path);
  RecordingKind kind = kind_by_magic(head, path);
  if (kind.format != Format::kOther || !kind.what_to_do.empty()) {
    return kind;
  }
  if (begins_with(head, "\x1F\x8B")) {
    std::string line;
    if (LogLines unpacked(path); unpacked.next(line)) {
      RecordingKind inside = kind_by_magic(line + "\n", path);
      if (inside.format != Format::kOther) {
        return other(unpack_with("gunzip", "gzip", path));
      }
      if (!inside.what_to_do.empty()) {
        return inside;
      }
    }
  }
  LogLines lines(path);
  return kind_by_lines(lines);
}

}  // namespace matchbox_slam
