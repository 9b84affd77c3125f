#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "matchbox_slam/slam/engine_state.hpp"
#include "merging/map_meeting.hpp"
#include "run/run_dialog.hpp"
#include "slam/found_map.hpp"

namespace matchbox_slam {

/// A run's map as it is now.
struct OwnMap {
  KeyScans key_scans;
  LoopState loops;  ///< nothing pending
  EngineOptions options;
};

/// Other robots' maps, each searched for where the run's map meets it, in a thread of its own while
/// the run goes on: each key scan is searched in them, once. Where they meet both are
/// joined as they are then (`joined`), and the run takes that in; where its map has moved
/// meanwhile, they are joined again.
class OtherMaps {
 public:
  using Look = std::function<OwnMap()>;
  using Give = std::function<void(std::shared_ptr<const FoundMap> found)>;

  /// @param look    called from the thread, as the next two.
  /// @param give    as SlamRun::expect_map.
  /// @param dialog  is told when a map has become part of the run's.
  OtherMaps(Look look, Give give, RunDialog dialog);
  /// Waits for the thread.
  ~OtherMaps();

  OtherMaps(const OtherMaps&) = delete;
  OtherMaps& operator=(const OtherMaps&) = delete;

  /// Searches this one, too, with its disconnected components. Throws std::runtime_error for one
  /// that is searched already, or whose key scans the run's map has.
  /// @param name  for people.
  void add(const std::string& name, EngineState map);

  /// They are forgotten, as the run's map is.
  void clear();

  /// None is searched any more, and none given, from the next key scan on. Does not wait, as that
  /// one may take a while.
  void give_up();

  /// How many are searched, each component for itself.
  [[nodiscard]] std::size_t waiting() const { return waiting_; }

 private:
  struct Searched;

  void run();
  void take_added();
  void search_or_tell(Searched& searched);
  void search(Searched& searched);
  void walk(Searched& searched, const OwnMap& own);
  [[nodiscard]] bool join(Searched& searched, const OwnMap& own);
  void require_going_on() const;

  const Look look_;
  const Give give_;
  const RunDialog dialog_;
  mutable std::mutex mutex_;  ///< guards what follows, up to those that the thread has
  std::condition_variable changed_;
  bool stop_ = false;
  std::size_t generation_ = 0;  ///< that `clear` counts
  struct Given {
    std::string name;
    KeyScans key_scans;
    std::shared_ptr<const EngineState> map;  ///< until the thread begins with it
  };
  std::vector<Given> given_;  ///< since the run's map began
  std::size_t begun_ = 0;     ///< of these, those that the thread has begun with
  std::atomic<std::size_t> waiting_{0};
  std::vector<Searched> searched_;
  std::size_t searched_generation_ = 0;
  std::thread thread_;  ///< last: it uses all of the above
};

}  // namespace matchbox_slam
