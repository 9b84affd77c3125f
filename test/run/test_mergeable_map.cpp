#include <gtest/gtest.h>

#include <memory>

#include "run/mergeable_map.hpp"

namespace matchbox_slam {
namespace {

TEST(MergeableMap, ItsLasersAreThoseOfAllThatIsMerged) {
  const EngineOptions options;
  const SlamMap map(options.map, options.field);
  EngineState state{map, {}, {}, {}};
  EXPECT_EQ(last_laser(state), -1);
  state.key_scans.add(MeasuredScan{}, 1, {});
  state.key_scans.add(MeasuredScan{}, 0, {});
  EXPECT_EQ(last_laser(state), 1);
  MapComponent component{map, {}, {}, 0.0};
  component.key_scans.add(MeasuredScan{}, 2, {});
  state.localization.components = {component};
  EXPECT_EQ(last_laser(state), 2);
  state.localization.pending = {{0, {std::make_shared<const KeyScan>(MeasuredScan{}, 0, 3), {}}}};
  EXPECT_EQ(last_laser(state), 3);
}

}  // namespace
}  // namespace matchbox_slam
