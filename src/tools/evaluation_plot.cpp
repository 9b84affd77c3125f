#include "tools/evaluation_plot.hpp"

#include <fmt/core.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>
#include <system_error>

#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/io/file.hpp"
#include "tools/json_text.hpp"

namespace matchbox_slam {
namespace {

namespace fs = std::filesystem;

std::string reason(int error) { return std::generic_category().message(error); }

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

/// Files rather than pipes: neither side ever waits for the other to read.
File temporary_file() {
  File file(std::tmpfile());
  if (!file) {
    throw FileError("cannot create a temporary file: " + reason(errno));
  }
  return file;
}

File temporary_file_with(const std::string& contents) {
  File file = temporary_file();
  if (std::fwrite(contents.data(), 1, contents.size(), file.get()) != contents.size() ||
      std::fflush(file.get()) != 0) {
    throw FileError("cannot write a temporary file: " + reason(errno));
  }
  std::rewind(file.get());
  return file;
}

std::string contents_of(std::FILE* file) {
  std::rewind(file);
  std::string contents;
  std::array<char, 65536> buffer{};
  for (std::size_t count = 0; (count = std::fread(buffer.data(), 1, buffer.size(), file)) > 0;) {
    contents.append(buffer.data(), count);
  }
  return contents;
}

std::string last_line(std::string text) {
  text.erase(text.find_last_not_of(" \r\n") + 1);
  const std::size_t end = text.find_last_of('\n');
  return end == std::string::npos ? text : text.substr(end + 1);
}

std::string plot_program() {
  return (fs::read_symlink("/proc/self/exe").parent_path() / "plot_evaluation").string();
}

/// Runs a program without a shell and waits for it. Returns its exit code, -1 for a signal.
int run(const std::string& program, std::FILE* input, std::FILE* output, std::FILE* errors) {
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_adddup2(&actions, ::fileno(input), STDIN_FILENO);
  ::posix_spawn_file_actions_adddup2(&actions, ::fileno(output), STDOUT_FILENO);
  ::posix_spawn_file_actions_adddup2(&actions, ::fileno(errors), STDERR_FILENO);
  std::string name = program;
  std::array<char*, 2> arguments = {name.data(), nullptr};
  pid_t child = 0;
  const int error =
      ::posix_spawn(&child, program.c_str(), &actions, nullptr, arguments.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  if (error != 0) {
    throw FileError(
        fmt::format("cannot run '{}', which needs /usr/bin/python3: {}", program, reason(error)));
  }
  int status = 0;
  while (::waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) {
      throw FileError(fmt::format("lost sight of '{}': {}", program, reason(errno)));
    }
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

void draw(const std::string& path, const nlohmann::json& figure) {
  const File input = temporary_file_with(json_text(figure, -1));
  const File output = temporary_file();
  const File errors = temporary_file();
  if (run(plot_program(), input.get(), output.get(), errors.get()) != 0) {
    throw FileError(
        fmt::format("cannot draw '{}': {}", path, last_line(contents_of(errors.get()))));
  }
  replace_file(path, contents_of(output.get()));
}

}  // namespace

void add_output_options(CLI::App& command, OutputOptions& options) {
  command.add_flag("--json", options.json, "Print JSON instead of a table");
  command.add_option("--plot", options.plot, "Also draw a picture")->type_name("FILE.png");
}

void require_plot_file(const std::string& path) {
  if (path.empty()) {
    return;
  }
  if (fs::path(path).extension() != ".png") {
    throw ConfigurationError(
        fmt::format("--plot: '{}' is not allowed; allowed: a name in .png", path));
  }
  require_writable_file(path);
}

void present(const OutputOptions& options, const nlohmann::json& json, const std::string& text,
             const std::function<nlohmann::json()>& figure) {
  if (!options.plot.empty()) {
    draw(options.plot, figure());
  }
  std::cout << (options.json ? json_text(json) + "\n" : text) << std::flush;
}

}  // namespace matchbox_slam
