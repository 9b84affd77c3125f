#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "io/map_picture.hpp"
#include "matchbox_slam/slam/scan_outcome.hpp"

namespace matchbox_slam {

/// What became of one scan.
struct PagePoint {
  double time = 0.0;                     ///< since the first scan [s]
  double stamp = 0.0;                    ///< by the robot's clock [s]
  std::optional<Eigen::Vector2d> place;  ///< of the base in the map [m]; none: in a map apart
  double sigma = 0.0;                    ///< standard deviation where it is known least [m]
  TrackingState state = TrackingState::kTracking;
  Certainty certainty = Certainty::kSure;
};

/// map.png, and where the map's frame is in it.
struct PagePicture {
  std::string png;
  int width = 0;   ///< [pixels]
  int height = 0;  ///< [pixels]
  PictureFrame frame;
};

/// Scans one after the other that were all doubted for the same reason.
struct DoubtedStretch {
  std::size_t begin = 0;    ///< index of the first one's point
  std::size_t end = 0;      ///< past the last one's
  const char* reason = "";  ///< a state, or else a certainty, as scans.csv has it
};

constexpr std::size_t kMostPagePoints = 4000;
constexpr std::size_t kMostPageStretches = 1500;
constexpr std::size_t kLargestPagePicture = 3U << 20U;  ///< bytes of a PNG that the page holds

/// All stretches, in order of time.
[[nodiscard]] std::vector<DoubtedStretch> doubted_stretches(const std::vector<PagePoint>& points);

/// The `most` stretches that matter most, in order of time: lost and doubt before the others, and
/// of equals those of most scans.
[[nodiscard]] std::vector<DoubtedStretch> gravest(std::vector<DoubtedStretch> stretches,
                                                  std::size_t most);

/// Indices, ascending, of at most `most` points to draw: the first and the last, those of each
/// stretch likewise, and of the rest, in equal parts, the least sure ones.
/// @param most  more than twice the stretches and two.
[[nodiscard]] std::vector<std::size_t> thinned(const std::vector<PagePoint>& points,
                                               const std::vector<DoubtedStretch>& stretches,
                                               std::size_t most);

/// One page of HTML that needs nothing but a browser, for people: the map with the path over it,
/// how sure the robot was over time, the doubted stretches, and what the report tells of the run.
/// Pictures over kLargestPagePicture are not in it: it shows map.png beside it then.
/// @param report  report.json's text.
[[nodiscard]] std::string report_page(const std::string& report,
                                      const std::vector<PagePoint>& points,
                                      const PagePicture& picture);

}  // namespace matchbox_slam
