#pragma once

#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <utility>

#include "run/run_dialog.hpp"

namespace matchbox_slam {

/// Keeps what is said while a mutex is held, and tells it when it no longer is: a log may take
/// long, as where nobody reads the pipe that it goes into, and all else would wait for the mutex.
/// For any number of threads; lines are told in the order in which they were said.
class LateLog {
 public:
  /// @param told_to  gets the lines, never from two threads at once.
  explicit LateLog(RunDialog told_to) : told_to_(std::move(told_to)) {}
  /// Tells the rest.
  ~LateLog() { tell(); }
  LateLog(const LateLog&) = delete;
  LateLog& operator=(const LateLog&) = delete;

  /// To say things to, while this object is there.
  [[nodiscard]] RunDialog dialog();

  /// Tells what was said so far. To be called without the mutex.
  void tell();

 private:
  using Line = std::pair<const std::function<void(const std::string&)>*, std::string>;

  const RunDialog told_to_;
  std::mutex telling_;
  std::mutex mutex_;  ///< guards the next
  std::deque<Line> lines_;
};

/// Holds a mutex, and tells the log when it lets go of it.
class LoggingLock {
 public:
  LoggingLock(std::mutex& mutex, LateLog& log) : log_(log), lock_(mutex) {}
  ~LoggingLock() {
    if (lock_.owns_lock()) {
      unlock();
    }
  }
  LoggingLock(const LoggingLock&) = delete;
  LoggingLock& operator=(const LoggingLock&) = delete;

  void lock() { lock_.lock(); }
  void unlock() {
    lock_.unlock();
    log_.tell();
  }

 private:
  LateLog& log_;
  std::unique_lock<std::mutex> lock_;
};

}  // namespace matchbox_slam
