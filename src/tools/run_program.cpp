#include "run_program.hpp"

#include <algorithm>
#include <iostream>
#include <string>

#include "matchbox_slam/common/options.hpp"

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

}  // namespace

int run_program(const std::string& name, const std::string& description,
                const std::function<void(CLI::App&)>& declare_options, int argc,
                const char* const* argv, const std::function<void()>& work) {
  try {
    CLI::App app(description, name);
    declare_options(app);
    try {
      app.parse(argc, argv);
    } catch (const CLI::Success& request) {  // --help
      return app.exit(request);
    }
    work();
    return kSuccess;
  } catch (const CLI::ParseError& error) {
    return complain(name, error.what() + std::string("; see --help"), kWrongUsage);
  } catch (const ConfigurationError& error) {
    return complain(name, error.what(), kWrongUsage);
  } catch (const std::exception& error) {
    return complain(name, error.what(), kWorkFailed);
  }
}

}  // namespace matchbox_slam
