#include "bag/bag_writer.hpp"

#include <console_bridge/console.h>
#include <fmt/core.h>

#include <cstdio>
#include <exception>
#include <filesystem>
#include <utility>

#include "matchbox_slam/io/file.hpp"

namespace matchbox_slam {
namespace {

std::string cannot_write(const std::string& path, const std::exception& reason) {
  return fmt::format(
      "{}: the bag cannot be written: {}; is the disk full? may its folder be written to?", path,
      reason.what());
}

}  // namespace

BagWriter::BagWriter(std::string path, rosbag::CompressionType compression)
    : path_(std::move(path)), unfinished_path_(path_ + ".unfinished") {
  if (std::filesystem::is_directory(path_)) {
    throw FileError(path_ + ": the bag cannot be written: there is a folder of that name");
  }
  try {
    bag_->open(unfinished_path_, rosbag::bagmode::Write);
    bag_->setCompression(compression);
  } catch (const rosbag::BagException& error) {
    throw_away();
    throw FileError(cannot_write(path_, error));
  }
}

BagWriter::~BagWriter() { throw_away(); }

void BagWriter::throw_away() {
  if (bag_->isOpen()) {
    try {
      bag_->close();
    } catch (const rosbag::BagException&) {
      // What kept it from being written was told before. On a full disk librosbag's destructor
      // would try to write once more, and the exception would end the program: the bag is given up.
      // Of what it leaves behind newer versions of class_loader complain at the end.
      (void)bag_.release();  // NOLINT(bugprone-unused-return-value)
      console_bridge::noOutputHandler();
    }
    std::remove(unfinished_path_.c_str());
  }
}

void BagWriter::write(const std::function<void(rosbag::Bag&)>& write_messages) {
  try {
    write_messages(*bag_);
    bag_->close();
    std::filesystem::rename(unfinished_path_, path_);
  } catch (const rosbag::BagException& error) {
    throw FileError(cannot_write(path_, error));
  } catch (const std::filesystem::filesystem_error& error) {
    throw FileError(cannot_write(path_, error));
  }
}

}  // namespace matchbox_slam
