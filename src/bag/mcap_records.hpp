#pragma once

#include <cstdint>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "bag/byte_reader.hpp"
#include "bag/unpacking.hpp"

namespace matchbox_slam {

/// What kind of record an MCAP file holds (mcap.dev/spec).
enum class McapOperation : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kDataEnd = 0x0F
};

/// Where a record of the file is.
struct McapRecord {
  McapOperation operation{};
  std::uint64_t content = 0;  ///< position
  std::uint64_t size = 0;     ///< of the content as it is announced [bytes]
  bool is_cut = false;        ///< the file ends within it

  [[nodiscard]] std::uint64_t end() const { return content + size; }
};

/// The type of a channel's messages.
struct McapSchema {
  std::uint32_t id = 0;
  std::string name;
};

struct McapChannel {
  std::uint32_t id = 0;
  std::uint32_t schema = 0;
  std::string topic;
  std::string encoding;  ///< of its messages, such as "cdr"
  std::string md5sum;    ///< of a channel of ROS 1; else empty
};

/// A message within bytes that hold records.
struct McapMessage {
  std::uint32_t channel = 0;
  std::uint64_t time = 0;  ///< at which it was recorded [ns]
  ByteReader data;
};

/// Reads records of a file. Members throw ByteError where they cannot be.
class McapRecordReader {
 public:
  /// Throws BagError when the file cannot be opened.
  explicit McapRecordReader(const std::string& path);

  [[nodiscard]] std::uint64_t size() const { return size_; }

  /// The record at a place; none at the end of the file.
  [[nodiscard]] std::optional<McapRecord> read(std::uint64_t position);

  /// So many bytes, or those that there are until the end of the file.
  [[nodiscard]] Bytes bytes(std::uint64_t position, std::uint64_t count);

 private:
  std::ifstream stream_;
  std::uint64_t size_ = 0;
};

// Parse the contents of records. Throw ByteError.

[[nodiscard]] McapSchema parse_mcap_schema(ByteReader bytes);
[[nodiscard]] McapChannel parse_mcap_channel(ByteReader bytes);
[[nodiscard]] McapMessage parse_mcap_message(ByteReader bytes);

/// Calls `visit(operation, content)` with each record within bytes. Returns whether they end with
/// the end of one.
template <typename Visit>
bool visit_mcap_records(ByteReader bytes, const Visit& visit) {
  constexpr std::size_t kHead = 1 + sizeof(std::uint64_t);
  while (bytes.size() >= kHead) {
    const auto operation = static_cast<McapOperation>(bytes.number<std::uint8_t>());
    const auto size = bytes.number<std::uint64_t>();
    if (size > bytes.size()) {
      return false;
    }
    visit(operation, bytes.take(size));
  }
  return bytes.empty();
}

}  // namespace matchbox_slam
