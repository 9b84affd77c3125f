#include "bag/carmen_stamps.hpp"

#include <fmt/core.h>

#include <algorithm>

namespace matchbox_slam {
namespace {

constexpr double kStampOrigin = 1e9;      // [s] of stamps that are not the messages' own
constexpr double kMinOrderedShare = 0.9;  // share of scans that come after the one before

using Stamp = std::optional<double> CarmenMoment::*;

/// Whether every moment has such a stamp, and nearly all scans a later one than the scan before.
bool is_usable(const std::vector<CarmenMoment>& moments, Stamp stamp) {
  std::optional<double> last;
  std::size_t steps = 0;
  std::size_t in_order = 0;
  for (const CarmenMoment& moment : moments) {
    if (!(moment.*stamp)) {
      return false;
    }
    if (moment.is_beat) {
      steps += last ? 1 : 0;
      in_order += last && *(moment.*stamp) > *last ? 1 : 0;
      last = moment.*stamp;
    }
  }
  return static_cast<double>(in_order) >= kMinOrderedShare * static_cast<double>(steps);
}

/// The first scan whose stamp says nothing, for people.
std::string example_of(const std::vector<CarmenMoment>& moments) {
  std::optional<double> last;
  for (const CarmenMoment& moment : moments) {
    if (moment.is_beat) {
      if (!moment.ipc_stamp) {
        return fmt::format("line {} has none", moment.line);
      }
      if (last && *moment.ipc_stamp <= *last) {
        return fmt::format("line {} has {:.16g} after {:.16g}", moment.line, *moment.ipc_stamp,
                           *last);
      }
      last = moment.ipc_stamp;
    }
  }
  return "a line without a laser's readings has none";
}

std::vector<double> logger_stamps(const std::vector<CarmenMoment>& moments) {
  std::vector<double> stamps;
  stamps.reserve(moments.size());
  for (const CarmenMoment& moment : moments) {
    stamps.push_back(kStampOrigin + *moment.logger_stamp);
  }
  return stamps;
}

std::vector<double> made_up_stamps(const std::vector<CarmenMoment>& moments) {
  std::vector<double> stamps;
  stamps.reserve(moments.size());
  double beat = kStampOrigin - 1.0;  // of the scan before
  for (auto at = moments.begin(); at != moments.end(); beat += 1.0) {
    const auto next =
        std::find_if(at, moments.end(), [](const CarmenMoment& moment) { return moment.is_beat; });
    const double step = 1.0 / static_cast<double>(next - at + 1);
    for (int k = 1; at != next; ++at, ++k) {
      stamps.push_back(beat + k * step);
    }
    if (at != moments.end()) {
      stamps.push_back(beat + 1.0);
      ++at;
    }
  }
  return stamps;
}

}  // namespace

CarmenStamps choose_stamps(const std::vector<CarmenMoment>& moments) {
  CarmenStamps chosen;
  if (is_usable(moments, &CarmenMoment::ipc_stamp)) {
    chosen.stamps.reserve(moments.size());
    for (const CarmenMoment& moment : moments) {
      chosen.stamps.push_back(*moment.ipc_stamp);
    }
    return chosen;
  }
  const std::string reason = fmt::format(
      "the stamps of scans are missing, cut off or not in order ({}); ", example_of(moments));
  if (is_usable(moments, &CarmenMoment::logger_stamp)) {
    return {logger_stamps(moments), reason + "those of the logger are used, from 1000000000 on"};
  }
  return {made_up_stamps(moments),
          reason + "made-up ones are used, a second a scan, from 1000000000 on"};
}

std::vector<std::size_t> find_clock_steps(const std::vector<CarmenMoment>& moments,
                                          const std::vector<double>& stamps) {
  constexpr std::ptrdiff_t kScans = 3;
  constexpr double kStep = 1.0;  // [s]; ScanQueue takes as much for a time jump
  std::vector<std::size_t> beats;
  for (std::size_t k = 0; k < moments.size(); ++k) {
    if (moments[k].is_beat) {
      beats.push_back(k);
    }
  }
  const auto is_earlier = [&](std::size_t a, std::size_t b) { return stamps[a] < stamps[b]; };
  std::vector<std::size_t> steps;
  std::ptrdiff_t left = kScans;  // until as many have come since the last step
  for (auto at = beats.begin(); beats.end() - at >= kScans; ++at, --left) {
    if (left <= 0 && stamps[*std::max_element(at, at + kScans, is_earlier)] <
                         stamps[*std::min_element(at - kScans, at, is_earlier)] - kStep) {
      const std::size_t before = *(at - 1);
      std::size_t step = before + 1;
      while (step < *at && stamps[step] >= stamps[before] - kStep) {
        ++step;  // other than scans, and of before
      }
      steps.push_back(step);
      left = kScans;
    }
  }
  return steps;
}

}  // namespace matchbox_slam
