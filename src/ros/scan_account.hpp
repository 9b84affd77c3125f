#pragma once

#include <ros/time.h>

#include <cstddef>
#include <map>
#include <string>

namespace matchbox_slam {

/// Why a scan was not used.
enum class SkipReason {
  kNoTransform,     ///< tf did not cover it in time
  kDuplicateStamp,  ///< a scan of the same stamp was there before
  kOutOfOrder,      ///< a later scan was delivered already
  kInvalid,         ///< its geometry makes no sense
  kEmpty,           ///< it has no ranges
  kQueueFull,       ///< too many were waiting; the oldest goes
  kTooLate,         ///< it had waited too long when its turn came
  kTimeJump,        ///< it was waiting when time jumped back
  kStopped,         ///< it came after a time jump at which to stop
  kPaused,          ///< its turn came while its user had paused the mapping
  kBeforeReset,     ///< it was used, or waiting, for a map that was given up since
  kInterrupted,     ///< it was waiting when its user ended the run
  kTilted,          ///< its plane is too far from level
};

/// A word for reports, such as "no_transform".
[[nodiscard]] const char* to_string(SkipReason reason);

struct SkippedScan {
  ros::Time stamp;
  SkipReason reason = SkipReason::kInvalid;
  std::string text;  ///< for people, one line
};

/// received = delivered + waiting + the sum of skipped; parts that are joined count as one scan.
struct ScanAccount {
  std::size_t received = 0;
  std::size_t delivered = 0;
  std::map<SkipReason, std::size_t> skipped;

  [[nodiscard]] std::size_t skipped_total() const;
};

/// For people: "3000 scans received, 120 used, 2880 skipped (interrupted: 2880)".
[[nodiscard]] std::string to_string(const ScanAccount& account);

}  // namespace matchbox_slam
