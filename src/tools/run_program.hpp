#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace matchbox_slam {

/// What every command-line program does around its work: reads the command line into `app`, runs
/// `work`, and turns what is thrown into one line on stderr and an exit code.
/// Returns 0 on success and for --help, 1 when the work failed, 2 for wrong usage or configuration.
[[nodiscard]] int run_program(CLI::App& app, int argc, const char* const* argv,
                              const std::function<void()>& work);

}  // namespace matchbox_slam
