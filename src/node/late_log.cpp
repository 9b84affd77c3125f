#include "node/late_log.hpp"

namespace matchbox_slam {

RunDialog LateLog::dialog() {
  const auto keep = [this](const std::function<void(const std::string&)>& told_to) {
    return [this, &told_to](const std::string& text) {
      const std::lock_guard<std::mutex> lock(mutex_);
      lines_.emplace_back(&told_to, text);
    };
  };
  return {keep(told_to_.inform), keep(told_to_.warn), told_to_.show_progress,
          told_to_.is_interrupted};
}

void LateLog::tell() {
  const std::lock_guard<std::mutex> telling(telling_);
  std::unique_lock<std::mutex> lock(mutex_);
  while (!lines_.empty()) {
    const Line line = std::move(lines_.front());
    lines_.pop_front();
    lock.unlock();
    (*line.first)(line.second);
    lock.lock();
  }
}

}  // namespace matchbox_slam
