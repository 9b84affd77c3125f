#include <gtest/gtest.h>

#include <limits>

#include "common/error_text.hpp"
#include "matchbox_slam/common/options.hpp"

namespace matchbox_slam {
namespace {

struct ToyOptions {
  int max_tries = 1000;
  double sigma = 0.1;
  bool refine = true;
  std::string mode = "fast";
  std::vector<double> steps = {1.0, 2.0};
  std::vector<std::string> frames = {"a"};

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor&& option) {
    option(self.max_tries, "max_tries", at_least(1), "", "Poses drawn in all.");
    option(self.sigma, "sigma", between(0.0, 2.5), "m", "Spread.");
    option(self.refine, "refine", any(), "", "Whether to refine.");
    option(self.mode, "mode", one_of({"fast", "exact"}), "", "How.");
    option(self.steps, "steps", between(0.0, 10.0), "m", "Steps.");
    option(self.frames, "frames", any(), "", "Frames.");
  }
};

template <typename Value>
std::string refusal(const std::string& key, Value value) {
  Parameters parameters;
  parameters.set(key, value);
  return error_text<ConfigurationError>([&] { (void)read_options<ToyOptions>(parameters, "toy"); });
}

TEST(ReadOptions, KeepsDefaultsAndTakesWhatIsGiven) {
  Parameters parameters;
  parameters.set("max_tries", 5);
  parameters.set("sigma", 2);  // a whole number is good for a double
  parameters.set("refine", false);
  parameters.set("mode", "exact");
  parameters.set("steps", std::vector<double>{3.0});
  parameters.set("frames", std::vector<double>{});  // an empty list has no type
  const auto options = read_options<ToyOptions>(parameters, "toy");
  EXPECT_EQ(options.max_tries, 5);
  EXPECT_EQ(options.sigma, 2.0);
  EXPECT_FALSE(options.refine);
  EXPECT_EQ(options.mode, "exact");
  EXPECT_EQ(options.steps, std::vector<double>{3.0});
  EXPECT_TRUE(options.frames.empty());
  parameters.set("steps", std::vector<std::string>{});
  EXPECT_TRUE(read_options<ToyOptions>(parameters, "toy").steps.empty());
  EXPECT_EQ(read_options<ToyOptions>({}, "toy").max_tries, 1000);
}

TEST(ReadOptions, AllowsTheEndsOfAnInterval) {
  Parameters parameters;
  parameters.set("max_tries", 1);
  parameters.set("sigma", 2.5);
  EXPECT_NO_THROW((void)read_options<ToyOptions>(parameters, "toy"));
}

TEST(ReadOptions, RefusalNamesKeyValueAndWhatIsAllowed) {
  EXPECT_EQ(refusal("max_tries", 0), "toy/max_tries: 0 is not allowed; allowed: at least 1");
  EXPECT_EQ(refusal("max_tries", 3.0),
            "toy/max_tries: 3.0 is not a whole number; allowed: at least 1");
  EXPECT_EQ(refusal("max_tries", std::int64_t{5000000000}),
            "toy/max_tries: 5000000000 is not allowed; allowed: 1 to 2147483647");
  EXPECT_EQ(refusal("sigma", 2.6), "toy/sigma: 2.6 is not allowed; allowed: 0 to 2.5");
  EXPECT_EQ(refusal("sigma", "wide"), "toy/sigma: wide is not a number; allowed: 0 to 2.5");
  EXPECT_EQ(refusal("sigma", true), "toy/sigma: true is not a number; allowed: 0 to 2.5");
  EXPECT_EQ(refusal("refine", 1), "toy/refine: 1 is not allowed; allowed: true, false");
  EXPECT_EQ(refusal("mode", "slow"), "toy/mode: slow is not allowed; allowed: one of fast, exact");
  EXPECT_EQ(
      refusal("mode", 1),
      "toy/mode: 1 is not text (quote it if it is meant as text); allowed: one of fast, exact");
  EXPECT_EQ(refusal("steps", std::vector<double>{1.0, 11.0}),
            "toy/steps[1]: 11.0 is not allowed; allowed: 0 to 10");
  EXPECT_EQ(refusal("steps", 1.0),
            "toy/steps: 1.0 is not a list of numbers, such as [1.0, 2.0]; allowed: 0 to 10");
  EXPECT_EQ(refusal("frames", std::vector<double>{1.0}),
            "toy/frames: [1.0] is not a list of texts, such as [one, two]");
}

TEST(ReadOptions, RefusesNumbersThatAreNotFinite) {
  EXPECT_EQ(refusal("sigma", std::numeric_limits<double>::quiet_NaN()),
            "toy/sigma: .nan is not a finite number; allowed: 0 to 2.5");
  EXPECT_EQ(refusal("sigma", std::numeric_limits<double>::infinity()),
            "toy/sigma: .inf is not a finite number; allowed: 0 to 2.5");
}

TEST(ReadOptions, UnknownKeySuggestsTheNearestKnownOne) {
  EXPECT_EQ(refusal("max_trys", 1),
            "toy: unknown parameter 'max_trys'; did you mean 'max_tries'? Known: max_tries, sigma, "
            "refine, mode, steps, frames.");
  EXPECT_EQ(
      refusal("something_else", 1),
      "toy: unknown parameter 'something_else'. Known: max_tries, sigma, refine, mode, steps, "
      "frames.");
}

TEST(RejectUnknownKeys, PrefersTheNearestOfSeveralNames) {
  Parameters parameters;
  parameters.set("range_mix", 1);
  const std::string text = error_text<ConfigurationError>([&] {
    reject_unknown_keys(parameters, "", {"range_min_", "range_min", "range_mean"});
  });
  EXPECT_TRUE(contains(text, "did you mean 'range_min'?")) << text;
}

TEST(RejectUnknownKeys, WorksWithoutComponentAndWithoutKnownNames) {
  Parameters parameters;
  parameters.set("a", 1);
  EXPECT_EQ(error_text<ConfigurationError>([&] { reject_unknown_keys(parameters, "", {}); }),
            "unknown parameter 'a'. It takes none.");
  EXPECT_NO_THROW(reject_unknown_keys(parameters, "", {"a"}));
}

TEST(DescribeOptions, HasOneRowAnOptionInOrder) {
  ToyOptions options;
  options.max_tries = 7;
  const auto rows = describe_options(options);
  ASSERT_EQ(rows.size(), 6U);
  EXPECT_EQ(rows[0].name, "max_tries");
  EXPECT_EQ(to_string(rows[0].value), "7");
  EXPECT_EQ(rows[0].allowed, "at least 1");
  EXPECT_EQ(rows[1].unit, "m");
  EXPECT_EQ(rows[2].allowed, "true, false");
  EXPECT_EQ(rows[3].allowed, "one of fast, exact");
  EXPECT_EQ(rows[3].meaning, "How.");
}

TEST(Allowed, SaysLimitsAsShortAsTheyAre) {
  EXPECT_EQ(any().text(), "");
  EXPECT_EQ(between(0.001, 1.0).text(), "0.001 to 1");
  EXPECT_EQ((Allowed{-std::numeric_limits<double>::infinity(), 4.0, {}}.text()), "at most 4");
}

}  // namespace
}  // namespace matchbox_slam
