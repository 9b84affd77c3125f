#pragma once

#include <exception>
#include <string>
#include <typeinfo>

namespace matchbox_slam {

/// The text of the `Error` that `work` throws; something else when it throws none or another.
template <typename Error, typename Work>
[[nodiscard]] std::string error_text(Work&& work) {
  try {
    work();
  } catch (const Error& error) {
    return error.what();
  } catch (const std::exception& error) {
    return std::string("(another error, ") + typeid(error).name() + ": " + error.what() + ")";
  }
  return "(no error)";
}

[[nodiscard]] inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace matchbox_slam
