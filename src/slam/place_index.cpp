#include "slam/place_index.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <set>
#include <tuple>
#include <utility>

#include "matchbox_slam/geometry/angles.hpp"

namespace matchbox_slam {
namespace {

constexpr double kReach = 30.0;  // [m]
/// Of a direction in which no wall is known: unlike all that is seen.
constexpr std::uint8_t kNoSurface = 255;
/// From which on a direction looks different, however much: a quarter of the way, and as much of a
/// metre.
constexpr std::uint8_t kMaxDifference = 17;

std::uint8_t look_of(double range) {
  constexpr double kSteps = 68.0;  // 234 at the reach, clearly different from nothing
  return static_cast<std::uint8_t>(std::lround(kSteps * std::log1p(std::min(range, kReach))));
}

/// How far it is to a wall [m]; the reach where there is none.
double range_to_wall(const LikelihoodField& field, const Eigen::Vector2d& from,
                     const Eigen::Vector2d& direction, double reach) {
  const double cell = field.geometry().resolution();
  const double metres = field.metres_per_step();
  for (double at = 0.0; at < reach;) {
    const double distance =
        metres * field.distance(field.geometry().cell_at(from + at * direction));
    if (distance <= LikelihoodField::kMaxCellsToWall * cell) {
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
    look[i] = range < kReach ? look_of(range) : kNoSurface;
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
    const double sectors = sectors_to(point.position);
    const auto sector = std::min(static_cast<std::size_t>(sectors), kSectors - 1);
    const double beside = std::abs(sectors - static_cast<double>(sector) - 0.5);
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

/// So many headings are compared by one instruction. What the compiler makes of loops over bytes
/// takes four times as long.
constexpr std::size_t kVectorLanes = 16;
using Bytes = std::uint8_t __attribute__((vector_size(kVectorLanes)));

/// Those beyond the last heading are of no meaning.
template <std::size_t kCount>
using Differences =
    std::array<std::uint16_t, (kCount + kVectorLanes - 1) / kVectorLanes * kVectorLanes>;

/// Of a place and a scan, by how many sectors the scan is turned. Sums are kept as bytes as long as
/// they fit.
template <std::size_t kCount>
Differences<kCount> differences_of(const std::array<std::uint8_t, kCount>& place,
                                   const std::vector<SeenWall>& walls) {
  constexpr std::size_t kWallsPerByte = 255 / kMaxDifference;
  const Bytes most = Bytes{} + kMaxDifference;
  Differences<kCount> sums = {};
  std::array<std::uint8_t, kCount + sums.size()> round = {};
  std::copy(place.begin(), place.end(), round.begin());
  std::copy(place.begin(), place.end(), round.begin() + kCount);
  for (std::size_t first = 0; first < walls.size(); first += kWallsPerByte) {
    std::array<Bytes, sums.size() / kVectorLanes> some = {};
    for (std::size_t k = first; k < std::min(first + kWallsPerByte, walls.size()); ++k) {
      const Bytes look = Bytes{} + walls[k].look;
      for (std::size_t i = 0; i < some.size(); ++i) {
        Bytes turned;
        std::memcpy(&turned, round.data() + walls[k].sector + i * kVectorLanes, kVectorLanes);
        const Bytes apart = (turned > look ? turned : look) - (turned < look ? turned : look);
        some[i] += apart < most ? apart : most;
      }
    }
    for (std::size_t i = 0; i < sums.size(); ++i) {
      sums[i] = static_cast<std::uint16_t>(sums[i] + some[i / kVectorLanes][i % kVectorLanes]);
    }
  }
  return sums;
}

HalfLook half_of(const PlaceLook& look) {
  HalfLook half;
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
std::vector<std::size_t> worth_a_look(const std::vector<HalfLook>& places,
                                      const std::vector<SeenWall>& walls) {
  constexpr std::size_t kMinCandidates = 1000;
  constexpr std::size_t kCandidateDivisor = 8;
  std::vector<std::size_t> numbers(places.size());
  std::iota(numbers.begin(), numbers.end(), 0);
  const std::size_t most = std::max(kMinCandidates, places.size() / kCandidateDivisor);
  if (numbers.size() <= most) {
    return numbers;
  }
  const std::vector<SeenWall> half = half_of(walls);
  std::vector<std::uint16_t> least(places.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto differences = differences_of(places[i], half);
    least[i] = *std::min_element(differences.begin(), differences.begin() + kSectors / 2);
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
  // As far as a search from there reaches.
  return a.component == b.component &&
         are_near(a.component_from_base, b.component_from_base, 1.0, 0.35);
}

/// Places on a lattice where a robot has room, near a key scan and in its sight.
class PlacesAround {
 public:
  explicit PlacesAround(const LikelihoodField& field) : field_(field) {}

  /// Those that were not known.
  template <typename Known, typename Take>
  void find(const Eigen::Vector2d& from, const Known& is_known, const Take& take) const {
    constexpr double kFarthest = 1e6;  // [m]; a damaged file may say anything
    if (!(from.cwiseAbs().maxCoeff() < kFarthest)) {
      return;
    }
    const auto x = static_cast<int>(std::lround(from.x() / kStep));
    const auto y = static_cast<int>(std::lround(from.y() / kStep));
    for (int dy = -kNeighbourSteps; dy <= kNeighbourSteps; ++dy) {
      for (int dx = -kNeighbourSteps; dx <= kNeighbourSteps; ++dx) {
        const LatticePoint point{y + dy, x + dx};
        if (!is_known(point) && is_free(at(point), from)) {
          take(point);
        }
      }
    }
  }

  [[nodiscard]] static Eigen::Vector2d at(const LatticePoint& point) {
    return {kStep * point.second, kStep * point.first};
  }

 private:
  static constexpr double kStep = 1.0;       // [m]
  static constexpr int kNeighbourSteps = 2;  // steps

  [[nodiscard]] bool is_free(const Eigen::Vector2d& place, const Eigen::Vector2d& from) const {
    const Eigen::Vector2d way = place - from;
    const double distance = way.norm();
    return field_.distance(field_.geometry().cell_at(place)) > LikelihoodField::kFar / 2 &&
           (distance < 1e-3 || range_to_wall(field_, from, way / distance, distance) >= distance);
  }

  const LikelihoodField& field_;
};

}  // namespace

PlaceIndex::PlaceIndex(const std::vector<MapComponent>& components, std::size_t active) {
  static_cast<void>(grow(components, active, std::numeric_limits<std::size_t>::max()));
}

bool PlaceIndex::grow(const std::vector<MapComponent>& components, std::size_t active,
                      std::size_t key_scans) {
  while (!is_complete_ && component_ < components.size()) {
    const PlacedScans& keys = components[component_].key_scans.all();
    if (component_ == active || next_ >= keys.size()) {
      ++component_;
      next_ = 0;
      lattice_.clear();
    } else if (key_scans-- == 0) {
      return false;
    } else {
      take_around(keys[next_++].map_from_base.translation(), components[component_].map.field);
      ++taken_;
    }
  }
  if (!is_complete_) {
    finish();
  }
  return true;
}

void PlaceIndex::take_around(const Eigen::Vector2d& from, const LikelihoodField& field) {
  PlacesAround(field).find(
      from, [this](const LatticePoint& point) { return lattice_.count(point) > 0; },
      [&](const LatticePoint& point) {
        lattice_.insert(point);
        places_.push_back({component_, point, look_from(PlacesAround::at(point), field)});
      });
}

/// In an order that does not depend on that of the key scans.
void PlaceIndex::finish() {
  std::sort(places_.begin(), places_.end(), [](const Place& a, const Place& b) {
    return std::tie(a.component, a.at) < std::tie(b.component, b.at);
  });
  halves_.reserve(places_.size());
  for (const Place& place : places_) {
    halves_.push_back(half_of(place.look));
  }
  is_complete_ = true;
}

std::vector<LikelyPlace> PlaceIndex::look_up(const PointScan& scan, std::size_t most,
                                             std::vector<LikelyPlace> known) const {
  constexpr std::size_t kHeadingSpacing = 4;  // sectors between two headings at one place
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
  for (const std::size_t i : worth_a_look(halves_, walls)) {
    auto differences = differences_of(places_[i].look, walls);
    const auto end = differences.begin() + kSectors;
    for (int heading = 0; heading < 2; ++heading) {
      const auto best = std::min_element(differences.begin(), end);
      const auto turned = static_cast<std::size_t>(best - differences.begin());
      all.push_back({*best, static_cast<std::uint16_t>(turned), static_cast<std::uint32_t>(i)});
      for (std::size_t k = kSectors - kHeadingSpacing; k <= kSectors + kHeadingSpacing; ++k) {
        differences[(turned + k) % kSectors] = std::numeric_limits<std::uint16_t>::max();
      }
    }
  }
  const double worst = static_cast<double>(kMaxDifference) * static_cast<double>(walls.size());
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
    const Eigen::Vector2d at = PlacesAround::at(place.at);
    const LikelyPlace found{
        place.component,
        {at.x(), at.y(), wrap_angle(static_cast<double>(next.sectors) * kSectorWidth)},
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
