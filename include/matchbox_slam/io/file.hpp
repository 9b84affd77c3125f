#pragma once

#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace matchbox_slam {

/// Thrown when a file cannot be read, is not what it should be, or cannot be written. The text
/// names the file, and the line where there is one.
class FileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Thrown when what a file holds is not what was written to it, or is something else: nobody can
/// read it. A file that may not be read now, or not by this version, is whole: FileError.
class DamagedFile : public FileError {
 public:
  using FileError::FileError;
};

/// Thrown when there is no file of a name that was given: it is wrong, or it is a folder's.
class MissingFile : public FileError {
 public:
  using FileError::FileError;
};

/// The whole path of a file, wherever the program was started, as roslaunch starts nodes in a
/// folder of its own; an empty one stays so.
[[nodiscard]] std::string absolute_path(const std::string& path);

/// The whole file as bytes. Throws MissingFile when there is none, FileError when it cannot be
/// read.
[[nodiscard]] std::string read_file(const std::string& path);

struct FileContents {
  std::string path;
  std::string bytes;
};

/// Takes bytes as they come.
using ByteSink = std::function<void(const std::string& bytes)>;

/// Replaces files that belong together. Each is first written beside its final place; only when all
/// of them are there and flushed to the disk do they take their names. So whoever reads meanwhile,
/// and whoever reads after a crash, finds every file either as it was or as it should be. What was
/// written aside goes with this object.
/// Members throw FileError when a file cannot be written: one that could not be added is removed.
class FileReplacement {
 public:
  FileReplacement();
  FileReplacement(const FileReplacement&) = delete;
  FileReplacement& operator=(const FileReplacement&) = delete;
  ~FileReplacement();

  /// Writes a file aside.
  void add(const FileContents& file);

  /// The same piece by piece, so that the whole need not be in memory.
  /// @param write_all  gives all of it to the sink. What it throws passes through, but for a
  ///                   std::system_error, which is taken for one of writing.
  void add(const std::string& path, const std::function<void(const ByteSink&)>& write_all);

  /// Begins a file whose pieces come while other work is done. Its sink throws FileError when one
  /// cannot be written, and is good until this object is finished or gone.
  [[nodiscard]] ByteSink begin(const std::string& path);

  /// Lets all files take their names, one after the other: where one cannot, those before it have.
  void finish();

 private:
  struct Written;
  std::unique_ptr<Written> written_;
};

/// The same for files that are there as a whole.
void replace_files(const std::vector<FileContents>& files);

/// The same for a single file.
void replace_file(const std::string& path, const std::string& bytes);

/// Keeps what a file holds now under another name, too, in place of what that was, so that the file
/// can be replaced. Where there is no such file, neither is the other one then. Throws FileError.
void keep_as(const std::string& path, const std::string& kept);

/// Moves files into a new folder: `folder`, or that with the first of .2, .3 and so on that there
/// is not yet. Files that are not there are passed over; each has moved before the next one does.
/// Returns the folder. Throws FileError naming the file and the reason.
std::string set_aside(const std::vector<std::string>& files, const std::string& folder);

/// Makes sure that replace_file can write this file, without touching it; to be called before work
/// starts whose result is to go there. Throws FileError naming the file and the reason.
void require_writable_file(const std::string& path);

/// Creates the folder, with its parents, unless it exists, and makes sure that files can be written
/// to it; to be called before work starts whose results are to go there.
/// Throws FileError naming the folder and the reason.
void require_writable_folder(const std::string& folder);

}  // namespace matchbox_slam
