#pragma once

#include <optional>
#include <string>
#include <vector>

#include "run/run_dialog.hpp"
#include "run/slam_run.hpp"

namespace matchbox_slam {

/// A saved map that a session goes on with.
struct SavedStart {
  EngineState map;
  std::string file;  ///< where it was, for people
  /// Whether odometry that went on meanwhile tells that it is the same drive: so it is where the
  /// same program was only started again.
  bool may_odometry_tell = false;
};

/// A run from its start to its end: how it begins with a saved map, what a jump of time does, and
/// what people are told of all that. The node and map_bag bring it scans and events, and show or
/// write what comes of them.
class SlamSession {
 public:
  /// @param dialog      is told what happens, while this object is used.
  /// @param how_to_set  for people, before an option's name, `=` and value: "give --set ".
  SlamSession(LiveConfiguration configuration, RunRecords records, RunDialog dialog,
              std::string how_to_set);

  /// Before the first scan: goes on from there. The map can be seen at once; whether the first scan
  /// is of the same drive, or the robot is searched for, is settled when it comes.
  void go_on_with(SavedStart saved);

  /// Begins with a map that was loaded, now unless it goes on with a saved one, and each time when
  /// a map is given up. The robot is where start_x, start_y and start_theta say; where nobody has
  /// set them and the map is only to be localised in, it is searched for.
  void begin_with(LoadMapFile initial);

  /// What gives up the map for the one that it begins with, or for none, and says where the robot
  /// is in it: to be applied in this order.
  [[nodiscard]] std::vector<RunEvent> beginning() const;

  /// As SlamRun::process and apply.
  std::optional<ScanOutcome> process(const ScanInput& input);
  void apply(const RunEvent& event);

  /// Time has jumped back: the map goes on or is given up, as `time_jump` says. Returns whether it
  /// is given up.
  /// @param jumped   what to say of it, up to what is done about it.
  /// @param stopped  as of the scan queue: no more scans come.
  [[nodiscard]] bool jump_back(const std::string& jumped, bool stopped);

  /// As SlamRun::begin_drive.
  void begin_drive(double stamp);

  /// Beams that meet nothing are seen to read one range plus noise: what is to be applied so that
  /// they are cut, in this order. Nothing where a limit was set by hand; nor with several lasers,
  /// one of which is no reason to cut all.
  /// @param from       first range [m] that is no return.
  /// @param has_begun  whether such beams may be in the map: then it begins anew, unless it is one
  ///                   that it goes on with.
  [[nodiscard]] std::vector<RunEvent> cut_no_returns(double from, bool has_begun);

  /// Tells once, as soon as it is known, that beams end on the robot, or that scans have few
  /// returns.
  void advise();
  /// What it tells of these; empty: there is nothing to say.
  [[nodiscard]] std::string robot_beams() const;
  [[nodiscard]] std::string few_returns() const;

  /// These as of SlamRun.
  void note_left_out(double stamp, int laser) { run_.note_left_out(stamp, laser); }
  void finish() { run_.finish(); }
  void expect_map(std::shared_ptr<const FoundMap> found) { run_.expect_map(std::move(found)); }
  void take_rendered(SlamMap map, const PlacedScans& keys) {
    run_.take_rendered(std::move(map), keys);
  }
  [[nodiscard]] const SlamRun& run() const { return run_; }
  [[nodiscard]] const SlamSetup& setup() const { return run_.setup(); }

 private:
  [[nodiscard]] bool is_start_given() const;
  void take_up(const ScanInput& input);
  void take_up_limit(const ScanInput& input);
  void tell(const ScanOutcome& outcome);

  SlamRun run_;
  RunDialog dialog_;
  std::string how_to_set_;
  bool is_continued_ = false;        ///< it has begun with a saved map
  std::optional<SavedStart> saved_;  ///< until it shows which drive goes on in it
  std::optional<LoadMapFile> initial_;
  bool may_map_have_limit_ = false;  ///< it was read, and no scan was used since
  bool told_of_left_out_ = false;
  bool told_of_robot_beams_ = false;
  bool told_of_few_returns_ = false;
};

}  // namespace matchbox_slam
