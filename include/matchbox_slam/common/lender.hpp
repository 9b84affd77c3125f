#pragma once

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace matchbox_slam {

/// Lends what a pure function works in, such as buffers: each call gets one for itself, from any
/// thread, and what is given back is lent again, so that memory is asked for once and not with each
/// call. What an object holds when it is lent must not matter. The lender outlives its loans.
template <typename T>
class Lender {
 public:
  class Loan {
   public:
    Loan(Lender& lender, std::unique_ptr<T> object)
        : lender_(&lender), object_(std::move(object)) {}
    Loan(Loan&&) noexcept = default;
    Loan& operator=(Loan&&) = delete;
    ~Loan() {
      if (object_ != nullptr) {
        lender_->take_back(std::move(object_));
      }
    }

    [[nodiscard]] T& operator*() const { return *object_; }
    [[nodiscard]] T* operator->() const { return object_.get(); }

   private:
    Lender* lender_;
    std::unique_ptr<T> object_;
  };

  /// One that nobody has, a new one where there is none.
  [[nodiscard]] Loan lend() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (!idle_.empty()) {
        std::unique_ptr<T> object = std::move(idle_.back());
        idle_.pop_back();
        return Loan(*this, std::move(object));
      }
    }
    return Loan(*this, std::make_unique<T>());
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
