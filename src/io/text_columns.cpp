#include "io/text_columns.hpp"

#include <sstream>

#include "common/number_text.hpp"
#include "matchbox_slam/io/file.hpp"

namespace matchbox_slam {

void TextPlace::fail(const std::string& text) const {
  throw FileError(source + ":" + std::to_string(line) + ": " + text);
}

std::vector<std::string> words_of(const std::string& line) {
  std::istringstream stream(line.substr(0, line.find('#')));
  std::vector<std::string> words;
  for (std::string word; stream >> word;) {
    words.push_back(word);
  }
  return words;
}

double read_finite_number(const std::string& word, const std::string& column,
                          const TextPlace& place) {
  const std::optional<double> number = finite_number(word);
  if (!number) {
    place.fail(column + " is '" + word + "', not a finite number");
  }
  return *number;
}

}  // namespace matchbox_slam
