#pragma once

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace matchbox_slam {

/// Lends what a pure function works in, such as buffers: each call gets one for itself, from any
/// thread, and what is given back is lent again, so that memory is asked for once and not with each
/// call. What an object holds when it is lent must not matter. The pool outlives its handles.
template <typename T>
class ObjectPool {
 public:
  class Handle {
   public:
    Handle(ObjectPool& pool, std::unique_ptr<T> object)
        : pool_(&pool), object_(std::move(object)) {}
    Handle(Handle&&) noexcept = default;
    Handle& operator=(Handle&&) = delete;
    ~Handle() {
      if (object_ != nullptr) {
        pool_->take_back(std::move(object_));
      }
    }

    [[nodiscard]] T& operator*() const { return *object_; }
    [[nodiscard]] T* operator->() const { return object_.get(); }

   private:
    ObjectPool* pool_;
    std::unique_ptr<T> object_;
  };

  /// One that nobody has, a new one where there is none.
  [[nodiscard]] Handle acquire() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (!idle_.empty()) {
        std::unique_ptr<T> object = std::move(idle_.back());
        idle_.pop_back();
        return Handle(*this, std::move(object));
      }
    }
    return Handle(*this, std::make_unique<T>());
  }

 private:
  void take_back(std::unique_ptr<T> object) {
    const std::lock_guard<std::mutex> lock(mutex_);
    idle_.push_back(std::move(object));
  }

  std::mutex mutex_;
  std::vector<std::unique_ptr<T>> idle_;
};

}  // namespace matchbox_slam
