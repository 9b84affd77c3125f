#include "slam/place_index.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <tuple>
#include <utility>

#include "matchbox_slam/geometry/angles.hpp"

namespace matchbox_slam {
namespace {

constexpr std::size_t kSectors = std::tuple_size_v<PlaceLook>;
constexpr double kWidth = 2.0 * kPi / static_cast<double>(kSectors);  // [rad]
constexpr double kReach = 30.0;                                       // [m]
/// Of a direction in which no wall is known: unlike all that is seen.
constexpr std::uint8_t kNothing = 255;
/// From which on a direction looks different, however much: a quarter of the way, and as much of a
/// metre.
constexpr std::uint8_t kDifferent = 17;

std::uint8_t look_of(double range) {
  constexpr double kSteps = 68.0;  // 234 at the reach, clearly different from nothing
  return static_cast<std::uint8_t>(std::lround(kSteps * std::log1p(std::min(range, kReach))));
}

double angle_of(std::size_t sector) { return (static_cast<double>(sector) + 0.5) * kWidth - kPi; }

/// How far it is to a wall [m]; the reach where there is none.
double range_to_wall(const LikelihoodField& field, const Eigen::Vector2d& from,
                     const Eigen::Vector2d& direction, double reach) {
  constexpr double kOnWall = 0.6;  // of a cell
  const double cell = field.geometry().resolution();
  const double metres = field.options().reach / LikelihoodField::kFar;
  for (double at = 0.0; at < reach;) {
    const double distance =
        metres * field.distance(field.geometry().cell_at(from + at * direction));
    if (distance <= kOnWall * cell) {
      return at;
    }
    at += std::max(distance - cell, 0.5 * cell);
  }
  return reach;
}

PlaceLook look_from(const Eigen::Vector2d& place, const LikelihoodField& field) {
  PlaceLook look;
  for (std::size_t i = 0; i < kSectors; ++i) {
    const double angle = angle_of(i);
    const double range = range_to_wall(field, place, {std::cos(angle), std::sin(angle)}, kReach);
    look[i] = range < kReach ? look_of(range) : kNothing;
  }
  return look;
}

/// A direction in which a scan saw something.
struct SeenWall {
  std::size_t sector;
  std::uint8_t look;
};

/// In each direction what is nearest to its middle.
std::vector<SeenWall> walls_of(const PointScan& scan) {
  std::array<double, kSectors> off;
  off.fill(std::numeric_limits<double>::infinity());
  PlaceLook look = {};
  for (const ScanPoint& point : scan.points) {
    const double range = point.position.norm();
    if (!(point.weight > 0.0 && range < kReach)) {
      continue;
    }
    const double turns = (std::atan2(point.position.y(), point.position.x()) + kPi) / kWidth;
    const auto sector = std::min(static_cast<std::size_t>(turns), kSectors - 1);
    const double beside = std::abs(turns - static_cast<double>(sector) - 0.5);
    if (beside < off[sector]) {
      off[sector] = beside;
      look[sector] = look_of(range);
    }
  }
  std::vector<SeenWall> walls;
  for (std::size_t i = 0; i < kSectors; ++i) {
    if (std::isfinite(off[i])) {
      walls.push_back({i, look[i]});
    }
  }
  return walls;
}

/// Of a place and a scan, by how many sectors the scan is turned. The compiler makes sixteen
/// headings of one instruction, where sums of bytes are kept as long as they fit.
template <std::size_t kCount>
std::array<std::uint16_t, kCount> differences_of(const std::array<std::uint8_t, kCount>& place,
                                                 const std::vector<SeenWall>& walls) {
  constexpr std::size_t kFit = 255 / kDifferent;
  std::array<std::uint8_t, 2 * kCount> twice;
  std::copy(place.begin(), place.end(), twice.begin());
  std::copy(place.begin(), place.end(), twice.begin() + kCount);
  std::array<std::uint16_t, kCount> sums = {};
  for (std::size_t first = 0; first < walls.size(); first += kFit) {
    std::array<std::uint8_t, kCount> some = {};
    for (std::size_t k = first; k < std::min(first + kFit, walls.size()); ++k) {
      const std::uint8_t* turned = twice.data() + walls[k].sector;
      const std::uint8_t look = walls[k].look;
      for (std::size_t i = 0; i < kCount; ++i) {
        const std::uint8_t more = std::max(turned[i], look);
        const std::uint8_t less = std::min(turned[i], look);
        const auto apart = static_cast<std::uint8_t>(more - less);
        some[i] = static_cast<std::uint8_t>(some[i] + std::min(apart, kDifferent));
      }
    }
    for (std::size_t i = 0; i < kCount; ++i) {
      sums[i] = static_cast<std::uint16_t>(sums[i] + some[i]);
    }
  }
  return sums;
}

/// Every other direction of a place.
std::array<std::uint8_t, kSectors / 2> half_of(const PlaceLook& look) {
  std::array<std::uint8_t, kSectors / 2> half;
  for (std::size_t i = 0; i < half.size(); ++i) {
    half[i] = look[2 * i];
  }
  return half;
}

std::vector<SeenWall> half_of(const std::vector<SeenWall>& walls) {
  std::vector<SeenWall> half;
  for (const SeenWall& wall : walls) {
    if (wall.sector % 2 == 0) {
      half.push_back({wall.sector / 2, wall.look});
    }
  }
  return half;
}

/// Where there are many, those that look most alike in every other direction: in a quarter of the
/// time.
template <typename Places>
std::vector<std::size_t> worth_a_look(const Places& places, const std::vector<SeenWall>& walls) {
  constexpr std::size_t kLeast = 1000;
  constexpr std::size_t kOfPlaces = 8;
  std::vector<std::size_t> numbers(places.size());
  std::iota(numbers.begin(), numbers.end(), 0);
  const std::size_t most = std::max(kLeast, places.size() / kOfPlaces);
  if (numbers.size() <= most) {
    return numbers;
  }
  const std::vector<SeenWall> half = half_of(walls);
  std::vector<std::uint16_t> least(places.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto differences = differences_of(half_of(places[i].look), half);
    least[i] = *std::min_element(differences.begin(), differences.end());
  }
  const auto is_more_alike = [&](std::size_t a, std::size_t b) {
    return std::tie(least[a], a) < std::tie(least[b], b);
  };
  const auto end = numbers.begin() + static_cast<std::ptrdiff_t>(most);
  std::nth_element(numbers.begin(), end, numbers.end(), is_more_alike);
  numbers.erase(end, numbers.end());
  return numbers;
}

bool is_near(const LikelyPlace& a, const LikelyPlace& b) {
  constexpr double kNear = 1.0;     // [m], as far as a search from there reaches
  constexpr double kTurned = 0.35;  // [rad]
  return a.part == b.part &&
         (a.part_from_base.translation() - b.part_from_base.translation()).norm() < kNear &&
         std::abs(wrap_angle(a.part_from_base.theta - b.part_from_base.theta)) < kTurned;
}

/// Places on a lattice where a robot has room, near a key scan of the part and in its sight.
std::vector<Eigen::Vector2d> places_of(const MapPart& part) {
  constexpr double kStep = 1.0;  // [m]
  constexpr int kBeside = 2;     // steps
  const LikelihoodField& field = part.map.field;
  const GridGeometry& geometry = field.geometry();
  std::set<std::pair<int, int>> lattice;
  for (const PlacedScan& key : part.key_scans.all()) {
    const Eigen::Vector2d from = key.map_from_base.translation();
    if (!(from.cwiseAbs().maxCoeff() < 1e6)) {
      continue;
    }
    const auto x = static_cast<int>(std::lround(from.x() / kStep));
    const auto y = static_cast<int>(std::lround(from.y() / kStep));
    for (int dy = -kBeside; dy <= kBeside; ++dy) {
      for (int dx = -kBeside; dx <= kBeside; ++dx) {
        if (lattice.count({y + dy, x + dx}) > 0) {
          continue;
        }
        const Eigen::Vector2d place(kStep * (x + dx), kStep * (y + dy));
        const Eigen::Vector2d way = place - from;
        const double distance = way.norm();
        const bool has_room = field.distance(geometry.cell_at(place)) > LikelihoodField::kFar / 2;
        if (has_room &&
            (distance < 1e-3 || range_to_wall(field, from, way / distance, distance) >= distance)) {
          lattice.insert({y + dy, x + dx});
        }
      }
    }
  }
  std::vector<Eigen::Vector2d> places;
  places.reserve(lattice.size());
  for (const auto& [y, x] : lattice) {
    places.emplace_back(kStep * x, kStep * y);
  }
  return places;
}

}  // namespace

PlaceIndex::PlaceIndex(const std::vector<MapPart>& parts, std::size_t apart) {
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (i == apart) {
      continue;
    }
    for (const Eigen::Vector2d& place : places_of(parts[i])) {
      places_.push_back({i, place, look_from(place, parts[i].map.field)});
    }
  }
}

