#pragma once

#include <string>

namespace matchbox_slam {

/// What the inside of a file may be. Those that are not read have what they are and what to do, for
/// people.
struct RecordingKind {
  enum class Format { kRos1Bag, kSqlite, kMcap, kCarmenLog, kOther };
  Format format = Format::kOther;
  std::string what_to_do;  ///< of kOther: which other format it is, and what converts it; empty:
                           ///< none that is known
};

/// Looks at the first bytes of a file that is there; what gzip packed is unpacked for that.
[[nodiscard]] RecordingKind recording_kind(const std::string& path);

}  // namespace matchbox_slam
