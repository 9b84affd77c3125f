#include "common/known_names.hpp"

#include <algorithm>
#include <cstddef>
#include <numeric>

#include "matchbox_slam/common/options.hpp"

namespace matchbox_slam {
namespace {

/// Number of letters to insert, remove or replace to turn one text into the other (Levenshtein).
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, diagonal + 1});
    }
  }
  return row[b.size()];
}

}  // namespace

std::string nearest_name(const std::string& name, const std::vector<std::string>& known) {
  constexpr std::size_t kMinLetters = 3;  // letters that are no slip of the pen
  const auto begins = [&name](const std::string& one) { return one.rfind(name, 0) == 0; };
  if (name.size() >= kMinLetters && std::count_if(known.begin(), known.end(), begins) == 1) {
    return *std::find_if(known.begin(), known.end(), begins);
  }
  std::string nearest;
  std::size_t least = std::max<std::size_t>(2, name.size() / 3) + 1;
  for (const std::string& candidate : known) {
    const std::size_t distance = edit_distance(name, candidate);
    if (distance < least) {
      least = distance;
      nearest = candidate;
    }
  }
  return nearest;
}

std::string unknown_name_text(const std::string& kind, const std::string& name,
                              const std::vector<std::string>& meant,
                              const std::vector<std::string>& known) {
  std::string question = ".";
  if (!meant.empty()) {
    question = "; did you mean ";
    for (const std::string& one : meant) {
      question += (&one == &meant.front() ? "'" : " or '") + one + "'";
    }
    question += "?";
  }
  return "unknown " + kind + " '" + name + "'" + question +
         (known.empty() ? " It takes none." : " Known: " + join(known) + ".");
}

}  // namespace matchbox_slam
