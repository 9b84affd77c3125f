#pragma once

#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <string>

namespace matchbox_slam {

/// What a program did.
struct Outcome {
  int exit_code = -1;  ///< -1 when it did not run
  std::string output;  ///< of stdout and stderr
};

/// Runs a program with arguments as a shell takes them.
[[nodiscard]] inline Outcome run_command(const std::string& program, const std::string& arguments) {
  const std::string command = "'" + program + "' " + arguments + " 2>&1";
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

}  // namespace matchbox_slam
