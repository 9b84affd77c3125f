#pragma once

#include <stdexcept>

namespace matchbox_slam {

/// Thrown by work that its user ended before there was anything to write. That is no failure: the
/// programs say so and exit 0. The text says what became of the results.
class Interrupted : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace matchbox_slam
