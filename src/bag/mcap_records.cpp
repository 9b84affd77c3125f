#include "bag/mcap_records.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "bag/bag_error.hpp"

namespace matchbox_slam {
namespace {

constexpr std::size_t kHead = 1 + sizeof(std::uint64_t);  // of a record: operation and length

}  // namespace

McapRecordReader::McapRecordReader(const std::string& path) : stream_(path, std::ios::binary) {
  if (!stream_) {
    throw BagError(
        fmt::format("bag '{}' cannot be opened: {}", path, std::generic_category().message(errno)));
  }
  stream_.seekg(0, std::ios::end);
  size_ = static_cast<std::uint64_t>(stream_.tellg());
}

Bytes McapRecordReader::bytes(std::uint64_t position, std::uint64_t count) {
  Bytes bytes(std::min(count, size_ - std::min(position, size_)));
  stream_.clear();
  stream_.seekg(static_cast<std::streamoff>(position));
  // Streams read characters. NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast)
  stream_.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!stream_) {
    throw ByteError("the file cannot be read there");
  }
  return bytes;
}

std::optional<McapRecord> McapRecordReader::read(std::uint64_t position) {
  if (position >= size_) {
    return std::nullopt;
  }
  const Bytes head = bytes(position, kHead);
  ByteReader reader(head.data(), head.size());
  McapRecord record;
  record.operation = static_cast<McapOperation>(reader.number<std::uint8_t>());
  record.content = position + kHead;
  record.size = reader.number<std::uint64_t>();
  record.is_cut = record.size > size_ - record.content;
  return record;
}

McapSchema parse_mcap_schema(ByteReader bytes) {
  McapSchema schema;
  schema.id = bytes.number<std::uint16_t>();
  schema.name = bytes.array().text();
  return schema;
}

McapChannel parse_mcap_channel(ByteReader bytes) {
  McapChannel channel;
  channel.id = bytes.number<std::uint16_t>();
  channel.schema = bytes.number<std::uint16_t>();
  channel.topic = bytes.array().text();
  channel.encoding = bytes.array().text();
  for (ByteReader metadata = bytes.array(); !metadata.empty();) {
    const std::string key = metadata.array().text();
    const std::string value = metadata.array().text();
    channel.md5sum = key == "md5sum" ? value : channel.md5sum;
  }
  return channel;
}

McapMessage parse_mcap_message(ByteReader bytes) {
  McapMessage message;
  message.channel = bytes.number<std::uint16_t>();
  (void)bytes.number<std::uint32_t>();  // its number
  // A bag of ROS 1 knows no time 0.
  message.time = std::max<std::uint64_t>(bytes.number<std::uint64_t>(), 1);
  (void)bytes.number<std::uint64_t>();  // when it was sent
  message.data = bytes;
  return message;
}

}  // namespace matchbox_slam
