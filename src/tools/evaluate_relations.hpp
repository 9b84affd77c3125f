#pragma once

#include <CLI/CLI.hpp>

namespace matchbox_slam {

/// Adds `relations EST.tum... --relations FILE` to the program; its callback prints the results to
/// stdout. The callback throws FileError, EvaluationError and ConfigurationError.
void add_relations_command(CLI::App& app);

}  // namespace matchbox_slam
