#pragma once

#include <stdexcept>

namespace matchbox_slam {

/// Thrown when a recording cannot be read. The text names the file, what is wrong and what to do.
class BagError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace matchbox_slam
