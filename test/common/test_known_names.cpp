#include <gtest/gtest.h>

#include "common/known_names.hpp"

namespace matchbox_slam {
namespace {

TEST(NearestName, IsEmptyWhereNoneIsNear) {
  EXPECT_EQ(nearest_name("slm", {"scan", "slam"}), "slam");
  EXPECT_EQ(nearest_name("insert_distance", {"matcher", "seed"}), "");
  EXPECT_EQ(nearest_name("slm", {}), "");
}

TEST(NearestName, IsTheOnlyOneThatBeginsSo) {
  EXPECT_EQ(nearest_name("insert_dist", {"insert_angle", "insert_distance"}), "insert_distance");
  EXPECT_EQ(nearest_name("insert_distanc", {"insert_distances_all", "insert_distance"}),
            "insert_distance")
      << "of two the nearest";
  EXPECT_EQ(nearest_name("in", {"insert_distance"}), "") << "too short to tell";
}

TEST(UnknownNameText, NamesWhatWasMeant) {
  EXPECT_EQ(unknown_name_text("section", "x", {}, {"slam", "map"}),
            "unknown section 'x'. Known: slam, map.");
  EXPECT_EQ(unknown_name_text("parameter", "x", {"slam/x"}, {"seed"}),
            "unknown parameter 'x'; did you mean 'slam/x'? Known: seed.");
  EXPECT_EQ(unknown_name_text("parameter", "x", {"slam/x", "map/x"}, {}),
            "unknown parameter 'x'; did you mean 'slam/x' or 'map/x'? It takes none.");
}

}  // namespace
}  // namespace matchbox_slam
