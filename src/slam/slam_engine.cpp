#include "matchbox_slam/slam/slam_engine.hpp"

#include <utility>

#include "slam/engine_parts.hpp"

namespace matchbox_slam {

SlamEngine::SlamEngine(const EngineOptions& options, std::shared_ptr<const ScanMatcher> matcher,
                       std::uint64_t seed, const Pose2& start)
    : parts_(std::make_unique<Parts>(options, std::move(matcher), seed, start)) {}

SlamEngine::SlamEngine(SlamEngine&& other) noexcept = default;
SlamEngine& SlamEngine::operator=(SlamEngine&& other) noexcept = default;
SlamEngine::~SlamEngine() = default;

ScanOutcome SlamEngine::process(const ScanInput& input) { return parts_->process(input); }

const SlamMap& SlamEngine::map() { return parts_->mapping_.whole(); }

const SlamMap& SlamEngine::drawn_map() { return parts_->mapping_.drawn(); }

bool SlamEngine::is_outdated() const { return parts_->mapping_.renderer().is_outdated(); }

void SlamEngine::take_rendered(SlamMap map, const PlacedScans& keys) {
  parts_->mapping_.take_rendered(std::move(map), keys);
}

std::size_t SlamEngine::map_bytes() const {
  const SlamMap& map = parts_->mapping_.components().map().map;
  return map.occupancy.bytes() + map.field.bytes();
}

const KeyScans& SlamEngine::key_scans() const {
  return parts_->mapping_.components().map().key_scans;
}

PoseGraph SlamEngine::graph() const { return graph_of(key_scans(), loop_state()); }

const LoopState& SlamEngine::loop_state() const { return parts_->mapping_.loops().state(); }

std::size_t SlamEngine::disconnected_components() const {
  return parts_->mapping_.components().all().size() - 1;
}

TrackingState SlamEngine::state() const { return parts_->state(); }

const MotionState& SlamEngine::motion() const { return parts_->tracker_.state(); }

std::vector<WeightedPose> SlamEngine::likely_poses() const { return parts_->likely_poses(); }

const SecondaryLasers& SlamEngine::secondary_lasers() const { return parts_->secondary_lasers_; }

const EngineOptions& SlamEngine::options() const { return parts_->options(); }

void SlamEngine::set_matcher(std::shared_ptr<const ScanMatcher> matcher) {
  parts_->matcher_ = std::move(matcher);
}

void SlamEngine::set_options(const EngineOptions& options) { parts_->set_options(options); }

void SlamEngine::set_pose(const Pose2& map_from_base, const Eigen::Matrix3d& covariance) {
  parts_->set_pose(map_from_base, covariance);
}

bool SlamEngine::begin_component(double stamp) { return parts_->begin_component(stamp); }

void SlamEngine::start_from(EngineState start) { parts_->start_from(std::move(start)); }

void SlamEngine::expect_map(std::shared_ptr<const FoundMap> found) {
  parts_->mapping_.expect_map(std::move(found));
}

std::optional<MapCorrection> SlamEngine::finish_loops() { return parts_->finish_loops(); }

EngineState SlamEngine::snapshot() { return parts_->snapshot(); }

}  // namespace matchbox_slam
