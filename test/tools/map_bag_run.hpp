#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "common/error_text.hpp"
#include "io/temporary_folder.hpp"
#include "io/tum.hpp"
#include "matchbox_slam/io/file.hpp"
#include "ros/messages.hpp"
#include "ros/scan_types.hpp"
#include "tools/run_command.hpp"

namespace matchbox_slam {

class MapBag : public testing::Test {
 protected:
  MapBag() { ::setenv("LC_ALL", "C", 1); }

  /// Runs with the small bag and more arguments.
  Outcome run(const std::string& arguments) {
    return run_command(MATCHBOX_MAP_BAG, bag_ + " --out " + out_ + " " + arguments);
  }

  Outcome run_small(const SmallBag& recipe, const std::string& arguments = "") {
    write_small_bag(bag_, recipe);
    return run(arguments);
  }

  void expect_one_line(const Outcome& outcome, int exit_code, const std::string& words) {
    EXPECT_EQ(outcome.exit_code, exit_code) << outcome.output;
    EXPECT_TRUE(contains(outcome.output, words)) << outcome.output;
    EXPECT_EQ(std::count(outcome.output.begin(), outcome.output.end(), '\n'), 1) << outcome.output;
    EXPECT_FALSE(std::filesystem::exists(out_ + "/trajectory.tum"));
  }

  /// A number of the report; `name` is a JSON pointer.
  [[nodiscard]] double report(const std::string& name) const {
    const auto values = nlohmann::json::parse(read_file(out_ + "/report.json"));
    return values.at(nlohmann::json::json_pointer("/" + name)).get<double>();
  }

  [[nodiscard]] std::size_t poses() const { return read_tum(out_ + "/trajectory.tum").size(); }

  TemporaryFolder folder_;
  std::string bag_ = folder_ / "small.bag";
  std::string out_ = folder_ / "out";
};

}  // namespace matchbox_slam
