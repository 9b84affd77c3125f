#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace matchbox_slam {

/// Where in which file of text, for errors.
struct TextPlace {
  const std::string& source;
  std::size_t line;

  /// Throws FileError: source, line, and what is wrong there.
  [[noreturn]] void fail(const std::string& text) const;
};

/// The words of a line between white space, without what stands behind a '#'.
[[nodiscard]] std::vector<std::string> words_of(const std::string& line);

/// The number that `word` is, whatever the locale. Throws FileError naming place and column when it
/// is none, or not finite.
[[nodiscard]] double read_finite_number(const std::string& word, const std::string& column,
                                        const TextPlace& place);

}  // namespace matchbox_slam
