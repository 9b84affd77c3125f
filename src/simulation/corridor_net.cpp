#include "simulation/corridor_net.hpp"

#include <algorithm>
#include <limits>

namespace matchbox_slam {
namespace {

constexpr double kUnreachedDistance = std::numeric_limits<double>::infinity();

}  // namespace

std::size_t CorridorNet::crossing_at(const Eigen::Vector2d& place) {
  const auto found = std::find_if(
      crossings_.begin(), crossings_.end(),
      [&](const Eigen::Vector2d& crossing) { return (crossing - place).norm() < 1e-6; });
  if (found == crossings_.end()) {
    crossings_.push_back(place);
    return crossings_.size() - 1;
  }
  return static_cast<std::size_t>(found - crossings_.begin());
}

void CorridorNet::add(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  const std::size_t first = crossing_at(from);
  const std::size_t second = crossing_at(to);
  corridors_.push_back({first, second, (to - from).norm()});
}

std::vector<double> CorridorNet::ways_home() const {
  std::vector<double> ways(crossings_.size(), kUnreachedDistance);
  ways.front() = 0.0;
  for (std::size_t round = 0; round < crossings_.size(); ++round) {
    for (const Corridor& corridor : corridors_) {
      ways[corridor.from] = std::min(ways[corridor.from], ways[corridor.to] + corridor.length);
      ways[corridor.to] = std::min(ways[corridor.to], ways[corridor.from] + corridor.length);
    }
  }
  return ways;
}

std::vector<std::size_t> CorridorNet::tour(double length, Random& random) const {
  constexpr double kTurnBackCost = 1e6;  // worse than any other corridor
  const std::vector<double> home = ways_home();
  std::vector<double> driven(corridors_.size(), 0.0);
  std::vector<std::size_t> tour = {0};
  std::size_t last = corridors_.size();
  for (double way = 0.0; way < length || tour.back() != 0;) {
    const bool is_going_home = way >= length;
    std::size_t next = corridors_.size();
    double least = kUnreachedDistance;
    for (std::size_t i = 0; i < corridors_.size(); ++i) {
      const Corridor& corridor = corridors_[i];
      if (corridor.from != tour.back() && corridor.to != tour.back()) {
        continue;
      }
      const std::size_t there = corridor.from == tour.back() ? corridor.to : corridor.from;
      const double cost = is_going_home
                              ? corridor.length + home[there]
                              : driven[i] + random.uniform() + (i == last ? kTurnBackCost : 0.0);
      if (cost < least) {
        least = cost;
        next = i;
      }
    }
    const Corridor& corridor = corridors_[next];
    tour.push_back(corridor.from == tour.back() ? corridor.to : corridor.from);
    driven[next] += 1.0;
    way += corridor.length;
    last = next;
  }
  return tour;
}

}  // namespace matchbox_slam
