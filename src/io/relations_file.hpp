#pragma once

#include <string>
#include <vector>

#include "evaluation/relation_error.hpp"

namespace matchbox_slam {

/// Reads relations as the benchmark of Kümmerle et al. 2009 ships them: one line a relation,
/// `stamp1 stamp2 x y z roll pitch yaw`, seconds, metres and radians: the pose at stamp2 as seen
/// from the pose at stamp1. Lines may be empty, or comments from '#' on. Of a relation in space
/// x, y and yaw are kept. A text without relations gives none.
/// @param source  names the text in errors, such as the file's path.
/// Throws FileError with source and line for a line of another form and numbers that are not
/// finite.
[[nodiscard]] std::vector<Relation> parse_relations(const std::string& text,
                                                    const std::string& source);

/// Reads a file; throws FileError also when that is not possible.
[[nodiscard]] std::vector<Relation> read_relations(const std::string& path);

}  // namespace matchbox_slam
