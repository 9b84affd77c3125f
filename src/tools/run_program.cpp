#include "tools/run_program.hpp"

#include <fmt/core.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/interrupted.hpp"
#include "common/known_names.hpp"
#include "common/version.hpp"
#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/io/file.hpp"

namespace matchbox_slam {
namespace {

constexpr int kSuccess = 0;
constexpr int kWorkFailed = 1;
constexpr int kWrongUsage = 2;

int complain(const std::string& name, std::string text, int exit_code) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  std::cerr << name << ": " << text << std::endl;
  return exit_code;
}

void add_flags(const CLI::App& app, std::vector<std::string>& flags) {
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) {
      flags.push_back("--" + name);
    }
  }
  for (const CLI::App* asked : app.get_subcommands()) {
    add_flags(*asked, flags);
  }
}

/// That arguments were not expected, of the first that is near to an option which was meant, and
/// where to look.
std::string text_of_unexpected(const CLI::App& app) {
  const std::vector<std::string> unknown = app.remaining(true);
  std::vector<std::string> flags;
  add_flags(app, flags);
  const std::string text = CLI::ExtrasError(unknown).what();
  for (const std::string& argument : unknown) {
    const std::string meant = argument.compare(0, 2, "--") == 0
                                  ? nearest_name(argument.substr(0, argument.find('=')), flags)
                                  : "";
    if (!meant.empty()) {
      return fmt::format("{}; did you mean {}? See --help", text, meant);
    }
  }
  return text + "; see --help";
}

/// Whether standard output is a pipe that nobody reads any more, as before `| head`.
bool has_no_reader() {
  pollfd output{STDOUT_FILENO, POLLOUT, 0};
  return ::poll(&output, 1, 0) == 1 && (output.revents & POLLERR) != 0;
}

/// Lets --help tell what options are that are not given.
void tell_defaults(CLI::App& app) {
  for (CLI::Option* option : app.get_options()) {
    option->capture_default_str();
    if (option->get_default_str() == "[]") {
      option->default_str("");
    }
  }
  for (CLI::App* command : app.get_subcommands([](const CLI::App* /*any*/) { return true; })) {
    tell_defaults(*command);
  }
}

/// What was printed may still be in the stream's buffer.
void require_printed() {
  if (!std::cout.flush() && !has_no_reader()) {
    throw std::runtime_error("cannot write to standard output; is the disk full?");
  }
}

}  // namespace

int run_program(const std::string& name, const std::string& description,
                const std::function<void(CLI::App&)>& declare_options, int argc,
                const char* const* argv, const std::function<void()>& work) {
  std::signal(SIGPIPE, SIG_IGN);  // whoever stops reading does not want the work to stop
  try {
    CLI::App app(description, name);
    app.set_version_flag("--version", version_text(name), "Print the version and exit");
    app.footer(
        fmt::format("Exits with {} when done, {} where the work failed, {} for wrong usage or "
                    "settings, or a file that is not there.",
                    kSuccess, kWorkFailed, kWrongUsage));
    declare_options(app);
    tell_defaults(app);
    try {
      app.parse(argc, argv);
    } catch (const CLI::Success& request) {  // --help, --version
      const int exit_code = app.exit(request);
      require_printed();
      return exit_code;
    } catch (const CLI::RequiredError& error) {
      if (app.remaining(true).empty()) {
        throw;
      }
      // One of these may be what is missed, with a slip of the pen.
      throw ConfigurationError(fmt::format("{}; {}", error.what(), text_of_unexpected(app)));
    } catch (const CLI::ExtrasError&) {
      throw ConfigurationError(text_of_unexpected(app));
    }
    work();
    require_printed();
    return kSuccess;
  } catch (const Interrupted& interrupted) {
    return complain(name, interrupted.what(), kSuccess);
  } catch (const CLI::ParseError& error) {
    return complain(name, error.what() + std::string("; see --help"), kWrongUsage);
  } catch (const ConfigurationError& error) {
    return complain(name, error.what(), kWrongUsage);
  } catch (const MissingFile& error) {  // bags that are not there are wrong usage, too
    return complain(name, error.what(), kWrongUsage);
  } catch (const std::exception& error) {
    return complain(name, error.what(), kWorkFailed);
  }
}

}  // namespace matchbox_slam
