#pragma once

#include <sys/wait.h>

#include <array>
#include <cstddef>
#include <cstdio>
#include <string>

namespace matchbox_slam {

/// How a program ended.
struct Outcome {
  int exit_code = -1;
  std::string output;  ///< of stdout and stderr
};

/// Runs the program `evaluate` with arguments for the shell.
inline Outcome run_evaluate(const std::string& arguments) {
  const std::string command = std::string("'") + MATCHBOX_EVALUATE + "' " + arguments + " 2>&1";
  Outcome outcome;
  FILE* pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) {
    return outcome;
  }
  std::array<char, 4096> buffer{};
  for (std::size_t count = 0; (count = std::fread(buffer.data(), 1, buffer.size(), pipe)) > 0;) {
    outcome.output.append(buffer.data(), count);
  }
  outcome.exit_code = WEXITSTATUS(::pclose(pipe));
  return outcome;
}

[[nodiscard]] inline std::size_t line_count(const std::string& text) {
  std::size_t count = 0;
  for (const char c : text) {
    count += c == '\n' ? 1 : 0;
  }
  return count;
}

}  // namespace matchbox_slam
