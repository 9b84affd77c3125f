#include "slam/map_parts.hpp"

#include <algorithm>
#include <utility>

namespace matchbox_slam {

MapParts::MapParts(std::vector<MapPart> parts, std::size_t here, std::vector<WaitingScan> waiting)
    : parts_(std::move(parts)), here_(here), waiting_(std::move(waiting)) {}

bool MapParts::begin_apart(MapPart empty) {
  constexpr std::size_t kWorthKeeping = 3;  // key scans; a guess: half and double were not tried
  if (is_lost() && here().key_scans.size() < kWorthKeeping) {
    empty.begin = here().begin;
    empty.left = here().left;
    empty.left_from_here = here().left_from_here;
    here() = std::move(empty);
    waiting_.erase(std::remove_if(waiting_.begin(), waiting_.end(),
                                  [this](const WaitingScan& scan) { return scan.part == here_; }),
                   waiting_.end());
  } else {
    empty.left = here_;
    parts_.push_back(std::move(empty));
    here_ = parts_.size() - 1;
  }
  const bool are_too_many = parts_.size() - 1 > kMostPartsApart;
  if (are_too_many) {
    give_up_smallest();
  }
  return are_too_many;
}

/// Of those apart that the robot is not in, with what waits for it.
void MapParts::give_up_smallest() {
  const auto smallest = std::min_element(
      parts_.begin() + 1, parts_.end() - 1,
      [](const auto& a, const auto& b) { return a.key_scans.size() < b.key_scans.size(); });
  const auto part = static_cast<std::size_t>(smallest - parts_.begin());
  waiting_.erase(std::remove_if(waiting_.begin(), waiting_.end(),
                                [part](const WaitingScan& scan) { return scan.part == part; }),
                 waiting_.end());
  const Pose2 left_from_part = smallest->left_from_here;
  remove(part, smallest->left, left_from_part);
  here_ = parts_.size() - 1;
}

void MapParts::join(std::size_t part, const Pose2& part_from_here, bool with_key_scans) {
  const std::size_t apart = here_;
  const double begin = here().begin;
  for (WaitingScan& waiting : waiting_) {
    if (waiting.part == apart) {
      waiting = {part, {waiting.scan.scan, part_from_here * waiting.scan.map_from_base}};
    }
  }
  if (with_key_scans) {
    for (const PlacedScan& key : here().key_scans.all()) {
      waiting_.push_back({part, {key.scan, part_from_here * key.map_from_base}});
    }
  }
  remove(apart, part, part_from_here);
  here_ = part > apart ? part - 1 : part;
  here().begin = std::min(here().begin, begin);
  here().last_inserted.clear();
  leave_if_found();
}

/// Takes a part out that nothing waits for. What followed it follows the one whose frame is given
/// from now on, and the numbers of the parts behind are lower by one.
void MapParts::remove(std::size_t part, std::size_t heir, const Pose2& heir_from_part) {
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    MapPart& other = parts_[i];
    if (other.left == part) {
      other.left = heir == part ? i : heir;
      other.left_from_here = heir_from_part * other.left_from_here;
    }
    other.left -= other.left > part ? 1 : 0;
  }
  for (WaitingScan& waiting : waiting_) {
    waiting.part -= waiting.part > part ? 1 : 0;
  }
  parts_.erase(parts_.begin() + static_cast<std::ptrdiff_t>(part));
}

/// Poses that were taken in parts that the robot is not in any more are not to be put right later:
/// others have come after them.
void MapParts::leave_if_found() {
  constexpr double kNever = 1e15;  // [s]
  if (!is_lost()) {
    std::for_each(parts_.begin() + 1, parts_.end(), [](MapPart& part) { part.begin = kNever; });
  }
}

void MapParts::go_to_map() {
  here_ = 0;
  leave_if_found();
  waiting_.clear();
}

const WaitingScan* MapParts::next_waiting() const {
  const auto next = std::find_if(waiting_.begin(), waiting_.end(),
                                 [this](const WaitingScan& scan) { return scan.part == here_; });
  return next == waiting_.end() ? nullptr : &*next;
}

void MapParts::drop_next_waiting() {
  if (const WaitingScan* next = next_waiting()) {
    waiting_.erase(waiting_.begin() + (next - waiting_.data()));
  }
}

void MapParts::move_waiting_for_map(const Pose2& new_from_old) {
  for (WaitingScan& waiting : waiting_) {
    if (waiting.part == 0) {
      waiting.scan.map_from_base = new_from_old * waiting.scan.map_from_base;
    }
  }
}

}  // namespace matchbox_slam
