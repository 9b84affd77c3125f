#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "node/late_log.hpp"

namespace matchbox_slam {
namespace {

TEST(LateLog, TellsInOrderWhenTheMutexIsFree) {
  std::mutex mutex;
  std::vector<std::string> told;
  const auto tell_as = [&](const std::string& level) {
    return [&, level](const std::string& text) {
      const bool is_free = mutex.try_lock();
      if (is_free) {
        mutex.unlock();
      }
      told.push_back(level + text + (is_free ? "" : " under the mutex"));
    };
  };
  LateLog log({tell_as("info: "), tell_as("warning: "), [](double, const std::string&) {},
               [] { return false; }});
  const RunDialog dialog = log.dialog();
  {
    LoggingLock lock(mutex, log);
    dialog.warn("a");
    dialog.inform("b");
    EXPECT_EQ(told, (std::vector<std::string>{}));
    lock.unlock();
    EXPECT_EQ(told, (std::vector<std::string>{"warning: a", "info: b"}));
    lock.lock();
    dialog.inform("c");
  }
  EXPECT_EQ(told.back(), "info: c");
  EXPECT_EQ(told.size(), 3U);
}

TEST(LateLog, TellsTheRestAtItsEnd) {
  std::string told;
  {
    LateLog log({[&](const std::string& text) { told += text; }, {}, {}, {}});
    log.dialog().inform("why it could not start");
    EXPECT_EQ(told, "");
  }
  EXPECT_EQ(told, "why it could not start");
}

}  // namespace
}  // namespace matchbox_slam
