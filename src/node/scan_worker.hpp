#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <future>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "node/skip_warnings.hpp"
#include "ros/scan_queue.hpp"

namespace matchbox_slam {

/// Messages that a subscriber's own buffer holds; generous, since one lost there is lost uncounted.
constexpr std::uint32_t kScanMessages = 1000;
constexpr std::uint32_t kTransformMessages = 10000;

/// What a queue tells about itself.
struct QueueHealth {
  ScanAccount account;
  std::size_t waiting = 0;  ///< scans
  bool stopped = false;     ///< at a jump of time
  std::string last_skip;    ///< why a scan was skipped last, for people
};

/// A queue of scans and a thread that handles what comes out of it, one item at a time. All else
/// may be called from any thread.
class ScanWorker {
 public:
  using Handle = std::function<void(const ScanQueue::Item&)>;

  /// @param work    for the log, such as "mapping".
  /// @param handle  called from the thread. What it throws for a scan is told in the log, and the
  ///                next one may be better.
  ScanWorker(std::string work, ScanQueueSettings settings, Handle handle);
  ~ScanWorker() { stop(); }

  ScanWorker(const ScanWorker&) = delete;
  ScanWorker& operator=(const ScanWorker&) = delete;

  void start();

  /// Ends after the item at hand, and tells in the log what became of the scans: all that wait are
  /// skipped. Whoever waits for an event gets Interrupted.
  void stop();

  /// Whether nothing more is handled, so that long work in other threads is better given up: the
  /// worker is stopped, or this process's ROS is.
  [[nodiscard]] bool is_ending() const;

  /// Calls `use` with the queue, and nobody else meanwhile. The thread is woken only for what it
  /// can handle: of a hundred transforms a second most complete no scan.
  template <typename Use>
  void use_queue(const Use& use) {
    bool is_any_ready = false;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      use(queue_);
      skip_warnings_.tell(queue_);
      is_any_ready = queue_.peek() != nullptr;
    }
    if (is_any_ready) {
      changed_.notify_one();
    }
  }

  /// Puts the event in the queue.
  void post(RunEvent event) { (void)add(std::move(event)); }

  /// The same, and waits until it is handled. Throws what the handling throws, and Interrupted when
  /// it ends before.
  void carry_out(RunEvent event);

  [[nodiscard]] QueueHealth health();

 private:
  struct Task {
    ScanQueue::Item item;
    std::promise<void> done;
  };

  std::future<void> add(RunEvent event);
  [[nodiscard]] std::optional<Task> wait_for_task();
  void run();

  const std::string work_;
  const Handle handle_;
  std::atomic<bool> stop_{false};
  std::mutex mutex_;  ///< guards what follows
  std::condition_variable changed_;
  ScanQueue queue_;
  std::deque<std::promise<void>> promises_;  ///< one an event in the queue
  SkipWarnings skip_warnings_;
  std::thread thread_;  ///< last: it uses all of the above
};

}  // namespace matchbox_slam
