#include "matchbox_slam/io/file.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <system_error>
#include <utility>

namespace matchbox_slam {
namespace {

namespace fs = std::filesystem;

std::string reason(int error) { return std::generic_category().message(error); }

[[noreturn]] void throw_system_error(int error) {
  throw std::system_error(error, std::generic_category());
}

fs::path folder_of(const std::string& path) {
  const fs::path folder = fs::path(path).parent_path();
  return folder.empty() ? fs::path(".") : folder;
}

/// Beside `path`, for its new contents. The process's number tells whether it still writes there.
std::string name_aside(const std::string& path) {
  return fmt::format(".{}.", fs::path(path).filename().string());
}

/// Removes what a program left beside `path` that was killed while it wrote; not what may belong to
/// a program that this one cannot see, as of another machine.
void remove_left_behind(const std::string& path) {
  constexpr auto kLongestWrite = std::chrono::hours(1);  // from one piece to the next
  const std::string begin = name_aside(path);
  std::error_code ignored;
  for (fs::directory_iterator entry(folder_of(path), ignored); entry != fs::directory_iterator();
       entry.increment(ignored)) {
    const std::string name = entry->path().filename().string();
    if (name.compare(0, begin.size(), begin) != 0) {
      continue;
    }
    int process = 0;
    unsigned attempt = 0;
    int end = 0;
    const char* numbers = name.c_str() + begin.size();
    const bool is_ours = std::sscanf(numbers, "%d.%u%n", &process, &attempt, &end) == 2 &&
                         numbers[end] == '\0' && process > 0;
    if (is_ours && ::kill(process, 0) != 0 && errno == ESRCH &&
        entry->last_write_time(ignored) + kLongestWrite < fs::file_time_type::clock::now()) {
      fs::remove(entry->path(), ignored);
    }
  }
}

/// A file beside the one it is going to replace. Removed with this object unless it took its name.
/// Throws std::system_error.
class FileAside {
 public:
  explicit FileAside(std::string final_path) : final_path_(std::move(final_path)) {
    // Not open() on a fixed name: two programs, or two threads, may write the same file at once.
    for (unsigned attempt = 0; descriptor_ < 0; ++attempt) {
      path_ = folder_of(final_path_) /
              fmt::format("{}{}.{}", name_aside(final_path_), ::getpid(), attempt);
      descriptor_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
      if (descriptor_ < 0 && errno != EEXIST) {
        throw_system_error(errno);
      }
    }
  }

  FileAside(const FileAside&) = delete;
  FileAside& operator=(const FileAside&) = delete;

  ~FileAside() {
    if (descriptor_ >= 0) {
      ::close(descriptor_);
    }
    if (!path_.empty()) {
      ::unlink(path_.c_str());
    }
  }

  void write(const std::string& bytes) {
    std::size_t written = 0;
    while (written < bytes.size()) {
      const ssize_t count = ::write(descriptor_, bytes.data() + written, bytes.size() - written);
      if (count < 0 && errno != EINTR) {
        throw_system_error(errno);
      }
      written += count > 0 ? static_cast<std::size_t>(count) : 0;
    }
  }

  /// To be called once, after everything.
  void flush() {
    if (::fsync(descriptor_) != 0 && errno != EINVAL) {  // EINVAL: a file system without fsync
      throw_system_error(errno);
    }
    // Some network file systems report a full disk only here.
    if (::close(std::exchange(descriptor_, -1)) != 0) {
      throw_system_error(errno);
    }
  }

  [[nodiscard]] const std::string& final_path() const { return final_path_; }

  void take_final_name() {
    if (std::rename(path_.c_str(), final_path_.c_str()) != 0) {
      throw_system_error(errno);
    }
    path_.clear();
  }

 private:
  std::string final_path_;
  fs::path path_;
  int descriptor_ = -1;
};

/// Makes new names last through a power cut. Where the system cannot, the files are there anyway.
void flush_folder(const fs::path& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor >= 0) {
    ::fsync(descriptor);
    ::close(descriptor);
  }
}

void require_replaceable(const std::string& path) {
  std::error_code ignored;
  if (fs::path(path).filename().empty() || fs::is_directory(path, ignored)) {
    throw_system_error(EISDIR);
  }
}

std::unique_ptr<FileAside> begin_aside(const std::string& path) {
  require_replaceable(path);
  remove_left_behind(path);
  return std::make_unique<FileAside>(path);
}

template <typename Work>
void explain_failure(const std::string& path, Work&& work) {
  try {
    work();
  } catch (const std::system_error& error) {
    throw FileError(fmt::format("cannot write '{}': {}", path, error.code().message()));
  }
}

}  // namespace

