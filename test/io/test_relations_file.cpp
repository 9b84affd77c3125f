#include <gtest/gtest.h>

#include "common/error_text.hpp"
#include "io/relations_file.hpp"
#include "io/temporary_folder.hpp"
#include "matchbox_slam/io/file.hpp"

namespace matchbox_slam {
namespace {

std::string relations_refusal(const std::string& text) {
  return error_text<FileError>([&] { (void)parse_relations(text, "my.relations"); });
}

TEST(ParseRelations, ReadsStampsPositionAndYaw) {
  const auto relations = parse_relations(
      "# stamp1 stamp2 x y z roll pitch yaw\n"
      "\n"
      "976052905.167303 976052911.885496 -0.056990 -0.128430 9 8 7 -1.682210\r\n"
      "2 1 1 0 0 0 0 3.5",
      "my.relations");
  ASSERT_EQ(relations.size(), 2U);
  EXPECT_EQ(relations[0].first_stamp, 976052905.167303);
  EXPECT_EQ(relations[0].second_stamp, 976052911.885496);
  EXPECT_EQ(relations[0].first_from_second, (Pose2{-0.05699, -0.12843, -1.68221}));
  EXPECT_EQ(relations[1].second_stamp, 1.0);
  EXPECT_NEAR(relations[1].first_from_second.theta, 3.5 - 2.0 * kPi, 1e-12);
}

TEST(ParseRelations, NoLinesMakeNoRelations) {
  EXPECT_TRUE(parse_relations("", "my.relations").empty());
  EXPECT_TRUE(parse_relations("# none\n\n", "my.relations").empty());
}

TEST(ParseRelations, RefusalNamesFileAndLine) {
  const std::string good = "1 2 0 0 0 0 0 0\n";
  EXPECT_EQ(relations_refusal(good + "1 2 0 0 0 0 0\n"),
            "my.relations:2: has 7 columns; a relation has 8: stamp1 stamp2 x y z roll pitch yaw");
  EXPECT_EQ(relations_refusal(good + good + "1 2 0 0 0 0 0 nan\n"),
            "my.relations:3: yaw is 'nan', not a finite number");
  EXPECT_EQ(relations_refusal("1 two 0 0 0 0 0 0\n"),
            "my.relations:1: stamp2 is 'two', not a finite number");
}

TEST(ReadRelations, ReadsAFile) {
  const TemporaryFolder folder;
  replace_file(folder / "a.relations", "1 2 3 4 0 0 0 0.5\n");
  EXPECT_EQ(read_relations(folder / "a.relations").at(0).first_from_second, (Pose2{3, 4, 0.5}));
  EXPECT_THROW((void)read_relations(folder / "none.relations"), FileError);
}

}  // namespace
}  // namespace matchbox_slam
