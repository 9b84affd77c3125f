#include "io/relations_file.hpp"

#include <array>
#include <cstddef>
#include <sstream>

#include "io/text_columns.hpp"
#include "matchbox_slam/io/file.hpp"

namespace matchbox_slam {
namespace {

constexpr std::size_t kColumnCount = 8;
constexpr std::array<const char*, kColumnCount> kColumns = {"stamp1", "stamp2", "x",     "y",
                                                            "z",      "roll",   "pitch", "yaw"};

Relation read_line(const std::vector<std::string>& words, const TextPlace& place) {
  if (words.size() != kColumnCount) {
    place.fail("has " + std::to_string(words.size()) +
               " columns; a relation has 8: stamp1 stamp2 x y z roll pitch yaw");
  }
  std::array<double, kColumnCount> row{};
  for (std::size_t i = 0; i < kColumnCount; ++i) {
    row[i] = read_finite_number(words[i], kColumns[i], place);
  }
  return {row[0], row[1], {row[2], row[3], wrap_angle(row[7])}};
}

}  // namespace

std::vector<Relation> parse_relations(const std::string& text, const std::string& source) {
  std::vector<Relation> relations;
  std::istringstream stream(text);
  std::size_t number = 0;
  for (std::string line; std::getline(stream, line);) {
    ++number;
    const std::vector<std::string> words = words_of(line);
    if (!words.empty()) {
      relations.push_back(read_line(words, {source, number}));
    }
  }
  return relations;
}

std::vector<Relation> read_relations(const std::string& path) {
  return parse_relations(read_file(path), path);
}

}  // namespace matchbox_slam
