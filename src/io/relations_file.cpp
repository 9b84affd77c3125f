#include "io/relations_file.hpp"

#include "io/text_columns.hpp"
#include "matchbox_slam/io/file.hpp"

namespace matchbox_slam {

std::vector<Relation> parse_relations(const std::string& text, const std::string& source) {
  const TextFormat format{{"stamp1", "stamp2", "x", "y", "z", "roll", "pitch", "yaw"},
                          "; a relation has 8: stamp1 stamp2 x y z roll pitch yaw"};
  std::vector<Relation> relations;
  for_each_row(text, source, format, [&](const std::vector<double>& row, const TextPlace&) {
    relations.push_back({row[0], row[1], {row[2], row[3], wrap_angle(row[7])}});
  });
  return relations;
}

std::vector<Relation> read_relations(const std::string& path) {
  return parse_relations(read_file(path), path);
}

}  // namespace matchbox_slam
