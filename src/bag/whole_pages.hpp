#pragma once

namespace matchbox_slam {

/// The name of a file system for SQLite that hides what a database has beyond its last whole page.
/// SQLite itself takes the rest of a page that was cut off for zeros, and those for data.
[[nodiscard]] const char* whole_pages_system();

}  // namespace matchbox_slam
