#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "bag/recording_file.hpp"

namespace matchbox_slam {

/// What is asked of one file.
struct FileSelection {
  const RecordingFile* file = nullptr;  ///< outlives the messages; not empty
  BagSelection selection;
};

/// Messages of several files in the order of time; those of one time in the order of the files. A
/// file is opened when its time has come, and closed at its end: a drive may be split into more
/// than a process may have open.
class MergedMessages {
 public:
  explicit MergedMessages(std::vector<FileSelection> files);

  /// The next one; none at the end. Throws BagError where the file is damaged.
  [[nodiscard]] std::optional<RecordedMessage> next();

 private:
  struct Open {
    std::size_t place = 0;  ///< among the files
    std::unique_ptr<RecordedMessages> messages;
    ros::Time time;  ///< of the next one
  };

  void look_at_taken();
  void open_those_due();
  void open(std::size_t place);
  [[nodiscard]] std::vector<Open>::iterator first_open();

  std::vector<FileSelection> files_;
  std::vector<std::size_t> order_;  ///< places of the files, by the times of their first messages
  std::size_t next_ = 0;            ///< in the order: from here on they are closed
  std::vector<Open> open_;
  std::optional<std::size_t> taken_;  ///< place of the file whose message was given last
};

}  // namespace matchbox_slam
