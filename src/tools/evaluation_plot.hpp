#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

namespace matchbox_slam {

/// How a command of evaluate tells its results.
struct OutputOptions {
  bool json = false;  ///< instead of a table
  std::string plot;   ///< empty: none
};

/// Adds `--json` and `--plot FILE.png` to a command.
void add_output_options(CLI::App& command, OutputOptions& options);

/// To be called before the work whose result is to be drawn; does nothing for an empty path.
/// Throws ConfigurationError when the name does not end in .png, FileError when no such file can be
/// written.
void require_plot_file(const std::string& path);

/// Prints the results to stdout, and draws their figure where that is asked for: the program
/// `plot_evaluation`, which lies beside this one, makes a PNG file of it, which is written
/// atomically. `scripts/plot_evaluation.py` says what a figure consists of.
/// @param text  heading and table.
/// Throws FileError when it cannot be drawn or written; the text says why.
void present(const OutputOptions& options, const nlohmann::json& json, const std::string& text,
             const std::function<nlohmann::json()>& figure);

}  // namespace matchbox_slam
