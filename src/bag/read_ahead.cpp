#include <algorithm>
#include <deque>
#include <exception>
#include <future>
#include <utility>

#include "bag/bag_reader.hpp"

namespace matchbox_slam {

namespace {

/// Hands out the messages of one batch while a thread reads the next.
class ReadAheadStream : public BagStream {
 public:
  ReadAheadStream(std::unique_ptr<BagStream> source, std::size_t capacity)
      : source_(std::move(source)),
        batch_size_(std::max<std::size_t>(1, capacity / 2)),
        ahead_(read_ahead()) {}

  std::optional<BagMessage> next() override {
    if (batch_.messages.empty() && batch_.failure == nullptr) {
      batch_ = ahead_.get();
      ahead_ = batch_.failure == nullptr ? read_ahead() : std::future<Batch>();
    }
    if (batch_.messages.empty()) {
      if (batch_.failure != nullptr) {
        std::rethrow_exception(batch_.failure);
      }
      return std::nullopt;
    }
    return take_first();
  }

 private:
  BagMessage take_first() {
    BagMessage message = std::move(batch_.messages.front());
    batch_.messages.pop_front();
    return message;
  }

  struct Batch {
    std::deque<BagMessage> messages;
    std::exception_ptr failure;  ///< of the message after them
  };

  [[nodiscard]] Batch read() const {
    Batch batch;
    try {
      while (batch.messages.size() < batch_size_) {
        std::optional<BagMessage> message = source_->next();
        if (!message) {
          break;
        }
        batch.messages.push_back(std::move(*message));
      }
    } catch (...) {
      batch.failure = std::current_exception();
    }
    return batch;
  }

  std::future<Batch> read_ahead() {
    return std::async(std::launch::async, [this] { return read(); });
  }

  const std::unique_ptr<BagStream> source_;
  const std::size_t batch_size_;
  Batch batch_;
  std::future<Batch> ahead_;  ///< last: its end waits for the thread, which uses all of the above
};

}  // namespace

std::unique_ptr<BagStream> read_ahead(std::unique_ptr<BagStream> stream, std::size_t capacity) {
  return std::make_unique<ReadAheadStream>(std::move(stream), capacity);
}

}  // namespace matchbox_slam
