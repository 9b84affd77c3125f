// Three ways to find the same pose: one candidate after the other, all translations of a rotation
// at once, and by bounds; over the windows of the literature, and by beams, window and map size.

#include "matching/olson/correlative_search.hpp"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "benchmark_scene.hpp"
#include "matching/olson/field_window.hpp"
#include "matching/olson/window_sums.hpp"

namespace matchbox_slam {
namespace {

struct Window {
  const char* name;
  double half_xy;     // [m]
  double half_theta;  // [rad]
  double step_xy;     // [m]
  double step_theta;  // [rad]
};

const std::array<Window, 5> kWindows = {
    Window{"0.2 m, 0.2 rad to each side at 1 cm, 0.1 deg", 0.2, 0.2, 0.01, degrees_to_radians(0.1)},
    Window{"0.5 m x 20 deg at 2.5 cm, 0.5 deg", 0.25, degrees_to_radians(10.0), 0.025,
           degrees_to_radians(0.5)},
    Window{"4 m x 90 deg at 2.5 cm, 0.5 deg", 2.0, degrees_to_radians(45.0), 0.025,
           degrees_to_radians(0.5)},
    Window{"7 m, 30 deg to each side at 5 cm, 0.5 deg", 7.0, degrees_to_radians(30.0), 0.05,
           degrees_to_radians(0.5)},
    Window{"5 m, 180 deg to each side at 5 cm, 0.5 deg", 5.0, degrees_to_radians(180.0), 0.05,
           degrees_to_radians(0.5)},
};

struct Search {
  std::vector<SearchPoint> points;
  SearchLattice lattice;
  SearchScoring scoring;
};

/// Every beam for itself, and a prediction off by a good part of the window.
Search make_search(const MatchScene& scene, const Window& window) {
  Search search;
  double top = 0.0;
  for (const ScanPoint& point : scene.scan.points) {
    const double weight = std::clamp(point.weight * 160.0, 1.0, 16.0);
    search.points.push_back({point.position, static_cast<int>(std::lround(weight))});
    top += 255.0 * search.points.back().weight;
  }
  const double resolution = scene.map.field.geometry().resolution();
  search.lattice.center = shifted(
      scene.map_from_base, {0.6 * window.half_xy, -0.5 * window.half_xy, 0.5 * window.half_theta});
  search.lattice.steps_per_cell = static_cast<int>(std::lround(resolution / window.step_xy));
  search.lattice.half_xy = static_cast<int>(std::lround(window.half_xy / window.step_xy));
  search.lattice.half_theta = static_cast<int>(std::lround(window.half_theta / window.step_theta));
  search.lattice.step_theta = window.step_theta;
  for (std::size_t i = 0; i < 256; ++i) {
    search.scoring.value_of_likelihood[i] = static_cast<std::uint8_t>(i);
  }
  // The window's edge is 1.7 standard deviations of the prior away, as of a uniform error.
  const double xy = 3.0 / (window.half_xy * window.half_xy);
  const double theta = 3.0 / (window.half_theta * window.half_theta);
  search.scoring.prior_weight = 0.03 * top;
  search.scoring.prior_information = Eigen::Vector3d(xy, xy, theta).asDiagonal();
  return search;
}

/// The points of one rotation: cell and step within it.
struct Turned {
  std::vector<Cell> cells;
  std::vector<Cell> steps;
};

Turned turn(const Search& search, int theta, double resolution) {
  const SearchLattice& lattice = search.lattice;
  const double angle = lattice.center.theta + lattice.step_theta * theta;
  const Pose2 pose{lattice.center.x, lattice.center.y, angle};
  const int n = lattice.steps_per_cell;
  Turned turned;
  for (const SearchPoint& point : search.points) {
    const Eigen::Vector2d at = pose * point.position * (n / resolution);
    const Cell step{static_cast<int>(std::floor(at.x())), static_cast<int>(std::floor(at.y()))};
    const Cell cell{static_cast<int>(std::floor((step.x + 0.5) / n)),
                    static_cast<int>(std::floor((step.y + 0.5) / n))};
    turned.cells.push_back(cell);
    turned.steps.push_back({step.x - n * cell.x, step.y - n * cell.y});
  }
  return turned;
}

/// A table large enough for every look-up of a window.
FieldWindow table_around(const MatchScene& scene, const Search& search) {
  double farthest = 0.0;
  for (const SearchPoint& point : search.points) {
    farthest = std::max(farthest, point.position.norm());
  }
  const double resolution = scene.map.field.geometry().resolution();
  const double reach = farthest + 2.0 * search.lattice.half_xy * resolution + 1.0;
  const Eigen::Vector2d center = search.lattice.center.translation();
  const Eigen::Vector2d margin(reach, reach);
  const GridGeometry& geometry = scene.map.field.geometry();
  FieldWindow table;
  table.read(scene.map.field,
             {geometry.cell_at(center - margin), geometry.cell_at(center + margin)},
             search.scoring.value_of_likelihood);
  return table;
}

std::int64_t naive(const MatchScene& scene, const Search& search) {
  const FieldWindow table = table_around(scene, search);
  const SearchLattice& lattice = search.lattice;
  const int n = lattice.steps_per_cell;
  std::int64_t best = 0;
  for (int theta = -lattice.half_theta; theta <= lattice.half_theta; ++theta) {
    const Turned turned = turn(search, theta, scene.map.field.geometry().resolution());
    for (int y = -lattice.half_xy; y <= lattice.half_xy; ++y) {
      for (int x = -lattice.half_xy; x <= lattice.half_xy; ++x) {
        std::int64_t sum = 0;
        for (std::size_t i = 0; i < turned.cells.size(); ++i) {
          // Positive, so that the division rounds down.
          const int shift = 4 * lattice.half_xy;
          const int cell_x = turned.cells[i].x + (turned.steps[i].x + x + n * shift) / n - shift;
          const int cell_y = turned.cells[i].y + (turned.steps[i].y + y + n * shift) / n - shift;
          sum += std::int64_t{search.points[i].weight} *
                 table.data()[(cell_y - table.layout().corner.y) * table.pitch() + cell_x -
                              table.layout().corner.x];
        }
        best = std::max(best, sum);
      }
    }
  }
  return best;
}

/// All translations that are whole cells apart at once, for each step within a cell.
std::int64_t dense(const MatchScene& scene, const Search& search) {
  const FieldWindow table = table_around(scene, search);
  const SearchLattice& lattice = search.lattice;
  const int n = lattice.steps_per_cell;
  const int half = lattice.half_xy / n + 1;
  const int rows = 2 * half + 1;
  const int columns = summed_columns(rows);
  std::vector<std::uint16_t> weights;
  for (const SearchPoint& point : search.points) {
    weights.push_back(static_cast<std::uint16_t>(point.weight));
  }
  std::vector<std::int32_t> offsets(weights.size());
  std::vector<std::uint32_t> sums(static_cast<std::size_t>(summed_rows(rows, columns) * columns));
  std::int64_t best = 0;
  for (int theta = -lattice.half_theta; theta <= lattice.half_theta; ++theta) {
    const Turned turned = turn(search, theta, scene.map.field.geometry().resolution());
    for (int step_y = 0; step_y < n; ++step_y) {
      for (int step_x = 0; step_x < n; ++step_x) {
        for (std::size_t i = 0; i < offsets.size(); ++i) {
          const int x = turned.cells[i].x + (turned.steps[i].x + step_x >= n ? 1 : 0) - half;
          const int y = turned.cells[i].y + (turned.steps[i].y + step_y >= n ? 1 : 0) - half;
          offsets[i] = static_cast<std::int32_t>((y - table.layout().corner.y) * table.pitch() + x -
                                                 table.layout().corner.x);
        }
        sum_windows({table.data(), table.pitch(), offsets.data(), weights.data(), weights.size()},
                    summed_rows(rows, columns), columns, sums.data());
        best =
            std::max(best, static_cast<std::int64_t>(*std::max_element(sums.begin(), sums.end())));
      }
    }
  }
  return best;
}

void search_naively(benchmark::State& state) {
  const Window& window = kWindows.at(static_cast<std::size_t>(state.range(0)));
  const MatchScene& scene = benchmark_scene(kCommonBeams);
  const Search search = make_search(scene, window);
  for (auto _ : state) {
    benchmark::DoNotOptimize(naive(scene, search));
  }
  state.SetLabel(window.name);
}
BENCHMARK(search_naively)->ArgName("window")->DenseRange(0, 1)->Unit(benchmark::kMillisecond);

void search_densely(benchmark::State& state) {
  const Window& window = kWindows.at(static_cast<std::size_t>(state.range(0)));
  const MatchScene& scene = benchmark_scene(kCommonBeams);
  const Search search = make_search(scene, window);
  for (auto _ : state) {
    benchmark::DoNotOptimize(dense(scene, search));
  }
  state.SetLabel(window.name);
}
BENCHMARK(search_densely)->ArgName("window")->DenseRange(0, 2)->Unit(benchmark::kMillisecond);

void search_by_bounds(const MatchScene& scene, const Window& window, benchmark::State& state) {
  const Search search = make_search(scene, window);
  SearchMemory memory;
  for (auto _ : state) {
    benchmark::DoNotOptimize(search_lattice(search.points, scene.map.field, search.lattice,
                                            search.scoring, {}, {}, memory));
  }
  state.SetLabel(window.name);
}

void search_pruned(benchmark::State& state) {
  search_by_bounds(benchmark_scene(kCommonBeams),
                   kWindows.at(static_cast<std::size_t>(state.range(0))), state);
}
BENCHMARK(search_pruned)->ArgName("window")->DenseRange(0, 2)->Unit(benchmark::kMillisecond);

void search_pruned_by_beams(benchmark::State& state) {
  search_by_bounds(benchmark_scene(static_cast<int>(state.range(0))), kWindows[0], state);
}
BENCHMARK(search_pruned_by_beams)
    ->ArgName("beams")
    ->RangeMultiplier(10)
    ->Range(kFewestBeams, kMostBeams)
    ->Unit(benchmark::kMillisecond);

/// Half the width of the window, at 2.5 cm and 0.5 degrees, with 20 degrees to each side.
void search_pruned_by_window(benchmark::State& state) {
  const Window window{"20 deg to each side", 0.01 * static_cast<double>(state.range(0)),
                      degrees_to_radians(20.0), 0.025, degrees_to_radians(0.5)};
  search_by_bounds(benchmark_scene(kCommonBeams), window, state);
}
BENCHMARK(search_pruned_by_window)
    ->ArgName("cm")
    ->RangeMultiplier(2)
    ->Range(25, 800)
    ->Unit(benchmark::kMillisecond);

/// The scene amid a map of so many scans along the route.
MatchScene scene_in_map(int scans) {
  MatchScene scene = benchmark_scene(kCommonBeams);
  for (const LocatedPoints& key : scans_along_route(kCommonBeams, 200.0, scans)) {
    insert_scan(key.scan, key.map_from_base, {}, scene.map);
  }
  return scene;
}

void search_pruned_by_map(benchmark::State& state) {
  search_by_bounds(scene_in_map(static_cast<int>(state.range(0))), kWindows[0], state);
}
BENCHMARK(search_pruned_by_map)
    ->ArgName("scans")
    ->Arg(1)
    ->Arg(30)
    ->Arg(300)
    ->Unit(benchmark::kMillisecond);

/// As wide as for loops, and for a robot that is lost.
void search_pruned_widely(benchmark::State& state) {
  search_by_bounds(scene_in_map(300), kWindows.at(static_cast<std::size_t>(state.range(0))), state);
}
BENCHMARK(search_pruned_widely)->ArgName("window")->DenseRange(3, 4)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace matchbox_slam