std::string absolute_path(const std::string& path) {
  return path.empty() ? path : fs::absolute(path).string();
}

std::string read_file(const std::string& path) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) {
    throw MissingFile(fmt::format("cannot read '{}': {}", path, reason(EISDIR)));
  }
  std::ifstream stream(path, std::ios::binary);
  if (!stream) {
    const int error = errno;
    const std::string text = fmt::format("cannot read '{}': {}", path, reason(error));
    if (error == ENOENT || error == ENOTDIR) {
      throw MissingFile(text);
    }
    throw FileError(text);
  }
  std::string bytes{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  if (stream.bad()) {
    throw FileError(fmt::format("cannot read '{}': {}", path, reason(EIO)));
  }
  return bytes;
}

struct FileReplacement::Written {
  std::vector<std::unique_ptr<FileAside>> files;
};

FileReplacement::FileReplacement() : written_(std::make_unique<Written>()) {}
FileReplacement::~FileReplacement() = default;

void FileReplacement::add(const FileContents& file) {
  add(file.path, [&file](const ByteSink& write) { write(file.bytes); });
}

void FileReplacement::add(const std::string& path,
                          const std::function<void(const ByteSink&)>& write_all) {
  explain_failure(path, [&] {
    std::unique_ptr<FileAside> aside = begin_aside(path);
    write_all([&aside](const std::string& bytes) { aside->write(bytes); });
    written_->files.push_back(std::move(aside));
  });
}

ByteSink FileReplacement::begin(const std::string& path) {
  explain_failure(path, [&] { written_->files.push_back(begin_aside(path)); });
  return [file = written_->files.back().get()](const std::string& bytes) {
    explain_failure(file->final_path(), [&] { file->write(bytes); });
  };
}

void FileReplacement::finish() {
  for (const auto& file : written_->files) {
    explain_failure(file->final_path(), [&] { file->flush(); });
  }
  for (const auto& file : written_->files) {
    explain_failure(file->final_path(), [&] { file->take_final_name(); });
  }
  for (const auto& file : written_->files) {
    flush_folder(folder_of(file->final_path()));
  }
  written_->files.clear();
}

void replace_files(const std::vector<FileContents>& files) {
  FileReplacement replacement;
  for (const FileContents& file : files) {
    replacement.add(file);
  }
  replacement.finish();
}

void replace_file(const std::string& path, const std::string& bytes) {
  replace_files({{path, bytes}});
}

void keep_as(const std::string& path, const std::string& kept) {
  std::error_code ignored;
  explain_failure(kept, [&] {
    require_replaceable(kept);
    if (!fs::is_regular_file(path, ignored)) {
      fs::remove(kept);
      return;
    }
    // A second name costs no space, which may be scarce; where there are none, it is a copy.
    const fs::path linked = folder_of(kept) / fmt::format("{}{}.0", name_aside(kept), ::getpid());
    fs::remove(linked, ignored);
    std::error_code no_link;
    fs::create_hard_link(path, linked, no_link);
    if (no_link) {
      replace_file(kept, read_file(path));
      return;
    }
    fs::rename(linked, kept);
    fs::remove(linked, ignored);  // it is still there where both are names of one file already
  });
}

std::string set_aside(const std::vector<std::string>& files, const std::string& folder) {
  std::string taken = folder;
  const auto explained = [&taken](const std::string& what, auto&& work) {
    try {
      return work();
    } catch (const std::system_error& error) {
      throw FileError(
          fmt::format("cannot move {} to '{}': {}", what, taken, error.code().message()));
    }
  };
  explained("files", [&] {
    for (int number = 2; !fs::create_directory(taken); ++number) {
      taken = fmt::format("{}.{}", folder, number);
    }
  });
  for (const std::string& file : files) {
    explained(fmt::format("'{}'", file), [&] {
      if (fs::exists(fs::symlink_status(file))) {
        fs::rename(file, fs::path(taken) / fs::path(file).filename());
      }
    });
  }
  flush_folder(taken);
  flush_folder(folder_of(taken));
  return taken;
}

void require_writable_file(const std::string& path) {
  explain_failure(path, [&] {
    require_replaceable(path);
    FileAside(path).flush();
  });
}

void require_writable_folder(const std::string& folder) {
  try {
    fs::create_directories(folder);
    FileAside((fs::path(folder) / "write_test").string()).flush();
  } catch (const std::system_error& error) {
    throw FileError(fmt::format("cannot create the folder '{}' and write to it: {}", folder,
                                error.code().message()));
  }
}

}  // namespace matchbox_slam
