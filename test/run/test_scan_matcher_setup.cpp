#include <gtest/gtest.h>

#include <string>

#include "common/error_text.hpp"
#include "matchbox_slam/io/yaml_parameters.hpp"
#include "ros/matcher_loader.hpp"
#include "ros/queue_settings.hpp"
#include "run/scan_matcher_setup.hpp"

namespace matchbox_slam {
namespace {

ScanMatcherSetup matcher_setup_of(const std::string& yaml) {
  const MatcherLoader loader;
  return make_scan_matcher_setup(parse_yaml_parameters(yaml, "test"), loader);
}

std::string matcher_refusal_of(const std::string& yaml) {
  return error_text<ConfigurationError>([&] { (void)matcher_setup_of(yaml); });
}

TEST(ScanMatcherSetup, HasDefaultsThatFitTogether) {
  const ScanMatcherSetup setup = matcher_setup_of("{}");
  EXPECT_EQ(setup.matcher_name, "matchbox_slam/Olson");
  EXPECT_EQ(setup.guess, GuessSource::kVelocity);
  EXPECT_EQ(setup.tf_child(), "base_link");
  const ScanQueueSettings settings = queue_settings(setup);
  EXPECT_FALSE(settings.odom_frame) << "scans wait for no odometry";
  EXPECT_EQ(settings.map_frame, "odom") << "our own tf is no news";
}

TEST(ScanMatcherSetup, TakesTheFilesOfTheSlamNode) {
  for (const std::string name : {"olson", "hough", "monte_carlo"}) {
    const MatcherLoader loader;
    const ScanMatcherSetup setup = make_scan_matcher_setup(
        read_yaml_parameters({std::string(MATCHBOX_SOURCE_DIR) + "/config/" + name + ".yaml"}),
        loader);
    EXPECT_EQ(matcher_short_name(setup.matcher_name), name);
  }
}

TEST(ScanMatcherSetup, AGuessByOdometryPutsTfAboveThat) {
  const ScanMatcherSetup setup =
      matcher_setup_of("{guess: odometry, guess_frame: /odom, odom_frame: scan_odom}");
  EXPECT_EQ(setup.guess, GuessSource::kOdometry);
  EXPECT_EQ(setup.tf_child(), "odom");
  const ScanQueueSettings settings = queue_settings(setup);
  EXPECT_EQ(settings.odom_frame, "odom");
  EXPECT_EQ(settings.map_frame, "scan_odom");
}

TEST(ScanMatcherSetup, TheFrameOfTheGuessMayBeOursWithoutTf) {
  const std::string shared = "guess: odometry, guess_frame: odom, odom_frame: odom";
  const std::string text = matcher_refusal_of("{" + shared + "}");
  EXPECT_TRUE(contains(text, "odom_frame: 'odom' is not allowed with publish_tf")) << text;
  EXPECT_TRUE(contains(text, "such as scan_odom, or publish_tf: false")) << text;
  const ScanQueueSettings settings =
      queue_settings(matcher_setup_of("{" + shared + ", publish_tf: false}"));
  EXPECT_EQ(settings.odom_frame, "odom");
  EXPECT_EQ(settings.map_frame, "") << "else the guess would be ignored";
}

TEST(ScanMatcherSetup, RefusesWhatDoesNotFitTogether) {
  const auto refused = [](const std::string& yaml, const std::string& words) {
    const std::string text = matcher_refusal_of(yaml);
    EXPECT_TRUE(contains(text, words)) << yaml << ": " << text;
  };
  refused("{base_frame: odom}", "odom_frame: 'odom' is not allowed; allowed: a frame other than");
  refused("{base_frame: ''}", "base_frame: '' is not allowed");
  refused("{odom_frame: /base_link}", "odom_frame: 'base_link' is not allowed");
  refused("{guess: odometry}", "guess_frame: '' is not allowed with guess 'odometry'");
  refused("{guess: odometry, guess_frame: base_link}", "guess_frame: 'base_link'");
  refused("{guess_frame: odom}", "guess_frame: 'odom' is not allowed with guess 'velocity'");
  refused("{guess: wheels}", "guess: wheels is not allowed");
  refused("{map_frame: map}", "unknown parameter 'map_frame'");
  refused("{odometri/key_angle: 3}", "unknown section 'odometri'; did you mean 'odometry'?");
  refused("{key_angle: 3}", "did you mean 'odometry/key_angle'?");
  refused("{odometry/local_map_scan: 3}", "did you mean 'local_map_scans'?");
  refused("{slam/recent_scan: 3}", "did you mean 'recent_scans'?");
  refused("{hough/angles: 1}", "hough/angles");
  refused("{matcher: olsen}", "there is no matcher 'olsen'");
}

}  // namespace
}  // namespace matchbox_slam
