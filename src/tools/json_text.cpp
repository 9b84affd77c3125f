#include "tools/json_text.hpp"

#include <nlohmann/json.hpp>
#include <variant>

namespace matchbox_slam {

std::string json_text(const nlohmann::json& json, int indent) {
  return json.dump(indent, ' ', false, nlohmann::json::error_handler_t::replace);
}

nlohmann::json to_json(const ErrorStatistics& statistics, double unit) {
  return nlohmann::json::object({{"rmse", statistics.rmse * unit},
                                 {"mean", statistics.mean * unit},
                                 {"median", statistics.median * unit},
                                 {"p95", statistics.p95 * unit},
                                 {"max", statistics.max * unit}});
}

nlohmann::json values_of(const std::vector<OptionDescription>& options) {
  nlohmann::json values = nlohmann::json::object();
  for (const OptionDescription& row : options) {
    std::visit([&](const auto& value) { values[row.name] = value; }, row.value);
  }
  return values;
}

}  // namespace matchbox_slam
