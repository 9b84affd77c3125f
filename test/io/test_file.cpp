#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

#include "common/error_text.hpp"
#include "io/temporary_folder.hpp"
#include "matchbox_slam/io/file.hpp"

namespace matchbox_slam {
namespace {

/// While it lives, no file can grow beyond so many bytes: a disk that is full.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) {
    handler_ = std::signal(SIGXFSZ, SIG_IGN);
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;
  ~FullDisk() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  rlimit before_{};
  void (*handler_)(int) = nullptr;
};

TEST(AbsolutePath, LeadsFromTheFolderThatTheProgramWasStartedIn) {
  EXPECT_EQ(absolute_path("a/map.slam"), (std::filesystem::current_path() / "a/map.slam").string());
  EXPECT_EQ(absolute_path("/a/map.slam"), "/a/map.slam");
  EXPECT_EQ(absolute_path(""), "") << "none";
}

TEST(ReplaceFile, WritesAndReplacesBytesAsTheyAre) {
  const TemporaryFolder folder;
  const std::string bytes("a\0b\r\n\xff", 6);
  replace_file(folder / "file", bytes);
  EXPECT_EQ(read_file(folder / "file"), bytes);
  replace_file(folder / "file", "short");
  EXPECT_EQ(read_file(folder / "file"), "short");
  replace_file(folder / "file", "");
  EXPECT_EQ(read_file(folder / "file"), "");
  EXPECT_EQ(folder.file_count(), 1U);
}

TEST(ReplaceFile, LeavesTheOldFileAndNoOtherWhenTheDiskIsFull) {
  const TemporaryFolder folder;
  replace_file(folder / "file", "old");
  std::string text;
  {
    const FullDisk full(1000);
    text = error_text<FileError>([&] { replace_file(folder / "file", std::string(5000, 'x')); });
  }
  EXPECT_TRUE(contains(text, "cannot write '" + (folder / "file") + "': File too large")) << text;
  EXPECT_EQ(read_file(folder / "file"), "old");
  EXPECT_EQ(folder.file_count(), 1U);
}

TEST(ReplaceFiles, ReplacesNoneWhenOneCannotBeWritten) {
  const TemporaryFolder folder;
  replace_file(folder / "first", "old");
  {
    const FullDisk full(1000);
    EXPECT_THROW(
        replace_files({{folder / "first", "new"}, {folder / "second", std::string(5000, 'x')}}),
        FileError);
  }
  EXPECT_EQ(read_file(folder / "first"), "old");
  EXPECT_EQ(folder.file_count(), 1U);
}

TEST(ReplaceFiles, ReplacesNoneWhenAFolderIsInTheWayOfOne) {
  const TemporaryFolder folder;
  replace_file(folder / "first", "old");
  std::filesystem::create_directory(folder / "second");
  EXPECT_THROW(replace_files({{folder / "first", "new"}, {folder / "second", "new"}}), FileError);
  EXPECT_EQ(read_file(folder / "first"), "old");
}

TEST(FileReplacement, TakesPiecesAndReplacesAllAtOnce) {
  const TemporaryFolder folder;
  replace_file(folder / "first", "old");
  FileReplacement replacement;
  replacement.add({folder / "first", "new"});
  replacement.add(folder / "second", [](const ByteSink& sink) {
    sink("piece ");
    sink("by piece");
  });
  EXPECT_EQ(read_file(folder / "first"), "old");
  EXPECT_FALSE(std::filesystem::exists(folder / "second"));
  replacement.finish();
  EXPECT_EQ(read_file(folder / "first"), "new");
  EXPECT_EQ(read_file(folder / "second"), "piece by piece");
  EXPECT_EQ(folder.file_count(), 2U);
}

TEST(FileReplacement, PiecesMayComeWhileOtherFilesAreAdded) {
  const TemporaryFolder folder;
  FileReplacement replacement;
  const ByteSink sink = replacement.begin(folder / "first");
  sink("piece ");
  replacement.add({folder / "second", "new"});
  sink("by piece");
  EXPECT_FALSE(std::filesystem::exists(folder / "first"));
  replacement.finish();
  EXPECT_EQ(read_file(folder / "first"), "piece by piece");
  EXPECT_EQ(read_file(folder / "second"), "new");
  EXPECT_THROW((void)replacement.begin(folder.path()), FileError) << "a folder";
  EXPECT_THROW((void)replacement.begin(folder / "missing/first"), FileError);
  EXPECT_EQ(folder.file_count(), 2U);
}

TEST(FileReplacement, LeavesEverythingAsItWasWhenItIsNotFinished) {
  const TemporaryFolder folder;
  replace_file(folder / "first", "old");
  {
    FileReplacement replacement;
    replacement.add({folder / "first", "new"});
    replacement.add({folder / "second", "new"});
  }
  EXPECT_EQ(read_file(folder / "first"), "old");
  EXPECT_EQ(folder.file_count(), 1U);
}

TEST(FileReplacement, WhatCouldNotBeAddedIsNotThere) {
  const TemporaryFolder folder;
  FileReplacement replacement;
  replacement.add({folder / "first", "new"});
  EXPECT_EQ(error_text<std::invalid_argument>([&] {
              replacement.add(folder / "second", [](const ByteSink& sink) {
                sink("half of it");
                throw std::invalid_argument("that is not it");
              });
            }),
            "that is not it");
  {
    const FullDisk full(1000);
    EXPECT_THROW(replacement.add(folder / "third",
                                 [](const ByteSink& sink) {
                                   sink(std::string(900, 'x'));
                                   sink(std::string(900, 'x'));
                                 }),
                 FileError);
  }
  EXPECT_EQ(folder.file_count(), 1U) << "the first one, aside";
  replacement.finish();
  EXPECT_EQ(read_file(folder / "first"), "new");
  EXPECT_EQ(folder.file_count(), 1U);
}

TEST(ReplaceFile, SaysWhyAPlaceCannotBeWritten) {
  const TemporaryFolder folder;
  const std::string nowhere = folder / "no/such/folder/file";
  EXPECT_EQ(error_text<FileError>([&] { replace_file(nowhere, "x"); }),
            "cannot write '" + nowhere + "': No such file or directory");
  EXPECT_EQ(error_text<FileError>([&] { replace_file(folder.path(), "x"); }),
            "cannot write '" + folder.path() + "': Is a directory");
}

TEST(ReadFile, SaysWhyAFileCannotBeRead) {
  const TemporaryFolder folder;
  EXPECT_EQ(error_text<FileError>([&] { (void)read_file(folder / "none"); }),
            "cannot read '" + (folder / "none") + "': No such file or directory");
  EXPECT_EQ(error_text<FileError>([&] { (void)read_file(folder.path()); }),
            "cannot read '" + folder.path() + "': Is a directory");
}

TEST(SetAside, MovesWhatIsThereIntoAFolderOfItsOwn) {
  const TemporaryFolder folder;
  replace_file(folder / "a", "1");
  replace_file(folder / "b", "2");
  const std::vector<std::string> files = {folder / "b", folder / "none", folder / "a"};
  EXPECT_EQ(set_aside(files, folder / "old"), folder / "old");
  EXPECT_EQ(read_file(folder / "old/a"), "1");
  EXPECT_EQ(read_file(folder / "old/b"), "2");
  EXPECT_EQ(folder.file_count(), 1U);
  replace_file(folder / "a", "3");
  EXPECT_EQ(set_aside({folder / "a"}, folder / "old"), folder / "old.2");
  EXPECT_EQ(read_file(folder / "old/a"), "1");
  EXPECT_EQ(read_file(folder / "old.2/a"), "3");
  replace_file(folder / "a", "4");
  EXPECT_EQ(error_text<FileError>([&] { set_aside({folder / "a"}, folder / "nowhere/old"); }),
            "cannot move files to '" + (folder / "nowhere/old") + "': No such file or directory");
  EXPECT_EQ(read_file(folder / "a"), "4");
}

TEST(RequireWritableFile, LeavesNoTraceWhereAFileCanBeWritten) {
  const TemporaryFolder folder;
  require_writable_file(folder / "new");
  EXPECT_EQ(folder.file_count(), 0U);
  replace_file(folder / "old", "contents");
  require_writable_file(folder / "old");
  EXPECT_EQ(read_file(folder / "old"), "contents");
  EXPECT_EQ(folder.file_count(), 1U);
}

TEST(RequireWritableFile, NamesTheFileThatCannotBeWritten) {
  const TemporaryFolder folder;
  EXPECT_EQ(error_text<FileError>([&] { require_writable_file(folder / "none/file"); }),
            "cannot write '" + (folder / "none/file") + "': No such file or directory");
  EXPECT_EQ(error_text<FileError>([&] { require_writable_file(folder.path()); }),
            "cannot write '" + folder.path() + "': Is a directory");
}

TEST(RequireWritableFolder, CreatesItWithItsParentsAndLeavesItEmpty) {
  const TemporaryFolder folder;
  require_writable_folder(folder / "a/b/c");
  require_writable_folder(folder / "a/b/c/");
  EXPECT_TRUE(std::filesystem::is_empty(folder / "a/b/c"));
}

TEST(RequireWritableFolder, SaysWhyItCannotBe) {
  const TemporaryFolder folder;
  replace_file(folder / "file", "x");
  for (const std::string name : {"file", "file/below"}) {
    const std::string text = error_text<FileError>([&] { require_writable_folder(folder / name); });
    EXPECT_TRUE(contains(text, "cannot create the folder '" + (folder / name) +
                                   "' and write to it: Not a directory"))
        << text;
  }
}

TEST(RequireWritableFolder, NeedsThePermissionToWrite) {
  if (::geteuid() == 0) {
    GTEST_SKIP() << "root may write everywhere";
  }
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "locked");
  std::filesystem::permissions(folder / "locked", std::filesystem::perms::owner_read);
  const std::string text =
      error_text<FileError>([&] { require_writable_folder(folder / "locked"); });
  EXPECT_TRUE(contains(text, "Permission denied")) << text;
}

