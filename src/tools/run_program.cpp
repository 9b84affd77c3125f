#include "tools/run_program.hpp"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/interrupted.hpp"
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

/// Whether standard output is a pipe that nobody reads any more, as before `| head`.
bool has_no_reader() {
  pollfd output{STDOUT_FILENO, POLLOUT, 0};
  return ::poll(&output, 1, 0) == 1 && (output.revents & POLLERR) != 0;
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
    declare_options(app);
    try {
      app.parse(argc, argv);
    } catch (const CLI::Success& request) {  // --help
      const int exit_code = app.exit(request);
      require_printed();
      return exit_code;
    } catch (const CLI::RequiredError& error) {
      const std::vector<std::string> unknown = app.remaining(true);
      if (unknown.empty()) {
        throw;
      }
      // One of these may be what is missed, with a slip of the pen.
      throw ConfigurationError(error.what() + std::string("; ") + CLI::ExtrasError(unknown).what() +
                               "; see --help");
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
