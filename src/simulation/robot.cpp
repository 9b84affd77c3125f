#include "simulation/robot.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace matchbox_slam {
namespace {

constexpr double kStep = 0.01;             // [s]
constexpr double kLookahead = 0.5;         // [m]
constexpr double kArrivalDistance = 0.01;  // [m] before the end of the route
constexpr double kTurnOnSpotAngle = 1.0;   // [rad] off the way: stop and turn
constexpr double kDriveOnAngle = 0.03;     // [rad] off the way: drive on
constexpr double kMinSpeed = 0.02;         // [m/s], so that the braking curve reaches its end

/// Moves on a circle, or on a line where the turn is none.
Pose2 advance(const RobotMotion::Step& step, double time) {
  const double half_turn = 0.5 * step.turn_rate * time;
  // Chord of the arc: sin(h)/h times its length, along the mean heading.
  const double shrink = std::abs(half_turn) < 1e-6 ? 1.0 - half_turn * half_turn / 6.0
                                                   : std::sin(half_turn) / half_turn;
  const double chord = step.speed * time * shrink;
  const Pose2 motion{chord * std::cos(half_turn), chord * std::sin(half_turn),
                     wrap_angle(2.0 * half_turn)};
  return step.world_from_base * motion;
}

/// The lines of a route, addressed by the distance from its start.
class RouteLine {
 public:
  explicit RouteLine(const Route& route) {
    for (const Eigen::Vector2d& point : route.waypoints) {
      const double step = points_.empty() ? 0.0 : (point - points_.back()).norm();
      if (points_.empty() || step > 0.0) {
        at_.push_back(points_.empty() ? 0.0 : at_.back() + step);
        points_.push_back(point);
      }
    }
    if (points_.size() < 2) {
      throw std::invalid_argument("the route has " + std::to_string(points_.size()) +
                                  " different way-points; it must have at least 2");
    }
  }

  [[nodiscard]] double length() const { return at_.back(); }
  [[nodiscard]] std::size_t size() const { return points_.size(); }

  /// Distance of a way-point from the start.
  [[nodiscard]] double at(std::size_t i) const { return at_[i]; }

  /// The first way-point farther than that from the start.
  [[nodiscard]] std::size_t next(double at) const {
    return static_cast<std::size_t>(std::upper_bound(at_.begin(), at_.end(), at) - at_.begin());
  }

  /// Turn of the route at a way-point between the first and the last, not negative.
  [[nodiscard]] double turn(std::size_t i) const {
    const Eigen::Vector2d in = points_[i] - points_[i - 1];
    const Eigen::Vector2d out = points_[i + 1] - points_[i];
    return std::abs(std::atan2(in.x() * out.y() - in.y() * out.x(), in.dot(out)));
  }

  /// The point at a distance from the start; straight on behind the end.
  [[nodiscard]] Eigen::Vector2d point(double at) const {
    const auto above = std::upper_bound(at_.begin() + 1, at_.end() - 1, at);
    const std::size_t i = static_cast<std::size_t>(above - at_.begin());
    const double fraction = (at - at_[i - 1]) / (at_[i] - at_[i - 1]);
    return points_[i - 1] + fraction * (points_[i] - points_[i - 1]);
  }

 private:
  std::vector<Eigen::Vector2d> points_;
  std::vector<double> at_;
};

/// What the driver wants.
struct Command {
  double speed = 0.0;
  double turn_rate = 0.0;
  bool has_arrived = false;
};

/// Steers towards a point that runs ahead on the route.
class Driver {
 public:
  Driver(const Route& route, const DriveOptions& options) : line_(route), options_(options) {}

  Command decide(const RobotMotion::Step& robot) {
    const Eigen::Vector2d position = robot.world_from_base.translation();
    const double end = line_.length() + kLookahead;
    while (ahead_ < end && (line_.point(ahead_) - position).norm() < kLookahead) {
      ahead_ = std::min(ahead_ + 0.1 * kArrivalDistance, end);
    }
    if (end - ahead_ < kArrivalDistance) {
      return {0.0, 0.0, true};
    }
    const Eigen::Vector2d way = line_.point(ahead_) - position;
    const double off = wrap_angle(std::atan2(way.y(), way.x()) - robot.world_from_base.theta);
    is_turning_ = std::abs(off) > (is_turning_ ? kDriveOnAngle : kTurnOnSpotAngle);
    if (is_turning_) {
      const double rate =
          std::min(options_.turn_rate, std::sqrt(options_.turn_acceleration * std::abs(off)));
      return {0.0, robot.speed > 0.0 ? 0.0 : std::copysign(rate, off), false};
    }
    const double curvature = 2.0 * std::sin(off) / way.norm();
    return {std::min(speed_at(curvature), speed_before_corners()),
            std::clamp(curvature * robot.speed, -options_.turn_rate, options_.turn_rate), false};
  }

