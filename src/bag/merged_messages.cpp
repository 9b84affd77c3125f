#include "bag/merged_messages.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>
#include <utility>

namespace matchbox_slam {

MergedMessages::MergedMessages(std::vector<FileSelection> files)
    : files_(std::move(files)), order_(files_.size()) {
  std::iota(order_.begin(), order_.end(), std::size_t{0});
  std::stable_sort(order_.begin(), order_.end(), [this](std::size_t a, std::size_t b) {
    return files_[a].file->begin_time() < files_[b].file->begin_time();
  });
}

std::optional<RecordedMessage> MergedMessages::next() {
  look_at_taken();
  open_those_due();
  const auto first = first_open();
  if (first == open_.end()) {
    return std::nullopt;
  }
  taken_ = first->place;
  return first->messages->next();
}

/// Only now, as what comes after the last message may be damaged.
void MergedMessages::look_at_taken() {
  const auto taken = std::find_if(open_.begin(), open_.end(),
                                  [this](const Open& one) { return taken_ == one.place; });
  taken_.reset();
  if (taken == open_.end()) {
    return;
  }
  if (const std::optional<ros::Time> time = taken->messages->peek()) {
    taken->time = *time;
  } else {
    open_.erase(taken);
  }
}

/// Those that may have a message before all of what is open.
void MergedMessages::open_those_due() {
  for (auto first = first_open();
       next_ < order_.size() &&
       (first == open_.end() || files_[order_[next_]].file->begin_time() <= first->time);
       first = first_open()) {
    open(order_[next_++]);
  }
}

void MergedMessages::open(std::size_t place) {
  const FileSelection& asked = files_[place];
  std::unique_ptr<RecordedMessages> messages = asked.file->messages(asked.selection);
  if (const std::optional<ros::Time> time = messages->peek()) {
    open_.push_back({place, std::move(messages), *time});
  }
}

std::vector<MergedMessages::Open>::iterator MergedMessages::first_open() {
  return std::min_element(open_.begin(), open_.end(), [](const Open& a, const Open& b) {
    return std::tie(a.time, a.place) < std::tie(b.time, b.place);
  });
}

}  // namespace matchbox_slam
