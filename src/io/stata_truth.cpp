#include "io/stata_truth.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <sstream>
#include <utility>
#include <vector>

#include "io/text_columns.hpp"
#include "matchbox_slam/io/file.hpp"

namespace matchbox_slam {
namespace {

constexpr std::size_t kColumnCount = 4;
constexpr std::array<const char*, kColumnCount> kColumns = {"stamp", "x", "y", "theta"};
constexpr double kMicrosecondsPerSecond = 1e6;

/// What stands between the commas, without the white space around it.
std::vector<std::string> cells_of(const std::string& line) {
  const std::string contents = line.substr(0, line.find('#')) + ',';
  std::vector<std::string> cells;
  std::istringstream stream(contents);
  for (std::string cell; std::getline(stream, cell, ',');) {
    const std::size_t first = cell.find_first_not_of(" \t\r");
    const std::size_t last = cell.find_last_not_of(" \t\r");
    cells.push_back(first == std::string::npos ? "" : cell.substr(first, last - first + 1));
  }
  return cells;
}

StampedPose2 read_line(const std::vector<std::string>& cells, const TextPlace& place) {
  if (cells.size() != kColumnCount) {
    place.fail("has " + std::to_string(cells.size()) +
               " columns between commas; ground truth of MIT Stata has 4: stamp,x,y,theta (a TUM "
               "trajectory has 8, between blanks)");
  }
  std::array<double, kColumnCount> row{};
  for (std::size_t i = 0; i < kColumnCount; ++i) {
    row[i] = read_finite_number(cells[i], kColumns[i], place);
  }
  const auto& [stamp, x, y, theta] = row;
  if (stamp != std::floor(stamp)) {
    place.fail("stamp is '" + cells[0] + "'; ground truth of MIT Stata has whole microseconds");
  }
  return {stamp / kMicrosecondsPerSecond, {x, y, wrap_angle(theta)}};
}

}  // namespace

bool looks_like_stata_truth(const std::string& text) {
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    if (!words_of(line).empty()) {
      return line.substr(0, line.find('#')).find(',') != std::string::npos;
    }
  }
  return false;
}

Trajectory parse_stata_truth(const std::string& text, const std::string& source) {
  std::vector<StampedPose2> poses;
  std::istringstream stream(text);
  std::size_t number = 0;
  for (std::string line; std::getline(stream, line);) {
    ++number;
    if (!words_of(line).empty()) {
      poses.push_back(read_line(cells_of(line), {source, number}));
    }
  }
  try {
    return Trajectory(std::move(poses));
  } catch (const EvaluationError& error) {
    throw FileError(source + ": " + error.what());
  }
}

}  // namespace matchbox_slam
