#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

namespace matchbox_slam {

/// What every command-line program does around its work: declares its options, reads the command
/// line, runs `work`, and turns what is thrown into one line on stderr and an exit code.
/// Returns 0 on success and for --help and --version, 1 when the work failed or cannot be printed,
/// 2 for wrong usage or configuration.
[[nodiscard]] int run_program(const std::string& name, const std::string& description,
                              const std::function<void(CLI::App&)>& declare_options, int argc,
                              const char* const* argv, const std::function<void()>& work);

}  // namespace matchbox_slam
