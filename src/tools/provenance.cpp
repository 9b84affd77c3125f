#include "tools/provenance.hpp"

#include <time.h>  // NOLINT(modernize-deprecated-headers): gmtime_r is POSIX's
#include <unistd.h>

#include <array>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "common/version.hpp"
#include MATCHBOX_COMMIT_HEADER

namespace matchbox_slam {
namespace {

std::string host_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "unknown";
}

/// The model, where Linux tells one; it does not on every kind of processor.
std::string processor() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const std::size_t colon = line.find(": ");
    if (line.rfind("model name", 0) == 0 && colon != std::string::npos) {
      return line.substr(colon + 2);
    }
  }
  return "unknown";
}

/// Of today, in universal time, such as 2024-02-29.
std::string date() {
  const time_t now = time(nullptr);
  tm parts{};
  gmtime_r(&now, &parts);
  std::array<char, 16> text{};
  strftime(text.data(), text.size(), "%Y-%m-%d", &parts);
  return text.data();
}

}  // namespace

void add_provenance(nlohmann::json& report) {
  report["version"] = package_version();
  report["commit"] = MATCHBOX_SLAM_COMMIT;
  report["date"] = date();
  report["machine"] = {
      {"host", host_name()}, {"cpu", processor()}, {"cores", std::thread::hardware_concurrency()}};
}

}  // namespace matchbox_slam
