#pragma once

#include <cstddef>
#include <string>
#include <vector>

// As zlib declares it, so that not all who include this need its headers.
struct gzFile_s;

namespace matchbox_slam {

/// The lines of a text file, which may be packed by gzip.
class LogLines {
 public:
  /// Throws BagError when the file cannot be opened.
  explicit LogLines(const std::string& path);
  LogLines(const LogLines&) = delete;
  LogLines& operator=(const LogLines&) = delete;
  ~LogLines();

  /// The next line without its end; one that is longer than a megabyte comes in pieces of that.
  /// False: there is none.
  [[nodiscard]] bool next(std::string& line);

  /// Of the line that was read last, from 1 on.
  [[nodiscard]] std::size_t number() const { return number_; }
  /// Whether the line that was read last has an end; the last one of a file that is cut off does
  /// not.
  [[nodiscard]] bool has_end() const { return has_end_; }

  /// Why there are no more lines although the file is not at its end; empty: it is.
  [[nodiscard]] const std::string& damage() const { return damage_; }

 private:
  bool fill();

  gzFile_s* file_;
  std::vector<char> buffer_;
  std::size_t at_ = 0;   ///< in the buffer
  std::size_t end_ = 0;  ///< of what is in it
  std::size_t number_ = 0;
  bool has_end_ = true;
  std::string damage_;
};

}  // namespace matchbox_slam
