#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

namespace matchbox_slam {

/// Saves again and again in a thread of its own, so that nothing else waits for it.
class Autosave {
 public:
  /// @param period  [s] from the end of one to the begin of the next, by the wall clock.
  /// @param save    called from the thread. What it throws is told in the log, and tried again.
  Autosave(double period, std::function<void()> save);

  /// Ends after the one at hand.
  ~Autosave();

  /// Somebody else has saved: the period begins now.
  void postpone();

  /// Why it failed last; empty: it did not, or somebody else has saved since.
  [[nodiscard]] std::string failure();

  /// When it saves next.
  [[nodiscard]] std::chrono::steady_clock::time_point due();

  Autosave(const Autosave&) = delete;
  Autosave& operator=(const Autosave&) = delete;

 private:
  void run();

  [[nodiscard]] std::chrono::steady_clock::time_point in_a_period() const;

  const double period_;
  const std::function<void()> save_;
  std::mutex mutex_;
  std::condition_variable ended_;
  bool is_ending_ = false;
  std::string failure_;
  std::chrono::steady_clock::time_point due_;
  std::thread thread_;
};

}  // namespace matchbox_slam
