#include "bag/bag_records.hpp"

#include <fmt/core.h>

#include <cerrno>
#include <system_error>

namespace matchbox_slam {
namespace {

// No recorder comes near it; a length beyond is damage, not worth trying to get the memory.
constexpr std::uint32_t kLongestHeader = 1U << 24U;

}  // namespace

BagFields::BagFields(ByteReader bytes) {
  while (!bytes.empty()) {
    const ByteReader field = bytes.array();
    const std::string text = field.text();
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw ByteError("a field of a header is not name=value");
    }
    values_[text.substr(0, equals)] = text.substr(equals + 1);
  }
}

const std::string& BagFields::text(const std::string& name) const {
  const auto found = values_.find(name);
  if (found == values_.end()) {
    throw ByteError(fmt::format("a header has no field '{}'", name));
  }
  return found->second;
}

BagOperation BagFields::operation() const {
  return static_cast<BagOperation>(number<std::uint8_t>("op"));
}

void BagFields::require(BagOperation expected) const {
  if (operation() != expected) {
    throw ByteError(fmt::format("a record has the operation {} where {} is expected",
                                static_cast<int>(operation()), static_cast<int>(expected)));
  }
}

BagRecordReader::BagRecordReader(const std::string& path) : stream_(path, std::ios::binary) {
  if (!stream_) {
    throw BagError(
        fmt::format("bag '{}' cannot be opened: {}", path, std::generic_category().message(errno)));
  }
  stream_.seekg(0, std::ios::end);
  size_ = static_cast<std::uint64_t>(stream_.tellg());
}

std::vector<std::uint8_t> BagRecordReader::bytes(std::uint64_t position, std::uint32_t count) {
  if (position > size_ || count > size_ - position) {
    throw ByteError("it goes beyond the end of the file, which may be cut off");
  }
  std::vector<std::uint8_t> bytes(count);
  stream_.clear();
  stream_.seekg(static_cast<std::streamoff>(position));
  // Streams read characters. NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast)
  stream_.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(count));
  if (!stream_) {
    throw ByteError("the file cannot be read there");
  }
  return bytes;
}

std::uint32_t BagRecordReader::length(std::uint64_t position) {
  const std::vector<std::uint8_t> read = bytes(position, sizeof(std::uint32_t));
  return ByteReader(read.data(), read.size()).number<std::uint32_t>();
}

BagRecord BagRecordReader::read(std::uint64_t position, BagOperation operation) {
  position_ = position;
  const std::uint32_t header_size = length(position);
  if (header_size > kLongestHeader) {
    throw ByteError(fmt::format("a header is said to have {} bytes", header_size));
  }
  const std::vector<std::uint8_t> header = bytes(position + sizeof(std::uint32_t), header_size);
  const std::uint64_t after_header = position + sizeof(std::uint32_t) + header_size;
  BagRecord record{BagFields(ByteReader(header.data(), header.size())),
                   after_header + sizeof(std::uint32_t), length(after_header)};
  if (record.end() > size_) {
    throw ByteError("it goes beyond the end of the file, which may be cut off");
  }
  record.fields.require(operation);
  return record;
}

std::vector<std::uint8_t> BagRecordReader::data_of(const BagRecord& record) {
  return bytes(record.data, record.data_size);
}

}  // namespace matchbox_slam
