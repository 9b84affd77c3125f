#pragma once

#include <nlohmann/json_fwd.hpp>

namespace matchbox_slam {

/// Adds what a result was made by, where and when: `version` and `commit` of this program (the
/// commit is that of the sources when they were compiled, or "unknown"), `date`, and `machine` with
/// `host`, `cpu` and `cores`.
void add_provenance(nlohmann::json& report);

}  // namespace matchbox_slam
