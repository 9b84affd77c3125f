#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "common/error_text.hpp"
#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/map/likelihood_field.hpp"

namespace matchbox_slam {
namespace {

constexpr double kFieldResolution = 0.05;

LikelihoodFieldOptions field_options() {
  LikelihoodFieldOptions options;
  options.sigma = 0.06;
  options.reach = 0.4;
  return options;
}

/// Distance to the nearest of all surfaces by looking at each of them [m].
double brute_force_distance(const Eigen::Vector2d& point,
                            const std::vector<Eigen::Vector2d>& surfaces) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector2d& surface : surfaces) {
    nearest = std::min(nearest, (surface - point).norm());
  }
  return nearest;
}

/// Compares every cell from -1.6 m to 1.6 m with the brute-force answer. The field tabulates by
/// squared distance in 4096 steps, so that a value is that of its step.
void expect_brute_force_answers(const LikelihoodField& field,
                                const std::vector<Eigen::Vector2d>& surfaces) {
  const double sigma = field.options().sigma;
  const double reach = field.options().reach;
  const double step = reach * reach / 4096.0;
  const auto gauss = [&](double distance) {
    return 255.0 * std::exp(-0.5 * distance * distance / (sigma * sigma));
  };
  for (int y = -32; y < 32; ++y) {
    for (int x = -32; x < 32; ++x) {
      const Cell cell{x, y};
      const Eigen::Vector2d center = field.geometry().center(cell);
      const double exact = brute_force_distance(center, surfaces);
      Surface nearest;
      const bool found = field.nearest_surface(cell, nearest);
      if (exact > reach + 1e-4) {
        ASSERT_FALSE(found) << x << ", " << y;
        ASSERT_EQ(field.likelihood(cell), 0);
        ASSERT_EQ(field.distance(cell), LikelihoodField::kFar);
        continue;
      }
      if (exact > reach - 1e-4) {
        continue;  // either answer is good within rounding
      }
      ASSERT_TRUE(found) << x << ", " << y;
      ASSERT_NEAR((nearest.position - center).norm(), exact, 1e-5);
      const double least = std::sqrt(std::max(0.0, exact * exact - step));
      const double most = std::sqrt(exact * exact + step);
      ASSERT_GE(field.distance(cell), std::min(254.0, 255.0 * least / reach - 0.51));
      ASSERT_LE(field.distance(cell), 255.0 * most / reach + 0.51);
      ASSERT_GE(field.likelihood(cell), gauss(most) - 0.51);
      ASSERT_LE(field.likelihood(cell), gauss(least) + 0.51);
    }
  }
}

void expect_same_field(const LikelihoodField& a, const LikelihoodField& b) {
  for (int y = -40; y < 40; ++y) {
    for (int x = -40; x < 40; ++x) {
      const Cell cell{x, y};
      ASSERT_EQ(a.likelihood(cell), b.likelihood(cell)) << x << ", " << y;
      ASSERT_EQ(a.distance(cell), b.distance(cell)) << x << ", " << y;
      Surface in_a;
      Surface in_b;
      const bool found = a.nearest_surface(cell, in_a);
      ASSERT_EQ(found, b.nearest_surface(cell, in_b)) << x << ", " << y;
      if (found) {
        ASSERT_EQ(in_a.position, in_b.position) << x << ", " << y;
        ASSERT_EQ(in_a.double_angle, in_b.double_angle) << x << ", " << y;
      }
    }
  }
}

SurfaceHit random_hit(Random& random) {
  const double x = random.uniform(-1.2, 1.2);
  const double y = random.uniform(-1.2, 1.2);
  const double angle = random.uniform(-kPi, kPi);
  return {{x, y}, {std::cos(angle), std::sin(angle)}};
}

/// One hit for each cell that holds a surface, since a mean depends on the hits' history.
class SingleHits {
 public:
  explicit SingleHits(const GridGeometry& geometry) : geometry_(geometry) {}

  bool add(const SurfaceHit& hit) {
    const Cell cell = geometry_.cell_at(hit.position);
    return hits_.emplace(std::make_pair(cell.x, cell.y), hit).second;
  }
  Cell remove_any(Random& random) {
    auto chosen = hits_.begin();
    std::advance(chosen, static_cast<long>(random.uniform(0.0, static_cast<double>(hits_.size()))));
    const Cell cell{chosen->first.first, chosen->first.second};
    hits_.erase(chosen);
    return cell;
  }
  [[nodiscard]] std::vector<SurfaceHit> hits() const {
    std::vector<SurfaceHit> all;
    for (const auto& [cell, hit] : hits_) {
      all.push_back(hit);
    }
    return all;
  }
  [[nodiscard]] std::vector<Eigen::Vector2d> positions() const {
    std::vector<Eigen::Vector2d> all;
    for (const auto& [cell, hit] : hits_) {
      all.push_back(hit.position);
    }
    return all;
  }
  [[nodiscard]] std::size_t size() const { return hits_.size(); }

