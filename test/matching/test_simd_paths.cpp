// Of matching/scan_matcher.hpp: every instruction set gives the same bits.

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "tools/run_command.hpp"

namespace matchbox_slam {
namespace {

std::string answers_of(const char* program) {
  const Outcome outcome = run_command(program, "");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_EQ(std::count(outcome.output.begin(), outcome.output.end(), '\n'), 60);
  EXPECT_EQ(outcome.output.find("nan"), std::string::npos);
  return outcome.output;
}

TEST(SimdPaths, WhatTheProcessorChoosesIsTheBaseline) {
  EXPECT_EQ(answers_of(MATCHBOX_DIGEST_CHOSEN), answers_of(MATCHBOX_DIGEST_BASELINE));
}

#ifdef MATCHBOX_DIGEST_AVX2
TEST(SimdPaths, Avx2IsTheBaseline) {
  if (__builtin_cpu_supports("avx2") == 0) {
    GTEST_SKIP() << "SKIPPED: this processor has no AVX2";
  }
  EXPECT_EQ(answers_of(MATCHBOX_DIGEST_AVX2), answers_of(MATCHBOX_DIGEST_BASELINE));
}

TEST(SimdPaths, Avx512IsTheBaseline) {
  if (__builtin_cpu_supports("avx512f") == 0) {
    GTEST_SKIP() << "SKIPPED: this processor has no AVX-512";
  }
  EXPECT_EQ(answers_of(MATCHBOX_DIGEST_AVX512), answers_of(MATCHBOX_DIGEST_BASELINE));
}
#endif

}  // namespace
}  // namespace matchbox_slam
