#pragma once

#include <functional>
#include <string>

namespace matchbox_slam {

/// How long work talks to its user, and how the user stops it. All functions are set.
struct RunDialog {
  std::function<void(const std::string& line)> inform;
  std::function<void(const std::string& line)> warn;
  std::function<void(double fraction, const std::string& text)> show_progress;
  std::function<bool()> is_interrupted;
};

/// A duration for people, such as "12.3 s".
[[nodiscard]] std::string seconds_text(double seconds);

}  // namespace matchbox_slam
