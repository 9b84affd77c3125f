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

/// Runs a program to which a SIGTERM is sent before it begins, which it finds at its first look.
[[nodiscard]] inline Outcome run_interrupted(const std::string& program,
                                             const std::string& arguments) {
  // A signal that is held back stays so when a process becomes another program.
  return run_command("/usr/bin/python3",
                     "-c 'import os, signal, sys\n"
                     "signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGTERM])\n"
                     "os.kill(os.getpid(), signal.SIGTERM)\n"
                     "os.execv(sys.argv[1], sys.argv[1:])' '" +
                         program + "' " + arguments);
}

/// Runs a program that can write no file of more than 512 bytes, as if the disk were full.
[[nodiscard]] inline Outcome run_on_full_disk(const std::string& program,
                                              const std::string& arguments) {
  return run_command(
      "/bin/sh", R"(-c 'trap "" XFSZ; ulimit -f 1; exec "$@"' sh ')" + program + "' " + arguments);
}

}  // namespace matchbox_slam
