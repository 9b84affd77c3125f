#pragma once

#include <CLI/CLI.hpp>

namespace matchbox_slam {

/// Adds `rpe EST.tum... --truth FILE` to the program; its callback prints the results to stdout.
/// The callback throws FileError, EvaluationError and ConfigurationError.
void add_rpe_command(CLI::App& app);

}  // namespace matchbox_slam
