#include "tools/report_page.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "io/base64.hpp"
#include "tools/json_text.hpp"
#include "tools/report_template.hpp"

namespace matchbox_slam {
namespace {

using nlohmann::json;

constexpr const char* kNothing = "";

/// The state counts before the certainty: it says more of where the robot is.
const char* reason_of(const PagePoint& point) {
  if (point.state != TrackingState::kTracking) {
    return to_string(point.state);
  }
  return point.certainty == Certainty::kSure ? kNothing : to_string(point.certainty);
}

bool is_grave(const DoubtedStretch& stretch) {
  const std::string reason = stretch.reason;
  return reason == to_string(TrackingState::kLost) || reason == to_string(TrackingState::kDoubt);
}

/// To the millimetre or the millisecond: what a page shows.
double to_thousandth(double value) { return std::round(value * 1e3) / 1e3; }

json point_columns(const std::vector<PagePoint>& points, const std::vector<std::size_t>& drawn) {
  json time = json::array();
  json x = json::array();
  json y = json::array();
  json sigma = json::array();
  json reason = json::array();
  for (const std::size_t index : drawn) {
    const PagePoint& point = points[index];
    time.push_back(to_thousandth(point.time));
    x.push_back(point.place ? json(to_thousandth(point.place->x())) : json(nullptr));
    y.push_back(point.place ? json(to_thousandth(point.place->y())) : json(nullptr));
    sigma.push_back(std::round(point.sigma * 1e5) / 1e5);
    reason.push_back(reason_of(point));
  }
  return {{"time", time}, {"x", x}, {"y", y}, {"sigma", sigma}, {"reason", reason}};
}

json stretch_rows(const std::vector<PagePoint>& points,
                  const std::vector<DoubtedStretch>& stretches) {
  json rows = json::array();
  for (const DoubtedStretch& stretch : stretches) {
    const auto begin = points.begin() + static_cast<std::ptrdiff_t>(stretch.begin);
    const auto end = points.begin() + static_cast<std::ptrdiff_t>(stretch.end);
    rows.push_back({{"reason", stretch.reason},
                    {"from", to_thousandth(begin->time)},
                    {"to", to_thousandth((end - 1)->time)},
                    {"stamp", to_thousandth(begin->stamp)},
                    {"scans", stretch.end - stretch.begin},
                    {"unmatched", std::count_if(begin, end, [](const PagePoint& point) {
                       return point.certainty == Certainty::kUnmatched;
                     })}});
  }
  return rows;
}

/// So that no name in it ends the element that it is in.
std::string within_script(std::string text) {
  for (std::size_t at = 0; (at = text.find('<', at)) != std::string::npos;) {
    text.replace(at, 1, "\\u003c");
  }
  return text;
}

}  // namespace

std::vector<DoubtedStretch> doubted_stretches(const std::vector<PagePoint>& points) {
  std::vector<DoubtedStretch> stretches;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::string reason = reason_of(points[i]);
    if (reason == kNothing) {
      continue;
    }
    if (!stretches.empty() && stretches.back().end == i && stretches.back().reason == reason) {
      ++stretches.back().end;
    } else {
      stretches.push_back({i, i + 1, reason_of(points[i])});
    }
  }
  return stretches;
}

std::vector<DoubtedStretch> gravest(std::vector<DoubtedStretch> stretches, std::size_t most) {
  if (stretches.size() <= most) {
    return stretches;
  }
  const auto rank = [](const DoubtedStretch& one) {
    return std::make_pair(is_grave(one), one.end - one.begin);
  };
  std::stable_sort(stretches.begin(), stretches.end(),
                   [&](const auto& a, const auto& b) { return rank(a) > rank(b); });
  stretches.resize(most);
  std::sort(stretches.begin(), stretches.end(),
            [](const auto& a, const auto& b) { return a.begin < b.begin; });
  return stretches;
}

std::vector<std::size_t> thinned(const std::vector<PagePoint>& points,
                                 const std::vector<DoubtedStretch>& stretches, std::size_t most) {
  std::vector<bool> is_drawn(points.size(), points.size() <= most);
  if (points.size() > most) {
    is_drawn.front() = is_drawn.back() = true;
    for (const DoubtedStretch& stretch : stretches) {
      is_drawn[stretch.begin] = is_drawn[stretch.end - 1] = true;
    }
    const std::size_t parts = most - 2 - 2 * stretches.size();
    for (std::size_t part = 0; part < parts; ++part) {
      const std::size_t begin = part * points.size() / parts;
      const std::size_t end = (part + 1) * points.size() / parts;
      std::size_t widest = begin;
      for (std::size_t i = begin; i < end; ++i) {
        widest = points[i].sigma > points[widest].sigma ? i : widest;
      }
      is_drawn[widest] = true;
    }
  }
  std::vector<std::size_t> drawn;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (is_drawn[i]) {
      drawn.push_back(i);
    }
  }
  return drawn;
}

std::string report_page(const std::string& report, const std::vector<PagePoint>& points,
                        const PagePicture& picture) {
  const std::vector<DoubtedStretch> all = doubted_stretches(points);
  const std::vector<DoubtedStretch> shown = gravest(all, kMostPageStretches);
  const std::vector<std::size_t> drawn = thinned(points, shown, kMostPagePoints);
  const bool is_inside = picture.png.size() <= kLargestPagePicture;
  const json data = {{"report", json::parse(report)},
                     {"points", point_columns(points, drawn)},
                     {"scans", points.size()},
                     {"stretches", stretch_rows(points, shown)},
                     {"stretches_in_all", all.size()},
                     {"picture",
                      {{"inside", is_inside},
                       {"width", picture.width},
                       {"height", picture.height},
                       {"pixels_per_metre", picture.frame.pixels_per_metre},
                       {"left", picture.frame.origin.x()},
                       {"top", picture.frame.origin.y()}}}};
  std::string page = kReportPageBegin;
  page += is_inside ? "data:image/png;base64," + base64(picture.png) : "map.png";
  page += kReportPageMiddle;
  page += within_script(json_text(data, -1));
  page += kReportPageEnd;
  return page;
}

}  // namespace matchbox_slam
