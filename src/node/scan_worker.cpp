#include "node/scan_worker.hpp"

#include <ros/console.h>
#include <ros/init.h>

#include <chrono>
#include <exception>
#include <utility>
#include <variant>

#include "common/interrupted.hpp"

namespace matchbox_slam {
namespace {

constexpr const char* kEnding = "the node is ending";

}  // namespace

ScanWorker::ScanWorker(std::string work, ScanQueueSettings settings, Handle handle)
    : work_(std::move(work)), handle_(std::move(handle)), queue_(std::move(settings)) {}

void ScanWorker::start() {
  thread_ = std::thread([this] { run(); });
}

void ScanWorker::stop() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (stop_.exchange(true)) {
      return;
    }
    queue_.interrupt();
    skip_warnings_.tell(queue_);
    promises_.clear();  // which breaks them
  }
  changed_.notify_all();
  if (thread_.joinable()) {
    thread_.join();
    ROS_INFO_STREAM(work_ << " has ended: " << to_string(queue_.account()));
  }
}

bool ScanWorker::is_ending() const { return stop_ || ros::isShuttingDown(); }

std::future<void> ScanWorker::add(RunEvent event) {
  std::future<void> done;
  use_queue([&](ScanQueue& queue) {
    if (stop_) {
      throw Interrupted(kEnding);
    }
    queue.add_event(std::move(event));
    done = promises_.emplace_back().get_future();
  });
  return done;
}

void ScanWorker::carry_out(RunEvent event) {
  std::future<void> done = add(std::move(event));
  // roscpp shuts down only once this service has been answered.
  while (done.wait_for(std::chrono::milliseconds(50)) != std::future_status::ready) {
    if (is_ending()) {
      throw Interrupted(kEnding);
    }
  }
  try {
    done.get();
  } catch (const std::future_error&) {
    throw Interrupted(kEnding);
  }
}

QueueHealth ScanWorker::health() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return {queue_.account(), queue_.waiting(), queue_.stopped(), skip_warnings_.latest()};
}

std::optional<ScanWorker::Task> ScanWorker::wait_for_task() {
  std::unique_lock<std::mutex> lock(mutex_);
  std::optional<ScanQueue::Item> item;
  changed_.wait(lock, [&] {
    item = queue_.next();
    return item || stop_;
  });
  if (!item) {
    return std::nullopt;
  }
  Task task{std::move(*item), {}};
  if (std::holds_alternative<RunEvent>(task.item)) {
    task.done = std::move(promises_.front());
    promises_.pop_front();
  }
  return task;
}

void ScanWorker::run() {
  while (std::optional<Task> task = wait_for_task()) {
    try {
      handle_(task->item);
      task->done.set_value();
    } catch (const std::exception& error) {
      if (!std::holds_alternative<RunEvent>(task->item)) {
        ROS_ERROR_STREAM_THROTTLE(10.0, work_ << ": " << error.what());
      }
      task->done.set_exception(std::current_exception());
    }
  }
}

}  // namespace matchbox_slam
