#include "io/text_columns.hpp"

#include <fmt/core.h>

#include <optional>
#include <sstream>
#include <utility>

#include "common/number_text.hpp"
#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/io/file.hpp"

namespace matchbox_slam {
namespace {

std::string without_comment(const std::string& line) { return line.substr(0, line.find('#')); }

std::vector<std::string> words_of(const std::string& line) {
  std::istringstream stream(without_comment(line));
  std::vector<std::string> words;
  for (std::string word; stream >> word;) {
    words.push_back(word);
  }
  return words;
}

/// What stands between the separators, without the white space around it.
std::vector<std::string> cells_of(const std::string& line, char separator) {
  std::vector<std::string> cells = split(without_comment(line), separator);
  for (std::string& cell : cells) {
    cell.erase(0, cell.find_first_not_of(" \t\r"));
    cell.erase(cell.find_last_not_of(" \t\r") + 1);
  }
  return cells;
}

}  // namespace

void TextPlace::fail(const std::string& text) const {
  throw FileError(fmt::format("{}:{}: {}", source, line, text));
}

void for_each_row(const std::string& text, const std::string& source, const TextFormat& format,
                  const std::function<void(const std::vector<double>&, const TextPlace&)>& use) {
  std::istringstream stream(text);
  TextPlace place{source, 0};
  for (std::string line; std::getline(stream, line);) {
    ++place.line;
    std::vector<std::string> words = words_of(line);
    if (words.empty()) {
      continue;
    }
    if (format.separator != ' ') {
      words = cells_of(line, format.separator);
    }
    if (words.size() != format.columns.size()) {
      place.fail(fmt::format("has {} columns{}", words.size(), format.text));
    }
    std::vector<double> row;
    for (const std::string& word : words) {
      const std::optional<double> number = finite_number(word);
      if (!number) {
        place.fail(
            fmt::format("{} is '{}', not a finite number", format.columns[row.size()], word));
      }
      row.push_back(*number);
    }
    use(row, place);
  }
}

Trajectory read_trajectory(
    const std::string& text, const std::string& source, const TextFormat& format,
    const std::function<StampedPose2(const std::vector<double>&, const TextPlace&)>& pose_of) {
  std::vector<StampedPose2> poses;
  for_each_row(text, source, format, [&](const std::vector<double>& row, const TextPlace& place) {
    poses.push_back(pose_of(row, place));
  });
  try {
    return Trajectory(std::move(poses));
  } catch (const EvaluationError& error) {
    throw FileError(fmt::format("{}: {}", source, error.what()));
  }
}

bool has_separator(const std::string& text, char separator) {
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    if (!words_of(line).empty()) {
      return without_comment(line).find(separator) != std::string::npos;
    }
  }
  return false;
}

}  // namespace matchbox_slam
