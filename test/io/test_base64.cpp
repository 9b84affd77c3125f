#include <gtest/gtest.h>

#include <string>

#include "io/base64.hpp"

namespace matchbox_slam {
namespace {

TEST(Base64, WritesWhatTheStandardSays) {  // RFC 4648, section 10
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foob"), "Zm9vYg==");
  EXPECT_EQ(base64("fooba"), "Zm9vYmE=");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
}

TEST(Base64, WritesAnyBytes) { EXPECT_EQ(base64(std::string("\xfb\xef\xff\x00", 4)), "++//AA=="); }

}  // namespace
}  // namespace matchbox_slam
