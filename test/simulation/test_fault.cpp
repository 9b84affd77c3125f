#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "common/error_text.hpp"
#include "matchbox_slam/common/options.hpp"
#include "simulation/fault.hpp"

namespace matchbox_slam {
namespace {

TEST(Fault, IsReadFromItsText) {
  const Fault fault = parse_fault("heading_slip:20:1.5:-0.25");
  EXPECT_EQ(fault.kind, FaultKind::kHeadingSlip);
  EXPECT_EQ(fault.time, 20.0);
  EXPECT_EQ(fault.duration, 1.5);
  EXPECT_EQ(fault.amount, -0.25);
}

TEST(Fault, WhatIsLeftOutHasTheKindsDefault) {
  const Fault fault = parse_fault("kidnap:random");
  EXPECT_TRUE(std::isnan(fault.time));
  EXPECT_EQ(fault.duration, 3.0);
  EXPECT_EQ(fault.amount, 3.0);
  EXPECT_EQ(parse_fault("jump:3::0.75").amount, 0.75);
}

TEST(Fault, ItsTextReadsBack) {
  for (const char* kind : {"freeze", "encoders", "heading_slip", "way_slip", "jump", "turn_jump",
                           "kidnap", "dropout", "covered", "people"}) {
    const Fault fault = parse_fault(std::string(kind) + ":12.5");
    EXPECT_EQ(to_string(parse_fault(to_string(fault))), to_string(fault));
    EXPECT_NE(fault_help().find(kind), std::string::npos);
  }
  EXPECT_EQ(to_string(parse_fault("freeze:random:2")), "freeze:random:2.0:0.0");
}

TEST(Fault, ABadTextIsRefusedWithWhatIsAllowed) {
  const auto text = [](const std::string& fault) {
    return error_text<ConfigurationError>([&] { (void)parse_fault(fault); });
  };
  EXPECT_TRUE(contains(text("slip:3"), "'slip' is not allowed")) << text("slip:3");
  EXPECT_TRUE(contains(text("slip:3"), "heading_slip"));
  EXPECT_TRUE(contains(text("freeze"), "KIND:TIME"));
  EXPECT_TRUE(contains(text("freeze:"), "KIND:TIME"));
  EXPECT_TRUE(contains(text("freeze:1:2:0:5"), "KIND:TIME"));
  EXPECT_TRUE(contains(text("freeze:soon"), "time 'soon'"));
  EXPECT_TRUE(contains(text("freeze:-1"), "time '-1'"));
  EXPECT_TRUE(contains(text("freeze:1:nan"), "duration 'nan'"));
  EXPECT_TRUE(contains(text("jump:1:2"), "the duration '2' is not allowed; leave it out"));
  EXPECT_TRUE(contains(text("people:1:2:1.5"), "amount '1.5'"));
}

TEST(Fault, RandomTimesAreDrawnBySeedWithinTheRun) {
  const std::vector<Fault> faults = {parse_fault("freeze:random:5"), parse_fault("jump:7"),
                                     parse_fault("dropout:random:5")};
  std::vector<double> times;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const std::vector<Fault> drawn = with_drawn_times(faults, 100.0, seed);
    EXPECT_EQ(drawn[1].time, 7.0);
    EXPECT_NE(drawn[0].time, drawn[2].time);
    EXPECT_EQ(drawn[0].time, with_drawn_times(faults, 100.0, seed)[0].time);
    EXPECT_GE(drawn[0].time, 10.0);
    EXPECT_LE(drawn[0].time + drawn[0].duration, 90.0);
    times.push_back(drawn[0].time);
  }
  EXPECT_LT(*std::min_element(times.begin(), times.end()), 14.0);
  EXPECT_GT(*std::max_element(times.begin(), times.end()), 81.0);
}

TEST(Fault, AShortRunHasRoomForARandomTimeToo) {
  const Fault drawn = with_drawn_times({parse_fault("freeze:random:5")}, 6.0, 1).front();
  EXPECT_GE(drawn.time, 0.0);
  EXPECT_LE(drawn.time + drawn.duration, 6.0);
}

TEST(Fault, OneAfterTheEndOfTheRunIsRefused) {
  EXPECT_EQ(error_text<ConfigurationError>([] {
              (void)with_drawn_times({parse_fault("freeze:5"), parse_fault("freeze:60")}, 60.0, 1);
            }),
            "fault 'freeze:60.0:1.0:0.0' comes too late: the run lasts 60.0 s; allowed: an earlier "
            "time, or a longer run");
}

}  // namespace
}  // namespace matchbox_slam