 private:
  /// The speed at which the turn rate suffices.
  [[nodiscard]] double speed_at(double curvature) const {
    return std::min(options_.speed, options_.turn_rate / std::max(1e-9, std::abs(curvature)));
  }

  /// The speed from which the robot can still slow down for every turn ahead and for the end.
  [[nodiscard]] double speed_before_corners() const {
    const double here = ahead_ - kLookahead;
    const double braking = 0.8 * options_.acceleration;
    double speed = std::sqrt(2.0 * braking * (line_.length() - here));
    for (std::size_t i = line_.next(ahead_); i + 1 < line_.size(); ++i) {
      // The turn begins when the point ahead passes the corner.
      const double remaining = line_.at(i) - ahead_;
      if (2.0 * braking * remaining > options_.speed * options_.speed) {
        break;
      }
      const double in_turn =
          speed_at(2.0 * std::sin(std::min(line_.turn(i), kTurnOnSpotAngle)) / kLookahead);
      speed = std::min(speed, std::sqrt(in_turn * in_turn + 2.0 * braking * remaining));
    }
    return std::max(speed, kMinSpeed);
  }

  RouteLine line_;
  DriveOptions options_;
  double ahead_ = 0.0;
  bool is_turning_ = false;
};

/// The way-points of all laps.
Route repeated(const Route& route, int laps) {
  if (laps > 1 && route.waypoints.front() != route.waypoints.back()) {
    throw ConfigurationError(
        "laps is " + std::to_string(laps) +
        ", but the way does not end where it begins; give 1, or a world such as rooms");
  }
  Route all = route;
  for (int lap = 1; lap < laps; ++lap) {
    all.waypoints.insert(all.waypoints.end(), route.waypoints.begin(), route.waypoints.end());
  }
  return all;
}

double approach(double value, double target, double change) {
  return value + std::clamp(target - value, -change, change);
}

}  // namespace

RobotMotion::RobotMotion(std::vector<Step> steps, double step_duration)
    : steps_(std::move(steps)), step_duration_(step_duration) {
  if (steps_.empty() || !(step_duration_ > 0.0)) {
    throw std::invalid_argument("a motion of " + std::to_string(steps_.size()) + " steps of " +
                                std::to_string(step_duration_) +
                                " s; it must have steps of positive duration");
  }
}

Pose2 RobotMotion::pose(double time) const {
  if (!(time > 0.0)) {
    return steps_.front().world_from_base;
  }
  const std::size_t i = static_cast<std::size_t>(
      std::min(std::floor(time / step_duration_), static_cast<double>(steps_.size() - 1)));
  const double in_step = time - static_cast<double>(i) * step_duration_;
  return advance(steps_[i], std::clamp(in_step, 0.0, step_duration_));
}

double RobotMotion::duration() const { return static_cast<double>(steps_.size()) * step_duration_; }

RobotMotion drive(const Route& route, const DriveOptions& options) {
  Driver driver(repeated(route, options.laps), options);
  const Eigen::Vector2d& start = route.waypoints.front();
  RobotMotion::Step robot;
  robot.world_from_base = {start.x(), start.y(), wrap_angle(route.start_heading)};
  std::vector<RobotMotion::Step> steps(
      static_cast<std::size_t>(std::ceil(options.rest / kStep)) + 1, robot);
  while (true) {
    const Command command = driver.decide(robot);
    robot.speed = approach(robot.speed, command.speed, options.acceleration * kStep);
    robot.turn_rate =
        approach(robot.turn_rate, command.turn_rate, options.turn_acceleration * kStep);
    steps.push_back(robot);
    if (command.has_arrived && robot.speed == 0.0 && robot.turn_rate == 0.0) {
      break;
    }
    robot.world_from_base = advance(robot, kStep);
  }
  return {std::move(steps), kStep};
}

}  // namespace matchbox_slam
