#include "bag/whole_pages.hpp"

#include <sqlite3.h>

#include <array>
#include <cstdint>
#include <map>
#include <mutex>

namespace matchbox_slam {
namespace {

constexpr const char* kName = "matchbox_whole_pages";

/// A file's methods as SQLite's own file system has them, and the same but for the size.
struct Methods {
  const sqlite3_io_methods* original = nullptr;
  sqlite3_io_methods changed{};
};

/// By the methods of the system; it has a few kinds of files.
std::map<const sqlite3_io_methods*, Methods>& known_methods() {
  static std::map<const sqlite3_io_methods*, Methods> methods;
  return methods;
}

std::mutex& methods_mutex() {
  static std::mutex mutex;
  return mutex;
}

int whole_pages_size(sqlite3_file* file, sqlite3_int64* size) {
  // In the file's head, big-endian; 1 stands for 65536 (sqlite.org/fileformat2.html).
  constexpr int kPageSizePlace = 16;
  constexpr sqlite3_int64 kLargestPage = 65536;
  const sqlite3_io_methods* original = nullptr;
  {
    const std::lock_guard<std::mutex> lock(methods_mutex());
    for (const auto& [key, methods] : known_methods()) {
      original = file->pMethods == &methods.changed ? methods.original : original;
    }
  }
  const int state = original->xFileSize(file, size);
  std::array<std::uint8_t, 2> bytes{};
  if (state != SQLITE_OK || *size < kPageSizePlace + 2 ||
      original->xRead(file, bytes.data(), 2, kPageSizePlace) != SQLITE_OK) {
    return state;
  }
  const sqlite3_int64 told = 256 * sqlite3_int64{bytes[0]} + bytes[1];
  const sqlite3_int64 page = told == 1 ? kLargestPage : told;
  if (page > 0) {
    *size -= *size % page;
  }
  return state;
}

int open_whole_pages(sqlite3_vfs* system, const char* name, sqlite3_file* file, int flags,
                     int* out_flags) {
  const auto* usual = static_cast<const sqlite3_vfs*>(system->pAppData);
  const int state =
      usual->xOpen(const_cast<sqlite3_vfs*>(usual), name, file, flags, out_flags);  // NOLINT
  if (state == SQLITE_OK && (flags & SQLITE_OPEN_MAIN_DB) != 0) {
    const std::lock_guard<std::mutex> lock(methods_mutex());
    Methods& methods = known_methods()[file->pMethods];
    methods.original = file->pMethods;
    methods.changed = *file->pMethods;
    methods.changed.xFileSize = whole_pages_size;
    file->pMethods = &methods.changed;
  }
  return state;
}

}  // namespace

const char* whole_pages_system() {
  static sqlite3_vfs system = [] {
    sqlite3_vfs* usual = sqlite3_vfs_find(nullptr);
    sqlite3_vfs changed = *usual;
    changed.pNext = nullptr;
    changed.zName = kName;
    changed.pAppData = usual;
    changed.xOpen = open_whole_pages;
    return changed;
  }();
  static const int kState = sqlite3_vfs_register(&system, 0);
  return kState == SQLITE_OK ? kName : nullptr;
}

}  // namespace matchbox_slam
