#pragma once

#include <ctime>

namespace matchbox_slam {

/// Time that the calling thread has had on a processor [s]: unlike the clock's, it does not count
/// what other threads and programs were given.
[[nodiscard]] inline double thread_seconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace matchbox_slam
