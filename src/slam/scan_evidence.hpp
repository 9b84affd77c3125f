#pragma once

#include <cstddef>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/map/scan_inserter.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"
#include "matchbox_slam/slam/scan_outcome.hpp"

namespace matchbox_slam {

/// Of a scan that are asked, spread evenly; for the time that it takes.
constexpr std::size_t kEvidenceBeams = 180;

/// The log-likelihood ratio of a scan at a pose in a map that counts hits and passes. Each beam
/// passes cells, where walls would have stopped it, and ends in or near one that reflects or does
/// not; what is unknown says nothing, nor does the other side of a wall. (The beam model of
/// reflection maps; Hähnel, Burgard and Thrun 2003.) Each beam is limited, as it may have met what
/// was not there before.
///
/// Beams that see one surface side by side are one witness: a scan counts as so many as half metres
/// of wall that it sees, and as beams that are farther apart. Beams without return say nothing:
/// glass has them, too. Cost: of some 180 beams, spread evenly, a look-up about every 0.3 m.
/// @param map  with its field rendered.
[[nodiscard]] ScanEvidence evidence_of(const PointScan& scan, const Pose2& map_from_base,
                                       const SlamMap& map);

/// What one scan says at most for a pose and against another, in log odds: where map or model is
/// wrong it is wrong for all beams.
constexpr double kMostOfScan = 6.0;

/// Errors of map and model may favour one of two poses that are equally good by this share of the
/// evidence.
constexpr double kModelErrorShare = 0.1;

/// Share of a scan that has to tell of walls for it to count for a loop, or to make a place a
/// hypothesis.
constexpr double kMinTellingShare = 0.2;

/// Log odds of somewhere unknown against a pose, by one scan: by how far beams that tell of walls
/// fall short of agreeing, and in proportion to how much wall they tell of, up to two metres.
/// Chosen by how often scans at right poses, and of a robot that is carried, say so little.
[[nodiscard]] double odds_of_elsewhere(const ScanEvidence& evidence);

/// Free-space violation: share of a scan's beams that go through walls, above which a place is
/// looked at with suspicion: a guess.
constexpr double kMostViolation = 0.1;

/// Share of a scan that ends on known ground, from which on it is of what is known: more than not.
constexpr double kMinKnownShare = 0.5;

/// Whether so little of a scan fits what is known where it ends that it may be of elsewhere.
[[nodiscard]] bool is_badly_explained(const ScanEvidence& evidence);

}  // namespace matchbox_slam
