#pragma once

#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "bag/bag_scans.hpp"

namespace matchbox_slam {

/// The scans of a recording as they are mapped.
/// @param told  gets the warnings.
inline std::vector<ScanInput> scans_of_bag(const BagRequest& request,
                                           std::vector<std::string>& told) {
  const RunDialog dialog{[](const std::string&) {},
                         [&told](const std::string& line) { told.push_back(line); },
                         [](double, const std::string&) {}, [] { return false; }};
  BagScans scans(request, dialog);
  const Parameters frames = frame_parameters(request);
  (void)scans.prepare(frames, read_options<RunOptions>(frames, ""));
  std::vector<ScanInput> inputs;
  while (std::optional<ScanQueue::Item> item = scans.next()) {
    if (auto* scan = std::get_if<ReadyScan>(&*item)) {
      inputs.push_back(std::move(scan->input));
    }
  }
  return inputs;
}

}  // namespace matchbox_slam
