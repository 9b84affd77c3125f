// Configurations, as files, as --set and as parameters of ROS, that were mutated. Each is either
// refused as a ConfigurationError that says why, or makes a mapping that works.

#include <XmlRpcValue.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <exception>
#include <filesystem>
#include <string>
#include <typeinfo>

#include "fuzz/fuzz.hpp"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/yaml_parameters.hpp"
#include "node/ros_parameters.hpp"
#include "ros/matcher_loader.hpp"
#include "ros/message_conversion.hpp"
#include "ros/messages.hpp"
#include "run/frames.hpp"
#include "run/slam_run.hpp"

namespace matchbox_slam {
namespace {

/// Runs `work`, which may refuse its input. Returns whether it did not.
template <typename Work>
bool accepts(const std::string& input, Work&& work) {
  try {
    work();
    return true;
  } catch (const ConfigurationError& error) {
    EXPECT_NE(std::string(error.what()), "") << input;
  } catch (const std::exception& error) {
    ADD_FAILURE() << typeid(error).name() << ": " << error.what() << "\nof the input:\n" << input;
  }
  return false;
}

const std::vector<std::string>& yaml_words() {
  static const std::vector<std::string> kWords = {"matcher: ",
                                                  "olson",
                                                  "hough",
                                                  "\n",
                                                  ":",
                                                  ": ",
                                                  "{",
                                                  "}",
                                                  "[",
                                                  "]",
                                                  "- ",
                                                  "&a ",
                                                  "*a",
                                                  "<<: *a",
                                                  "!!binary ",
                                                  "!!str ",
                                                  "---\n",
                                                  "...\n",
                                                  "|\n",
                                                  "\"",
                                                  "'",
                                                  "#",
                                                  "%",
                                                  "\t",
                                                  "  ",
                                                  "\xef\xbb\xbf",
                                                  std::string(1, '\0'),
                                                  "\xff",
                                                  "~",
                                                  "null",
                                                  "true",
                                                  ".nan",
                                                  ".inf",
                                                  "-.inf",
                                                  "1e400",
                                                  "1e-400",
                                                  "9223372036854775807",
                                                  "9223372036854775808",
                                                  "-1",
                                                  "0",
                                                  "0x10",
                                                  "0o7",
                                                  "1_000",
                                                  "/",
                                                  "//",
                                                  "map/resolution",
                                                  "map: {resolution: ",
                                                  "scan_time_offset: auto",
                                                  "seed: -1",
                                                  "? ",
                                                  std::string(3000, '[')};
  return kWords;
}

/// Every option of every component with its default, and the files that are shipped.
std::vector<std::string> sound_configurations(const MatcherLoader& loader) {
  std::vector<std::string> texts;
  for (const auto& file :
       std::filesystem::directory_iterator(std::string(MATCHBOX_SOURCE_DIR) + "/config")) {
    texts.push_back(read_file(file.path().string()));
  }
  for (const std::string& matcher : loader.lookup_names()) {
    Parameters parameters;
    parameters.set("matcher", matcher);
    const SlamSetup setup = make_slam_setup(parameters, loader);
    for (const OptionDescription& row : describe_setup(setup)) {
      parameters.set(row.name, row.value);
    }
    texts.push_back(to_yaml(parameters));
  }
  std::sort(texts.begin(), texts.end());  // folders have no order
  return texts;
}

/// A few scans, too small for any configuration to take long over them.
void map_with(const LiveConfiguration& configuration, const std::string& input) {
  SlamRun run(configuration);
  for (const double stamp : {10.0, 10.1, 10.2}) {
    ScanInput scan;
    scan.scan = to_laser_scan(make_scan(stamp, "laser", 12));
    const ScanOutcome outcome = run.process(scan).value();
    ASSERT_TRUE(outcome.map_from_base.is_finite()) << input;
    ASSERT_TRUE(outcome.covariance.allFinite()) << input;
  }
}

TEST(FuzzConfiguration, MutatedYamlIsRefusedOrWorks) {
  const MatcherLoader loader;
  const std::vector<std::string> sound = sound_configurations(loader);
  const std::uint64_t first = first_fuzz_input();
  const std::uint64_t count = fuzz_inputs(1500);
  std::uint64_t accepted = 0;
  for (std::uint64_t number = first; number < first + count && !HasFailure(); ++number) {
    SCOPED_TRACE("MATCHBOX_FUZZ_FIRST=" + std::to_string(number));
    Random random(mix_seed(22, number));
    const std::string text = mutated(one_of(sound, random), yaml_words(), random);
    accepted += accepts(text, [&] {
      const Parameters parameters = parse_yaml_parameters(text, "fuzz");
      const LiveConfiguration configuration(parameters, loader);
      check_frames(configuration.setup().run);
      map_with(configuration, text);
      const std::string again = to_yaml(parameters);
      EXPECT_EQ(to_yaml(parse_yaml_parameters(again, "again")), again) << text;
    });
  }
  EXPECT_TRUE(is_enough(accepted, count, 0.05)) << accepted << ": always refused they try little";
}

TEST(FuzzConfiguration, MutatedOptionsOfTheCommandLineAreRefusedOrWork) {
  const MatcherLoader loader;
  std::vector<std::string> sound;
  for (const OptionDescription& row : describe_setup(make_slam_setup({}, loader))) {
    sound.push_back(row.name + "=" + to_string(row.value));
  }
  const std::uint64_t first = first_fuzz_input();
  const std::uint64_t count = fuzz_inputs(1500);
  for (std::uint64_t number = first; number < first + count && !HasFailure(); ++number) {
    SCOPED_TRACE("MATCHBOX_FUZZ_FIRST=" + std::to_string(number));
    Random random(mix_seed(23, number));
    std::string text = mutated(one_of(sound, random), yaml_words(), random);
    if (happens(0.5, random)) {
      const std::string& option = one_of(sound, random);
      text = option.substr(0, option.find('=') + 1) + to_string(odd_number(random));
    }
    accepts(text, [&] { map_with({parse_overrides({text}), loader}, text); });
  }
}

TEST(FuzzConfiguration, MutatedParametersOfRosAreRefusedOrWork) {
  const MatcherLoader loader;
  const std::string sound =
      "<value><struct><member><name>matcher</name><value>olson</value></member><member>"
      "<name>map</name><value><struct><member><name>resolution</name><value><double>0.1</double>"
      "</value></member></struct></value></member><member><name>seed</name><value><i4>3</i4>"
      "</value></member><member><name>olson</name><value><struct/></value></member></struct></"
      "value>";
  const std::vector<std::string> tags = {"<value>",
                                         "</value>",
                                         "<struct>",
                                         "</struct>",
                                         "<member>",
                                         "</member>",
                                         "<name>",
                                         "</name>",
                                         "<array><data>",
                                         "</data></array>",
                                         "<i4>7</i4>",
                                         "<double>1e400</double>",
                                         "<boolean>1</boolean>",
                                         "<base64>AAAA</base64>",
                                         "<dateTime.iso8601>x</dateTime.iso8601>",
                                         "<nil/>",
                                         "-1",
                                         "nan"};
  const std::uint64_t first = first_fuzz_input();
  const std::uint64_t count = fuzz_inputs(1500);
  for (std::uint64_t number = first; number < first + count && !HasFailure(); ++number) {
    SCOPED_TRACE("MATCHBOX_FUZZ_FIRST=" + std::to_string(number));
    Random random(mix_seed(24, number));
    const std::string text = mutated(sound, tags, random);
    XmlRpc::XmlRpcValue tree;
    int offset = 0;
    if (tree.fromXml(text, &offset)) {
      accepts(text, [&] { map_with({to_parameters(tree), loader}, text); });
    }
  }
}

}  // namespace
}  // namespace matchbox_slam
