// Runs the conformance suite over scan matchers that are installed as plugins, also those of users.

#include <gtest/gtest.h>
#include <ros/init.h>

#include <algorithm>
#include <cstddef>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "common/version.hpp"
#include "matching/matcher_conformance.hpp"
#include "ros/matcher_loader.hpp"

namespace {

using matchbox_slam::ConfigurationError;
using matchbox_slam::MatcherLoader;

constexpr const char* kHelp =
    "Tests that scan matchers keep the promises of matchbox_slam::ScanMatcher.\n"
    "\n"
    "  rosrun matchbox_slam matcher_conformance [MATCHER|PACKAGE]... [--gtest_filter=PATTERN]...\n"
    "\n"
    "  MATCHER   such as my_package/MyMatcher or my_matcher\n"
    "  PACKAGE   all matchers that it declares; without arguments those of every package\n"
    "\n"
    "--version prints the version. Exits 0 when all tests passed, 1 when one failed, 2 for a "
    "matcher or a test that cannot be\n"
    "found.\n"
    "The other options are GoogleTest's:\n";

bool is_help(const std::string& argument) { return argument == "--help" || argument == "-h"; }

/// Lookup names of what was asked for, in order.
std::vector<std::string> chosen_matchers(const MatcherLoader& loader,
                                         const std::vector<std::string>& arguments) {
  if (arguments.empty()) {
    return loader.lookup_names();
  }
  std::vector<std::string> chosen;
  for (const std::string& argument : arguments) {
    const std::size_t before = chosen.size();
    for (const std::string& name : loader.lookup_names()) {
      if (name.rfind(argument + "/", 0) == 0) {
        chosen.push_back(name);
      }
    }
    if (chosen.size() == before) {
      chosen.push_back(loader.find(argument));
    }
  }
  return chosen;
}

}  // namespace

int main(int argc, char** argv) {
  if (std::find(argv + 1, argv + argc, std::string("--version")) != argv + argc) {
    std::cout << matchbox_slam::version_text("matcher_conformance") << std::endl;
    return 0;
  }
  if (std::any_of(argv + 1, argv + argc, is_help)) {
    std::cout << kHelp << std::flush;
    testing::InitGoogleTest(&argc, argv);
    return RUN_ALL_TESTS();  // shows GoogleTest's help instead of running anything
  }
  testing::InitGoogleTest(&argc, argv);  // takes its own options out
  std::vector<std::string> arguments;
  ros::removeROSArgs(argc, argv, arguments);  // of rostest, such as __name:=conformance
  arguments.erase(arguments.begin());         // the program
  // Gone at the end of main: what GoogleTest keeps outlives class_loader's list of libraries.
  std::unique_ptr<const MatcherLoader> loader;
  try {
    for (const std::string& argument : arguments) {
      if (argument.rfind('-', 0) == 0) {
        throw ConfigurationError("unknown option " + argument + "; see --help");
      }
    }
    loader = std::make_unique<MatcherLoader>();
    const std::vector<std::string> names = chosen_matchers(*loader, arguments);
    if (names.empty()) {
      throw ConfigurationError("no package declares a scan matcher");
    }
    for (const std::string& name : names) {
      (void)loader->create(name);  // one clear line now, rather than as many as there are tests
      matchbox_slam::register_matcher_conformance(
          name, [loader = loader.get(), name] { return loader->create(name); });
    }
  } catch (const ConfigurationError& error) {
    std::cerr << "matcher_conformance: " << error.what() << '\n';
    return 2;
  }
  const int exit_code = RUN_ALL_TESTS();
  if (testing::UnitTest::GetInstance()->test_to_run_count() == 0) {
    std::cerr << "matcher_conformance: no test matches --gtest_filter="
              << testing::GTEST_FLAG(filter) << "; see --gtest_list_tests\n";
    return 2;
  }
  return exit_code;
}
