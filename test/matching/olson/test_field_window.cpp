#include <gtest/gtest.h>

#include <algorithm>

#include "matchbox_slam/common/random.hpp"
#include "matching/olson/field_values.hpp"
#include "matching/olson/field_window.hpp"

namespace matchbox_slam {
namespace {

LikelihoodField random_field(Random& random) {
  LikelihoodField field(0.05, {});
  std::vector<SurfaceHit> hits;
  for (int i = 0; i < 40; ++i) {
    hits.push_back({{random.uniform(-3.0, 3.0), random.uniform(-3.0, 3.0)}, {0.0, 0.0}});
  }
  field.update(hits, {});
  return field;
}

FieldWindow window_of(const LikelihoodField& field, const CellBox& box,
                      const FieldWindow::Values& values) {
  FieldWindow window;
  window.read(field, box, values);
  return window;
}

using Bounds = std::array<FieldWindow, FieldWindow::kLevels>;

Bounds bounds_of(const LikelihoodField& field, const CellBox& box) {
  Bounds bounds;
  window_of(field, box, unchanged_values()).make_bounds(FieldWindow::kLevels - 1, bounds);
  return bounds;
}

std::uint8_t entry(const FieldWindow& window, const Cell& cell) {
  const TableLayout& layout = window.layout();
  const int x = (cell.x - layout.corner.x) >> layout.grain_bits;
  const int y = (cell.y - layout.corner.y) >> layout.grain_bits;
  const int last_phase = (1 << layout.phase_bits) - 1;
  const int phase = ((y & last_phase) << layout.phase_bits) + (x & last_phase);
  return window.data()[phase * layout.plane + (y >> layout.phase_bits) * layout.pitch +
                       (x >> layout.phase_bits)];
}

std::uint8_t maximum(const LikelihoodField& field, const Cell& first, int width) {
  std::uint8_t most = 0;
  for (int y = first.y; y < first.y + width; ++y) {
    for (int x = first.x; x < first.x + width; ++x) {
      most = std::max(most, field.likelihood({x, y}));
    }
  }
  return most;
}

TEST(FieldWindow, HoldsTheValuesOfLikelihoods) {
  Random random(3);
  const LikelihoodField field = random_field(random);
  FieldWindow::Values values = unchanged_values();
  std::reverse(values.begin() + 1, values.end());
  const CellBox box{{-75, -9}, {81, 77}};
  const FieldWindow window = window_of(field, box, values);
  for (int y = box.min.y; y < box.max.y; ++y) {
    for (int x = box.min.x; x < box.max.x; ++x) {
      ASSERT_EQ(entry(window, {x, y}), values[field.likelihood({x, y})]) << x << ", " << y;
    }
  }
}

TEST(FieldWindow, BoundsWhatAnyShiftByAStrideMeets) {
  Random random(4);
  const LikelihoodField field = random_field(random);
  const CellBox box{{-80, -64}, {96, 80}};
  const Bounds bounds = bounds_of(field, box);
  for (std::size_t level = 0; level < bounds.size(); ++level) {
    const int grain = FieldWindow::kBounds[level].grain;
    const int width = FieldWindow::kBounds[level].width();
    for (int y = box.min.y; y + width < box.max.y; ++y) {
      for (int x = box.min.x; x + width < box.max.x; ++x) {
        const Cell first{x & -grain, y & -grain};
        ASSERT_EQ(entry(bounds[level], {x, y}), maximum(field, first, width))
            << "level " << level << " at " << x << ", " << y;
      }
    }
  }
}

TEST(FieldWindow, BoundsTheSameWhereOnlyAPartIsNeeded) {
  Random random(6);
  const LikelihoodField field = random_field(random);
  const CellBox box{{-80, -64}, {96, 80}};
  const Bounds all = bounds_of(field, box);
  FieldWindow window;
  Bounds some;
  for (const CellBox& part : {CellBox{{-37, -50}, {5, 8}}, CellBox{{30, 31}, {90, 79}},
                              CellBox{{-200, -3}, {-40, 300}}, CellBox{{200, 0}, {300, 9}}}) {
    // All is another value first, so that what is not made anew shows.
    FieldWindow::Values other{};
    other.fill(77);
    window.read(field, box, other);
    window.make_bounds(FieldWindow::kLevels - 1, some);
    window.frame(box);
    window.need({{-10, -10}, {2, 2}});
    window.need(part);
    window.read(field, unchanged_values());
    window.make_bounds(FieldWindow::kLevels - 1, some);
    const CellBox inside = intersection(part, box);
    for (std::size_t level = 0; level < some.size(); ++level) {
      const int width = FieldWindow::kBounds[level].width();
      for (int y = inside.min.y; y + width < inside.max.y; ++y) {
        for (int x = inside.min.x; x + width < inside.max.x; ++x) {
          ASSERT_EQ(entry(some[level], {x, y}), entry(all[level], {x, y}))
              << "level " << level << " at " << x << ", " << y;
        }
      }
    }
    const Cell aside{-60, 60};
    EXPECT_EQ(entry(window, aside), part.contains(aside) ? field.likelihood(aside) : 77)
        << "what nobody needs is left alone";
  }
}

TEST(FieldWindow, KeepsBlocksThatAreAStrideApartTogether) {
  Random random(5);
  const LikelihoodField field = random_field(random);
  const Bounds bounds = bounds_of(field, {{-80, -80}, {80, 80}});
  for (std::size_t level = 0; level < bounds.size(); ++level) {
    const TableLayout& layout = bounds[level].layout();
    EXPECT_EQ(1 << (layout.grain_bits + layout.phase_bits), FieldWindow::kBounds[level].stride);
  }
}

}  // namespace
}  // namespace matchbox_slam
