#include "node/autosave.hpp"

#include <ros/console.h>

#include <chrono>
#include <exception>
#include <utility>

namespace matchbox_slam {

Autosave::Autosave(double period, std::function<void()> save)
    : period_(period), save_(std::move(save)), due_(in_a_period()), thread_([this] { run(); }) {}

Autosave::~Autosave() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_ending_ = true;
  }
  ended_.notify_all();
  thread_.join();
}

std::string Autosave::failure() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return failure_;
}

void Autosave::postpone() {
  const std::lock_guard<std::mutex> lock(mutex_);
  failure_.clear();
  due_ = in_a_period();
}

std::chrono::steady_clock::time_point Autosave::due() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return due_;
}

std::chrono::steady_clock::time_point Autosave::in_a_period() const {
  return std::chrono::steady_clock::now() +
         std::chrono::duration_cast<std::chrono::steady_clock::duration>(
             std::chrono::duration<double>(period_));
}

void Autosave::run() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (!ended_.wait_until(lock, due_, [this] { return is_ending_; })) {
    if (std::chrono::steady_clock::now() < due_) {
      continue;  // it was postponed
    }
    lock.unlock();
    std::string failure;
    try {
      save_();
    } catch (const std::exception& error) {
      failure = error.what();
      ROS_ERROR_STREAM("the map is not saved: " << error.what() << "; it is tried again in "
                                                << period_ << " s");
    }
    lock.lock();
    failure_ = std::move(failure);
    due_ = in_a_period();
  }
}

}  // namespace matchbox_slam
