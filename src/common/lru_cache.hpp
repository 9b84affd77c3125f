#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <utility>

namespace matchbox_slam {

/// Keeps values that can always be made again, those that were used last, up to so many bytes. A
/// single value may be larger. For any number of threads.
template <typename Value>
class LruCache {
 public:
  using BytesOf = std::size_t (*)(const Value&);

  LruCache(std::size_t most_bytes, BytesOf bytes_of)
      : most_bytes_(most_bytes), bytes_of_(bytes_of) {}

  /// The value of a key: the one that is kept, else what `make` returns, which is always the same.
  template <typename Make>
  [[nodiscard]] std::shared_ptr<const Value> get(std::uint64_t key, const Make& make) {
    if (std::shared_ptr<const Value> kept = find(key)) {
      return kept;
    }
    // Without the lock, so that nobody waits; two threads may make it at once.
    return keep(key, std::make_shared<const Value>(make()));
  }

  /// Of all values that are kept.
  [[nodiscard]] std::size_t bytes() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return bytes_;
  }

 private:
  struct Entry {
    std::uint64_t key;
    std::shared_ptr<const Value> value;
    std::size_t bytes;
  };

  std::shared_ptr<const Value> find(std::uint64_t key) {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto found = by_key_.find(key);
    if (found == by_key_.end()) {
      return nullptr;
    }
    entries_.splice(entries_.begin(), entries_, found->second);
    return found->second->value;
  }

  std::shared_ptr<const Value> keep(std::uint64_t key, std::shared_ptr<const Value> value) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (const auto found = by_key_.find(key); found != by_key_.end()) {
      return found->second->value;
    }
    const std::size_t bytes = bytes_of_(*value);
    entries_.push_front({key, std::move(value), bytes});
    by_key_[key] = entries_.begin();
    bytes_ += bytes;
    while (bytes_ > most_bytes_ && entries_.size() > 1) {
      bytes_ -= entries_.back().bytes;
      by_key_.erase(entries_.back().key);
      entries_.pop_back();
    }
    return entries_.front().value;
  }

  const std::size_t most_bytes_;
  const BytesOf bytes_of_;
  mutable std::mutex mutex_;
  std::list<Entry> entries_;  ///< used last first
  std::unordered_map<std::uint64_t, typename std::list<Entry>::iterator> by_key_;
  std::size_t bytes_ = 0;
};

}  // namespace matchbox_slam
