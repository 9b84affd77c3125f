#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

#include "bag/bag_reader.hpp"

namespace matchbox_slam {

namespace {

/// Hands messages from the reading thread to the caller, in their order.
class ReadAheadStream : public BagStream {
 public:
  ReadAheadStream(std::unique_ptr<BagStream> source, std::size_t capacity)
      : source_(std::move(source)), capacity_(capacity), thread_([this] { read(); }) {}

  ~ReadAheadStream() override {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      stop_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }
  ReadAheadStream(const ReadAheadStream&) = delete;
  ReadAheadStream& operator=(const ReadAheadStream&) = delete;

  std::optional<BagMessage> next() override {
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait(lock, [this] { return !messages_.empty() || ended_; });
    if (messages_.empty()) {
      if (failure_ != nullptr) {
        std::rethrow_exception(failure_);
      }
      return std::nullopt;
    }
    BagMessage message = std::move(messages_.front());
    messages_.pop_front();
    lock.unlock();
    changed_.notify_all();
    return message;
  }

 private:
  void read() {
    try {
      while (std::optional<BagMessage> message = source_->next()) {
        std::unique_lock<std::mutex> lock(mutex_);
        changed_.wait(lock, [this] { return messages_.size() < capacity_ || stop_; });
        if (stop_) {
          break;
        }
        messages_.push_back(std::move(*message));
        lock.unlock();
        changed_.notify_all();
      }
    } catch (...) {
      failure_ = std::current_exception();
    }
    const std::lock_guard<std::mutex> lock(mutex_);
    ended_ = true;
    changed_.notify_all();
  }

  std::unique_ptr<BagStream> source_;
  std::size_t capacity_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<BagMessage> messages_;
  bool stop_ = false;
  bool ended_ = false;
  std::exception_ptr failure_;
  std::thread thread_;  ///< last: it uses all of the above
};

}  // namespace

std::unique_ptr<BagStream> read_ahead(std::unique_ptr<BagStream> stream, std::size_t capacity) {
  return std::make_unique<ReadAheadStream>(std::move(stream), capacity);
}

}  // namespace matchbox_slam