 private:
  GridGeometry geometry_;
  std::map<std::pair<int, int>, SurfaceHit> hits_;
};

TEST(LikelihoodField, IsFarFromEverythingAtFirst) {
  const LikelihoodField field(kFieldResolution, field_options());
  Surface surface;
  EXPECT_TRUE(field.empty());
  EXPECT_TRUE(field.surface_cells().empty());
  EXPECT_EQ(field.likelihood({-3, 4}), 0);
  EXPECT_EQ(field.distance({-3, 4}), LikelihoodField::kFar);
  EXPECT_FALSE(field.nearest_surface({-3, 4}, surface));
}

TEST(LikelihoodField, EveryCellKnowsItsNearestSurface) {
  Random random(11);
  for (const int count : {1, 5, 40, 300}) {
    LikelihoodField field(kFieldResolution, field_options());
    SingleHits single(field.geometry());
    for (int i = 0; i < count; ++i) {
      single.add(random_hit(random));
    }
    field.update(single.hits(), {});
    ASSERT_EQ(field.surface_cells().size(), single.size());
    expect_brute_force_answers(field, single.positions());
  }
}

TEST(LikelihoodField, UpdatesEqualAFieldMadeAnew) {
  Random random(12);
  LikelihoodField field(kFieldResolution, field_options());
  SingleHits single(field.geometry());
  for (int round = 0; round < 40; ++round) {
    std::vector<Cell> cleared;
    const int to_remove = static_cast<int>(random.uniform(0.0, 6.0));
    for (int i = 0; i < to_remove && single.size() > 0; ++i) {
      cleared.push_back(single.remove_any(random));
    }
    cleared.push_back({1000, -1000});  // was never occupied
    std::vector<SurfaceHit> added;
    for (int i = 0; i < 8; ++i) {
      const SurfaceHit hit = random_hit(random);
      if (single.add(hit)) {
        added.push_back(hit);
      }
    }
    field.update(added, cleared);
    ASSERT_EQ(field.surface_cells().size(), single.size());
    LikelihoodField anew(kFieldResolution, field_options());
    anew.update(single.hits(), {});
    expect_same_field(field, anew);
    expect_brute_force_answers(field, single.positions());
  }
}

TEST(LikelihoodField, RenderedOnceAfterManyUpdatesItIsTheSame) {
  Random random(14);
  LikelihoodField each_time(kFieldResolution, field_options());
  LikelihoodField once(kFieldResolution, field_options());
  std::vector<LikelihoodField> copies;
  for (int round = 0; round < 40; ++round) {
    std::vector<SurfaceHit> hits;
    for (int i = 0; i < 200; ++i) {
      hits.push_back(random_hit(random));  // of a cell ten or more in all
    }
    std::vector<Cell> cleared = each_time.surface_cells();
    cleared.resize(std::min<std::size_t>(cleared.size(), 30));
    each_time.update(hits, cleared);
    once.take(hits, cleared);
    if (round == 20) {
      copies.push_back(once);
      copies.back().render();
      expect_same_field(copies.back(), each_time);
    }
  }
  once.render();
  EXPECT_EQ(once.surface_cells().size(), each_time.surface_cells().size());
  expect_same_field(once, each_time);
}

TEST(LikelihoodField, NothingIsLeftAfterEverySurfaceIsRemoved) {
  Random random(13);
  LikelihoodField field(kFieldResolution, field_options());
  std::vector<SurfaceHit> hits;
  for (int i = 0; i < 200; ++i) {
    hits.push_back(random_hit(random));
  }
  field.update(hits, {});
  EXPECT_FALSE(field.empty());
  field.update({}, field.surface_cells());
  EXPECT_TRUE(field.empty());
  expect_same_field(field, LikelihoodField(kFieldResolution, field_options()));
}

TEST(LikelihoodField, ASurfaceIsTheMeanOfItsHits) {
  LikelihoodField field(kFieldResolution, field_options());
  field.update({{{0.01, 0.02}, {1.0, 0.0}}, {{0.03, 0.03}, {1.0, 0.0}}}, {});
  field.update({{{0.02, 0.04}, {1.0, 0.0}}}, {});
  Surface surface;
  ASSERT_TRUE(field.nearest_surface({0, 0}, surface));
  EXPECT_LT((surface.position - Eigen::Vector2d(0.02, 0.03)).norm(), 1e-5);
  EXPECT_EQ(surface.hits, 3);
  EXPECT_EQ(field.surface_cells().size(), 1U);
}

TEST(LikelihoodField, ASurfaceCanStillMoveAfterAnyNumberOfHits) {
  LikelihoodField field(kFieldResolution, field_options());
  const std::vector<SurfaceHit> here(500, {{0.005, 0.025}, {1.0, 0.0}});
  const std::vector<SurfaceHit> there(300, {{0.045, 0.025}, {1.0, 0.0}});
  field.update(here, {});
  field.update(there, {});
  Surface surface;
  ASSERT_TRUE(field.nearest_surface({0, 0}, surface));
  EXPECT_NEAR(surface.position.x(), 0.045, 0.002);
  EXPECT_EQ(surface.hits, 64) << "as many as the mean remembers";
}

