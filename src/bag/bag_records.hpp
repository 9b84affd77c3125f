#pragma once

#include <fmt/core.h>

#include <cstdint>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "bag/bag_error.hpp"
#include "bag/byte_reader.hpp"

namespace matchbox_slam {

/// What kind of record a bag of version 2.0 holds (wiki.ros.org/Bags/Format/2.0).
enum class BagOperation : std::uint8_t {
  kMessage = 0x02,
  kBagHeader = 0x03,
  kIndex = 0x04,
  kChunk = 0x05,
  kChunkInfo = 0x06,
  kConnection = 0x07
};

/// The fields of a record's header: name=value, each after its length. Members throw ByteError.
class BagFields {
 public:
  explicit BagFields(ByteReader bytes);

  [[nodiscard]] const std::string& text(const std::string& name) const;

  template <typename Number>
  [[nodiscard]] Number number(const std::string& name) const {
    const std::string& bytes = text(name);
    if (bytes.size() != sizeof(Number)) {
      throw ByteError(fmt::format("field '{}' of a header has {} bytes, not {}", name, bytes.size(),
                                  sizeof(Number)));
    }
    Number value{};
    std::memcpy(&value, bytes.data(), sizeof(Number));
    return value;
  }

  [[nodiscard]] BagOperation operation() const;
  void require(BagOperation operation) const;

 private:
  std::map<std::string, std::string> values_;
};

/// A record of the file: a header, and data that may be large.
struct BagRecord {
  BagFields fields;
  std::uint64_t data = 0;  ///< position
  std::uint32_t data_size = 0;

  [[nodiscard]] std::uint64_t end() const { return data + data_size; }
};

/// Reads records of a bag file from where they are. Throws ByteError where they would go beyond the
/// end of the file, or cannot be.
class BagRecordReader {
 public:
  /// Throws BagError when the file cannot be opened.
  explicit BagRecordReader(const std::string& path);

  [[nodiscard]] BagRecord read(std::uint64_t position, BagOperation operation);
  [[nodiscard]] std::vector<std::uint8_t> data_of(const BagRecord& record);

  /// Of the record that was read last.
  [[nodiscard]] std::uint64_t position() const { return position_; }

 private:
  [[nodiscard]] std::vector<std::uint8_t> bytes(std::uint64_t position, std::uint32_t count);
  [[nodiscard]] std::uint32_t length(std::uint64_t position);

  std::ifstream stream_;
  std::uint64_t size_ = 0;
  std::uint64_t position_ = 0;
};

}  // namespace matchbox_slam
