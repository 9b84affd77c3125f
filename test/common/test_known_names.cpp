#include <gtest/gtest.h>

#include "common/known_names.hpp"

namespace matchbox_slam {
namespace {

TEST(NearestName, IsEmptyWhereNoneIsNear) {
  EXPECT_EQ(nearest_name("slm", {"scan", "slam"}), "slam");
  EXPECT_EQ(nearest_name("insert_distance", {"matcher", "seed"}), "");
  EXPECT_EQ(nearest_name("slm", {}), "");
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
