#pragma once

#include <locale>
#include <sstream>
#include <string>
#include <utility>

#include "matchbox_slam/io/file.hpp"

namespace matchbox_slam {

/// Lines of text on their way to a sink, which gets them a page at a time: the texts of a long
/// drive are as large as its map. Numbers are written as in the classic locale. What the sink
/// throws passes through.
class PagedText {
 public:
  explicit PagedText(ByteSink sink) : sink_(std::move(sink)) {
    page_.imbue(std::locale::classic());
  }

  /// For the rest of a line.
  [[nodiscard]] std::ostream& line() { return page_; }

  void end_line() {
    constexpr std::streamoff kPage = 1 << 16;  // [bytes]
    page_ << '\n';
    if (page_.tellp() >= kPage) {
      finish();
    }
  }

  /// Gives what is left to the sink.
  void finish() {
    sink_(page_.str());
    page_.str({});
  }

 private:
  ByteSink sink_;
  std::ostringstream page_;
};

/// All at once of what is written to a sink.
template <typename Write>
[[nodiscard]] std::string text_of_pages(const Write& write) {
  std::string text;
  write([&text](const std::string& page) { text += page; });
  return text;
}

}  // namespace matchbox_slam