TEST(LikelihoodField, ANormalAndItsOppositeAreTheSameWall) {
  const double angle = 0.4;
  const Eigen::Vector2d normal(std::cos(angle), std::sin(angle));
  LikelihoodField field(kFieldResolution, field_options());
  field.update({{{0.02, 0.02}, normal}, {{0.03, 0.03}, Eigen::Vector2d(-normal)}}, {});
  Surface surface;
  ASSERT_TRUE(field.nearest_surface({0, 0}, surface));
  EXPECT_LT((surface.double_angle - Eigen::Vector2d(std::cos(0.8), std::sin(0.8))).norm(), 1e-3);
}

TEST(LikelihoodField, AWallKnowsWhichSideOfItWasSeen) {
  const Eigen::Vector2d normal(std::cos(0.4), std::sin(0.4));
  LikelihoodField field(kFieldResolution, field_options());
  const auto surface_after = [&](const Eigen::Vector2d& of_hit) {
    for (int i = 0; i < 20; ++i) {
      field.update({{{0.02, 0.02}, of_hit}}, {});
    }
    Surface surface;
    EXPECT_TRUE(field.nearest_surface({0, 0}, surface));
    return surface;
  };
  const Surface one_side = surface_after(normal);
  EXPECT_LT((one_side.facing - normal).norm(), 0.02);
  EXPECT_FALSE(is_other_side(one_side, normal));
  EXPECT_FALSE(is_other_side(one_side, Eigen::Vector2d(-normal.y(), normal.x()))) << "its end";
  EXPECT_TRUE(is_other_side(one_side, -normal));
  EXPECT_FALSE(is_other_side(one_side, Eigen::Vector2d::Zero())) << "a hit of unknown normal";
  const Surface both_sides = surface_after(-normal);  // of a wall as thin as a cell
  EXPECT_LT(both_sides.facing.norm(), 0.02);
  EXPECT_FALSE(is_other_side(both_sides, normal));
  EXPECT_FALSE(is_other_side(both_sides, -normal));
}

TEST(LikelihoodField, HitsThatDisagreeTellNoDirection) {
  LikelihoodField field(kFieldResolution, field_options());
  field.update({{{0.02, 0.02}, {1.0, 0.0}}, {{0.03, 0.03}, {0.0, 1.0}}}, {});
  field.update({{{1.02, 0.02}, {0.0, 0.0}}}, {});
  Surface surface;
  ASSERT_TRUE(field.nearest_surface({0, 0}, surface));
  EXPECT_LT(surface.double_angle.norm(), 1e-3);
  ASSERT_TRUE(field.nearest_surface({20, 0}, surface));
  EXPECT_LT(surface.double_angle.norm(), 1e-3) << "a hit of unknown normal";
}

TEST(LikelihoodField, CopiesAreSnapshotsBothWays) {
  Random random(14);
  LikelihoodField field(kFieldResolution, field_options());
  std::vector<SurfaceHit> hits;
  for (int i = 0; i < 50; ++i) {
    hits.push_back(random_hit(random));
  }
  field.update(hits, {});
  LikelihoodField snapshot = field;
  LikelihoodField reference(kFieldResolution, field_options());
  reference.update(hits, {});
  field.update({random_hit(random), random_hit(random)}, {field.surface_cells().front()});
  expect_same_field(snapshot, reference);
  LikelihoodField after = field;
  snapshot.update({}, snapshot.surface_cells());
  expect_same_field(field, after);
}

TEST(LikelihoodField, SurfaceCellsAreThoseThatHaveOne) {
  LikelihoodField field(kFieldResolution, field_options());
  field.update({{{-0.01, -0.01}, {1.0, 0.0}}, {{3.01, -7.01}, {1.0, 0.0}}}, {});
  std::vector<Cell> cells = field.surface_cells();
  ASSERT_EQ(cells.size(), 2U);
  for (const Cell& cell : cells) {
    EXPECT_TRUE(field.has_surface(cell));
  }
  EXPECT_TRUE(field.has_surface({-1, -1}));
  EXPECT_TRUE(field.has_surface({60, -141}));
  EXPECT_FALSE(field.has_surface({0, 0}));
}

TEST(LikelihoodField, RefusesAReachOfTooManyCells) {
  LikelihoodFieldOptions options = field_options();
  options.reach = 5.0;
  const std::string text =
      error_text<ConfigurationError>([&] { LikelihoodField field(0.01, options); });
  EXPECT_TRUE(contains(text, "field/reach")) << text;
  EXPECT_TRUE(contains(text, "120")) << text;
  options.reach = 0.999 * 120 * 0.01;
  EXPECT_NO_THROW(LikelihoodField(0.01, options));
}

}  // namespace
}  // namespace matchbox_slam
