#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <string>

namespace matchbox_slam {

/// Adds `--plot FILE.png` to a command. `path` stays empty when it is not given.
void add_plot_option(CLI::App& command, std::string& path);

/// To be called before the work whose result is to be drawn; does nothing for an empty path.
/// Throws ConfigurationError when the name does not end in .png, FileError when no such file can be
/// written.
void require_plot_file(const std::string& path);

/// Has the program `plot_evaluation`, which lies beside this one, draw a figure, and writes it
/// atomically as a PNG file. `scripts/plot_evaluation.py` says what a figure consists of.
/// Throws FileError when it cannot be drawn or written; the text says why.
void write_plot(const std::string& path, const nlohmann::json& figure);

}  // namespace matchbox_slam
