#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

namespace matchbox_slam {

/// The path of a recording among the real data, which lie beside the project and not in it; whether
/// it exists is for the test to ask.
[[nodiscard]] inline std::string real_data(const std::string& name) {
  const char* folder = std::getenv("MATCHBOX_DATA");
  return (folder != nullptr ? std::string(folder)
                            : std::string(MATCHBOX_SOURCE_DIR) + "/../shared/data") +
         "/" + name;
}

}  // namespace matchbox_slam

/// Skips the test, loudly, where there is no such file.
#define MATCHBOX_SKIP_WITHOUT(path)                                     \
  if (!std::filesystem::exists(path)) {                                 \
    GTEST_SKIP() << "SKIPPED: there is no " << (path)                   \
                 << "; set MATCHBOX_DATA to the folder with real data"; \
  }                                                                     \
  static_assert(true, "")