TEST(ReplaceFile, RemovesWhatAKilledProgramLeftBeside) {
  const TemporaryFolder folder;
  const std::string nobody = std::to_string(999999999);
  const std::string left = folder / (".map.slam." + nobody + ".0");
  const std::vector<std::string> others = {
      folder / (".map.slam." + std::to_string(::getpid()) + ".7"),  // somebody is still at it
      folder / (".map.pgm." + nobody + ".0"), folder / (".map.slam." + nobody + ".0.copy"),
      folder / ".map.slam.backup", folder / "map.slam.old"};
  const auto now = std::filesystem::file_time_type::clock::now();
  const auto write = [&](const std::string& path) {
    replace_file(path, "half of it");
    std::filesystem::last_write_time(path, now - std::chrono::hours(2));
  };
  write(left);
  std::for_each(others.begin(), others.end(), write);
  replace_file(folder / "map.slam", "all");
  EXPECT_FALSE(std::filesystem::exists(left));
  for (const std::string& other : others) {
    EXPECT_TRUE(std::filesystem::exists(other)) << other;
  }
  replace_file(left, "new");  // it may be that of a program on another machine
  replace_file(folder / "map.slam", "all");
  EXPECT_TRUE(std::filesystem::exists(left));
}

TEST(KeepAs, KeepsWhatTheFileHoldsUnderAnotherName) {
  const TemporaryFolder folder;
  const std::string path = folder / "map";
  const std::string kept = folder / "map.1";
  for (const std::string bytes : {"first", "second"}) {
    replace_file(path, bytes);
    keep_as(path, kept);
    keep_as(path, kept);  // both are names of one file
    replace_file(path, "new");
    EXPECT_EQ(read_file(kept), bytes);
    EXPECT_EQ(read_file(path), "new");
    EXPECT_EQ(folder.file_count(), 2U);
  }
  std::filesystem::remove(path);
  keep_as(path, kept);
  EXPECT_EQ(folder.file_count(), 0U) << "there is none";
  replace_file(path, "new");
  std::filesystem::create_directory(kept);
  const std::string told = error_text<FileError>([&] { keep_as(path, kept); });
  EXPECT_TRUE(contains(told, "cannot write '" + kept + "'")) << told;
}

}  // namespace
}  // namespace matchbox_slam