std::vector<LikelyPlace> PlaceIndex::look_up(const PointScan& scan, std::size_t most,
                                             std::vector<LikelyPlace> known) const {
  constexpr std::size_t kApart = 4;  // sectors between two headings at one place
  const std::vector<SeenWall> walls = walls_of(scan);
  if (walls.empty()) {
    return {};
  }
  struct Turned {
    std::uint16_t difference;
    std::uint16_t sectors;
    std::uint32_t place;
  };
  std::vector<Turned> all;
  for (const std::size_t i : worth_a_look(places_, walls)) {
    auto differences = differences_of(places_[i].look, walls);
    for (int heading = 0; heading < 2; ++heading) {
      const auto best = std::min_element(differences.begin(), differences.end());
      const auto turned = static_cast<std::size_t>(best - differences.begin());
      all.push_back({*best, static_cast<std::uint16_t>(turned), static_cast<std::uint32_t>(i)});
      for (std::size_t k = kSectors - kApart; k <= kSectors + kApart; ++k) {
        differences[(turned + k) % kSectors] = std::numeric_limits<std::uint16_t>::max();
      }
    }
  }
  const double worst = static_cast<double>(kDifferent) * static_cast<double>(walls.size());
  std::vector<LikelyPlace> likely;
  const auto is_more_alike = [](const Turned& a, const Turned& b) {
    return std::tie(a.difference, a.place, a.sectors) < std::tie(b.difference, b.place, b.sectors);
  };
  // Few are asked for, and neighbours of those are left out: no need to sort all.
  const auto less_alike = [&](const Turned& a, const Turned& b) { return is_more_alike(b, a); };
  std::make_heap(all.begin(), all.end(), less_alike);
  for (auto end = all.end(); end != all.begin() && likely.size() < most; --end) {
    std::pop_heap(all.begin(), end, less_alike);
    const Turned& next = *(end - 1);
    const Place& place = places_[next.place];
    const LikelyPlace found{
        place.part,
        {place.at.x(), place.at.y(), wrap_angle(static_cast<double>(next.sectors) * kWidth)},
        static_cast<double>(next.difference) / worst};
    const auto is_same = [&](const LikelyPlace& other) { return is_near(found, other); };
    if (std::none_of(known.begin(), known.end(), is_same)) {
      known.push_back(found);
      likely.push_back(found);
    }
  }
  return likely;
}

}  // namespace matchbox_slam
