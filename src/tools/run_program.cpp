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

int complain(const CLI::App& app, std::string text, int exit_code) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  std::cerr << app.get_name() << ": " << text << std::endl;
  return exit_code;
}

}  // namespace

int run_program(CLI::App& app, int argc, const char* const* argv,
                const std::function<void()>& work) {
  try {
    app.parse(argc, argv);
    work();
    return kSuccess;
  } catch (const CLI::Success& request) {  // --help
    return app.exit(request);
  } catch (const CLI::ParseError& error) {
    return complain(app, error.what() + std::string("; see --help"), kWrongUsage);
  } catch (const ConfigurationError& error) {
    return complain(app, error.what(), kWrongUsage);
  } catch (const std::exception& error) {
    return complain(app, error.what(), kWorkFailed);
  }
}

}  // namespace matchbox_slam
