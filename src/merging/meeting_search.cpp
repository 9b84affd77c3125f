#include "merging/meeting_search.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <future>
#include <thread>
#include <utility>

namespace matchbox_slam {
namespace {

/// Ends a pass whose answer nobody wants any more.
struct GivenUp {};

/// Searches one map in another one, along its way or back.
std::optional<MergedMap> joined_if_found(const MergedMap& map, const MergedMap& there, bool is_back,
                                         const EngineOptions& options,
                                         const std::function<void(double done)>& tell,
                                         const std::function<void()>& go_on) {
  PlacedScans way = map.component.key_scans.all();
  if (is_back) {
    std::reverse(way.begin(), way.end());
  }
  std::optional<MergedMap> both;
  const auto is_believed = [&](MapMeeting meeting) {
    meeting.key = is_back ? way.size() - 1 - meeting.key : meeting.key;
    both = joined(map, there, meeting, options, go_on);
    return both.has_value();
  };
  return find_meeting(way, there.component, options, is_believed, tell) ? std::move(both)
                                                                        : std::nullopt;
}

/// What threads work on together.
class Passes {
 public:
  Passes(const std::vector<MergedMap>& maps, const std::vector<MeetingPass>& passes,
         const EngineOptions& options)
      : maps_(maps),
        passes_(passes),
        options_(options),
        first_found_(passes.size()),
        done_(passes.size()),
        found_(passes.size()) {}

  /// Makes one after the other of those that nobody has begun.
  void work() {
    for (std::size_t i = next_++; i < passes_.size(); i = next_++) {
      try {
        make(i);
      } catch (const GivenUp&) {
      }
      done_[i] = 1.0;
    }
  }

  void give_up() { first_found_ = 0; }

  /// Of all, 0...1.
  [[nodiscard]] double done() const {
    double sum = 0.0;
    for (const std::atomic<double>& one : done_) {
      sum += one;
    }
    return sum / static_cast<double>(done_.size());
  }

  [[nodiscard]] std::optional<FoundMeeting> result() {
    for (std::size_t i = 0; i < found_.size(); ++i) {
      if (found_[i]) {
        return FoundMeeting{i, std::move(*found_[i])};
      }
    }
    return std::nullopt;
  }

 private:
  void make(std::size_t number) {
    const auto go_on = [&] {
      if (number >= first_found_) {
        throw GivenUp{};
      }
    };
    go_on();
    const MeetingPass& pass = passes_[number];
    found_[number] = joined_if_found(
        maps_[pass.map], maps_[pass.there], pass.is_back, options_,
        [&](double done) {
          go_on();
          done_[number] = done;
        },
        go_on);
    std::size_t first = first_found_;
    while (found_[number] && number < first && !first_found_.compare_exchange_weak(first, number)) {
    }
  }

  const std::vector<MergedMap>& maps_;
  const std::vector<MeetingPass>& passes_;
  const EngineOptions& options_;
  std::atomic<std::size_t> next_{0};
  std::atomic<std::size_t> first_found_;  ///< passes from this one on are given up
  std::vector<std::atomic<double>> done_;
  std::vector<std::optional<MergedMap>> found_;
};

}  // namespace

std::optional<FoundMeeting> search_meetings(const std::vector<MergedMap>& maps,
                                            const std::vector<MeetingPass>& passes,
                                            const EngineOptions& options,
                                            const std::function<void(double done)>& progress) {
  if (passes.empty()) {
    return std::nullopt;
  }
  progress(0.0);
  Passes work(maps, passes, options);
  const std::size_t cores = std::max(1U, std::thread::hardware_concurrency());
  std::vector<std::future<void>> workers;
  for (std::size_t i = 0; i < std::min(cores, passes.size()); ++i) {
    workers.push_back(std::async(std::launch::async, [&work] { work.work(); }));
  }
  std::exception_ptr ended;
  for (std::future<void>& worker : workers) {
    while (worker.wait_for(std::chrono::milliseconds(50)) != std::future_status::ready) {
      try {
        if (!ended) {
          progress(work.done());
        }
      } catch (...) {
        ended = std::current_exception();
        work.give_up();
      }
    }
  }
  if (ended) {
    std::rethrow_exception(ended);
  }
  for (std::future<void>& worker : workers) {
    worker.get();
  }
  return work.result();
}

}  // namespace matchbox_slam
