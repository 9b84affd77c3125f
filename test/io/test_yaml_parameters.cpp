#include <gtest/gtest.h>

#include "common/error_text.hpp"
#include "io/temporary_folder.hpp"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/yaml_parameters.hpp"

namespace matchbox_slam {
namespace {

template <typename Type>
Type value_of(const Parameters& parameters, const std::string& key) {
  const ParameterValue* value = parameters.find(key);
  if (value == nullptr || !std::holds_alternative<Type>(*value)) {
    ADD_FAILURE() << key << (value == nullptr ? " is missing" : " has another type");
    return {};
  }
  return std::get<Type>(*value);
}

std::string yaml_refusal(const std::string& text) {
  return error_text<ConfigurationError>([&] { (void)parse_yaml_parameters(text, "my.yaml"); });
}

TEST(ParseYamlParameters, JoinsNestedMapsAndTypesScalars) {
  const Parameters parameters = parse_yaml_parameters(R"(
matcher: MonteCarlo   # a comment
monte_carlo:
  max_tries: 500
  deeper: {sigma: 0.5, refine: true}
map/resolution: 0.1
base_frame: "12"
name: 'true'
)",
                                                      "my.yaml");
  EXPECT_EQ(parameters.values().size(), 7U);
  EXPECT_EQ(value_of<std::string>(parameters, "matcher"), "MonteCarlo");
  EXPECT_EQ(value_of<std::int64_t>(parameters, "monte_carlo/max_tries"), 500);
  EXPECT_EQ(value_of<double>(parameters, "monte_carlo/deeper/sigma"), 0.5);
  EXPECT_TRUE(value_of<bool>(parameters, "monte_carlo/deeper/refine"));
  EXPECT_EQ(value_of<double>(parameters, "map/resolution"), 0.1);
  EXPECT_EQ(value_of<std::string>(parameters, "base_frame"), "12");
  EXPECT_EQ(value_of<std::string>(parameters, "name"), "true");
}

TEST(ParseYamlParameters, ReadsLists) {
  const Parameters parameters = parse_yaml_parameters(
      "a: [1, 0.5]\nb: [x, y]\nc: []\nd: [1, x]\ne: [\"1\", \"2\"]\nf:\n- 3\n", "my.yaml");
  EXPECT_EQ(value_of<std::vector<double>>(parameters, "a"), (std::vector<double>{1.0, 0.5}));
  EXPECT_EQ(value_of<std::vector<std::string>>(parameters, "b"),
            (std::vector<std::string>{"x", "y"}));
  EXPECT_TRUE(value_of<std::vector<double>>(parameters, "c").empty());
  EXPECT_EQ(value_of<std::vector<std::string>>(parameters, "d"),
            (std::vector<std::string>{"1", "x"}));
  EXPECT_EQ(value_of<std::vector<std::string>>(parameters, "e"),
            (std::vector<std::string>{"1", "2"}));
  EXPECT_EQ(value_of<std::vector<double>>(parameters, "f"), std::vector<double>{3.0});
}

TEST(ParseYamlParameters, TakesEmptyTextForNoParameters) {
  EXPECT_TRUE(parse_yaml_parameters("", "my.yaml").empty());
  EXPECT_TRUE(parse_yaml_parameters("---\n", "my.yaml").empty());
  EXPECT_TRUE(parse_yaml_parameters("# only a comment\n", "my.yaml").empty());
}

TEST(ParseYamlParameters, RefusalNamesSourceAndLine) {
  EXPECT_TRUE(contains(yaml_refusal("a: 1\nb: [1, 2\n"), "my.yaml:3: not YAML: "))
      << yaml_refusal("b: [1");
  EXPECT_EQ(yaml_refusal("a: 1\nb:\n"),
            "my.yaml:2: 'b' has no value; give one, or leave the line out");
  EXPECT_EQ(yaml_refusal("a:\n  b: 1\na/b: 2\n"), "my.yaml:3: 'a/b' is given twice");
  EXPECT_EQ(yaml_refusal("a: 1\na: 2\n"), "my.yaml:2: 'a' is given twice");
  EXPECT_EQ(yaml_refusal("a: 1\nb: [[1], [2]]\n"),
            "my.yaml:2: 'b' is a list of something else than numbers or texts");
  EXPECT_EQ(yaml_refusal("- 1\n- 2\n"),
            "my.yaml:1: has to be a map of names to values, such as 'matcher: monte_carlo'");
  for (const std::string text : {"a: 1\n---\nb: 2\n", "a: 1\n...\nb: 2\n", "{a: 1}\nb: 2\n"}) {
    EXPECT_TRUE(contains(yaml_refusal(text), "my.yaml: a second YAML document")) << text;
  }
  for (const std::string text : {"a//b: 1", "/a: 1", "a/: 1", "[1]: 2", "'': 1"}) {
    EXPECT_TRUE(contains(yaml_refusal(text), "my.yaml:1: a name has to be text")) << text;
  }
}

TEST(ParseYamlParameters, ADocumentMayHaveAHeadAndAnEnd) {
  for (const std::string text : {"%YAML 1.2\n---\na: 1\n", "--- # ours\na: 1\n...\n# the end\n"}) {
    EXPECT_EQ(parse_yaml_parameters(text, "my.yaml").values().size(), 1U) << text;
  }
}

TEST(ParseYamlParameters, RefusesAMapThatHoldsItself) {
  EXPECT_TRUE(contains(yaml_refusal("a: &x\n  b: *x\n"), "nested more than 32 deep"));
}

TEST(ReadYamlParameters, LaterFilesReplaceEarlierOnes) {
  const TemporaryFolder folder;
  replace_file(folder / "a.yaml", "map: {resolution: 0.05, quality: 0.5}\n");
  replace_file(folder / "b.yaml", "map: {resolution: 0.1}\nmatcher: Olson\n");
  const Parameters parameters = read_yaml_parameters({folder / "a.yaml", folder / "b.yaml"});
  EXPECT_EQ(parameters.values().size(), 3U);
  EXPECT_EQ(value_of<double>(parameters, "map/resolution"), 0.1);
  EXPECT_EQ(value_of<double>(parameters, "map/quality"), 0.5);
}

TEST(ReadYamlParameters, NamesTheFileThatCannotBeRead) {
  const TemporaryFolder folder;
  EXPECT_EQ(
      error_text<ConfigurationError>([&] { (void)read_yaml_parameters({folder / "none.yaml"}); }),
      "cannot read '" + (folder / "none.yaml") + "': No such file or directory");
}

TEST(ParseOverrides, TypesValuesAsYamlDoes) {
  const Parameters parameters = parse_overrides({"monte_carlo/max_tries=500", "a=0.5", "b=[1, 2]",
                                                 "c=x=y", "d=", "e=\"1\"", "a=0.25", "f={g: 1}"});
  EXPECT_EQ(value_of<std::int64_t>(parameters, "monte_carlo/max_tries"), 500);
  EXPECT_EQ(value_of<double>(parameters, "a"), 0.25);
  EXPECT_EQ(value_of<std::vector<double>>(parameters, "b"), (std::vector<double>{1.0, 2.0}));
  EXPECT_EQ(value_of<std::string>(parameters, "c"), "x=y");
  EXPECT_EQ(value_of<std::string>(parameters, "d"), "");
  EXPECT_EQ(value_of<std::string>(parameters, "e"), "1");
  EXPECT_EQ(value_of<std::int64_t>(parameters, "f/g"), 1);
}

TEST(ParseOverrides, RefusalNamesTheAssignment) {
  const auto refused = [](const std::string& assignment) {
    return error_text<ConfigurationError>([&] { (void)parse_overrides({assignment}); });
  };
  EXPECT_EQ(refused("max_tries"), "'max_tries' is not name=value");
  EXPECT_EQ(refused("=3"), "'=3' is not name=value");
  EXPECT_EQ(refused("a/=3"), "'a/=3' is not name=value");
  EXPECT_EQ(refused("map.resolution=0.1"),
            "'map.resolution=0.1': the parts of a name are joined with '/': 'map/resolution'");
  EXPECT_TRUE(contains(refused("a=[1"), "'a=[1'"));
  EXPECT_EQ(refused("a=1\nb: 2"),
            "'a=1\nb: 2' holds more than one value; give each name=value by itself");
  EXPECT_TRUE(contains(refused("a=1\nvalues: 2"), "holds more than one value"));
}

TEST(ToYaml, NestsAndReadsBackAsTheSame) {
  Parameters parameters;
  parameters.set("matcher", "MonteCarlo");
  parameters.set("map/resolution", 0.1);
  parameters.set("map/deep/on", true);
  parameters.set("map/list", std::vector<double>{1.0, 0.3});
  parameters.set("map/words", std::vector<std::string>{"12", "a, b"});
  parameters.set("tricky", "# no comment: \"really\"\n\x01");
  parameters.set("whole", -3);
  parameters.set("third", 1.0 / 3.0);
  const std::string text = to_yaml(parameters);
  EXPECT_TRUE(contains(text, "map:\n  deep:\n    \"on\": true\n  list: [1.0, 0.3]\n")) << text;
  EXPECT_EQ(parse_yaml_parameters(text, "text").values(), parameters.values()) << text;
  EXPECT_EQ(to_yaml({}), "");
}

TEST(ToYaml, RefusesANameThatIsBothValueAndSection) {
  Parameters parameters;
  parameters.set("a/b", 1);
  parameters.set("a/b/c", 2);
  EXPECT_EQ(error_text<ConfigurationError>([&] { (void)to_yaml(parameters); }),
            "'a/b' is both a value and a section of others");
}

}  // namespace
}  // namespace matchbox_slam
