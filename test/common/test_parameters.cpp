#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "matchbox_slam/common/parameters.hpp"

namespace matchbox_slam {
namespace {

template <typename Type>
bool holds(const ParameterValue& value, const Type& expected) {
  return std::holds_alternative<Type>(value) && std::get<Type>(value) == expected;
}

TEST(ParseParameterValue, TypesPlainScalarsAsYamlDoes) {
  EXPECT_TRUE(holds(parse_parameter_value("true"), true));
  EXPECT_TRUE(holds(parse_parameter_value("True"), true));
  EXPECT_TRUE(holds(parse_parameter_value("FALSE"), false));
  EXPECT_TRUE(holds(parse_parameter_value("12"), std::int64_t{12}));
  EXPECT_TRUE(holds(parse_parameter_value("-7"), std::int64_t{-7}));
  EXPECT_TRUE(holds(parse_parameter_value("+7"), std::int64_t{7}));
  EXPECT_TRUE(holds(parse_parameter_value("0.5"), 0.5));
  EXPECT_TRUE(holds(parse_parameter_value("3."), 3.0));
  EXPECT_TRUE(holds(parse_parameter_value("-.25"), -0.25));
  EXPECT_TRUE(holds(parse_parameter_value("1e-3"), 1e-3));
  EXPECT_TRUE(holds(parse_parameter_value(".inf"), std::numeric_limits<double>::infinity()));
  EXPECT_TRUE(holds(parse_parameter_value("-.Inf"), -std::numeric_limits<double>::infinity()));
  EXPECT_TRUE(std::isnan(std::get<double>(parse_parameter_value(".nan"))));
  EXPECT_TRUE(holds(parse_parameter_value("99999999999999999999"), 99999999999999999999.0));
}

TEST(ParseParameterValue, LeavesEverythingElseAsText) {
  for (const std::string text : {"", "olson", "1.2.3", "1e", "e5", ".", "-", "1 2", " 1", "0x10",
                                 "nan", "inf", "yes", "1e999"}) {
    EXPECT_TRUE(holds(parse_parameter_value(text), text)) << text;
  }
}

TEST(ParameterToString, ReadsBackAsTheSameValue) {
  for (const double value : {0.1, 1.0 / 3.0, 3.0, 1e300, -2.5e-7, 123456789012.5, 5e-324}) {
    EXPECT_TRUE(holds(parse_parameter_value(to_string(value)), value)) << to_string(value);
  }
  EXPECT_EQ(to_string(ParameterValue(0.1)), "0.1");
  EXPECT_EQ(to_string(ParameterValue(3.0)), "3.0");
  EXPECT_EQ(to_string(ParameterValue(std::int64_t{3})), "3");
  EXPECT_EQ(to_string(ParameterValue(true)), "true");
  EXPECT_EQ(to_string(ParameterValue(-std::numeric_limits<double>::infinity())), "-.inf");
  EXPECT_EQ(to_string(ParameterValue(std::vector<double>{1.0, 0.5})), "[1.0, 0.5]");
}

TEST(ParameterToString, QuotesTextThatLooksLikeSomethingElse) {
  EXPECT_EQ(to_string(ParameterValue(std::string("odom"))), "odom");
  EXPECT_EQ(to_string(ParameterValue(std::string("/base_scan"))), "/base_scan");
  EXPECT_EQ(to_string(ParameterValue(std::string("12"))), "\"12\"");
  EXPECT_EQ(to_string(ParameterValue(std::string("true"))), "\"true\"");
  EXPECT_EQ(to_string(ParameterValue(std::string("off"))), "\"off\"");
  EXPECT_EQ(to_string(ParameterValue(std::string())), "\"\"");
  EXPECT_EQ(to_string(ParameterValue(std::string("a\"b\\\n"))), R"("a\"b\\\n")");
  EXPECT_EQ(to_string(ParameterValue(std::vector<std::string>{"a", "b, c"})), "[a, \"b, c\"]");
}

TEST(Parameters, TakesLiteralsForWhatTheyAre) {
  Parameters parameters;
  parameters.set("text", "odom");
  parameters.set("whole", 3);
  parameters.set("real", 3.0F);
  parameters.set("switch", false);
  EXPECT_TRUE(holds(*parameters.find("text"), std::string("odom")));
  EXPECT_TRUE(holds(*parameters.find("whole"), std::int64_t{3}));
  EXPECT_TRUE(holds(*parameters.find("real"), 3.0));
  EXPECT_TRUE(holds(*parameters.find("switch"), false));
  EXPECT_EQ(parameters.find("other"), nullptr);
}

TEST(Parameters, SectionHoldsWhatIsBelowItsNameOnly) {
  Parameters parameters;
  parameters.set("map", 1);
  parameters.set("map/resolution", 0.05);
  parameters.set("map/deep/er", 2);
  parameters.set("map-like/resolution", 0.1);
  parameters.set("mapping/resolution", 0.2);
  const Parameters section = parameters.section("map");
  EXPECT_EQ(section.values().size(), 2U);
  EXPECT_TRUE(holds(*section.find("resolution"), 0.05));
  EXPECT_TRUE(holds(*section.find("deep/er"), std::int64_t{2}));
  EXPECT_TRUE(parameters.section("none").empty());
}

TEST(Parameters, MergeReplacesValuesOfTheSameKey) {
  Parameters base;
  base.set("a", 1);
  base.set("b", 2);
  Parameters over;
  over.set("b", 3);
  over.set("c", 4);
  base.merge(over);
  EXPECT_TRUE(holds(*base.find("a"), std::int64_t{1}));
  EXPECT_TRUE(holds(*base.find("b"), std::int64_t{3}));
  EXPECT_TRUE(holds(*base.find("c"), std::int64_t{4}));
}

}  // namespace
}  // namespace matchbox_slam
