#include "node/autosave.hpp"

#include <ros/console.h>

#include <chrono>
#include <exception>
#include <utility>

namespace matchbox_slam {

Autosave::Autosave(double period, std::function<void()> save)
    : period_(period), save_(std::move(save)), thread_([this] { run(); }) {}

Autosave::~Autosave() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_ending_ = true;
  }
  ended_.notify_all();
  thread_.join();
}

void Autosave::run() {
  const std::chrono::duration<double> period(period_);
  std::unique_lock<std::mutex> lock(mutex_);
  while (!ended_.wait_for(lock, period, [this] { return is_ending_; })) {
    lock.unlock();
    try {
      save_();
    } catch (const std::exception& error) {
      ROS_ERROR_STREAM("the map is not saved: " << error.what() << "; it is tried again in "
                                                << period_ << " s");
    }
    lock.lock();
  }
}

}  // namespace matchbox_slam
