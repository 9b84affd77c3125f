#pragma once

#include "io/picture.hpp"

namespace matchbox_slam {

/// A bar of a round length, with that beside it.
struct ScaleBar {
  int left = 0;            ///< [pixels]
  int middle = 0;          ///< of its height [pixels]
  double longest = 100.0;  ///< [pixels]
  double pixels_per_metre = 1.0;
  int dot = 1;        ///< thickness [pixels]
  int font_size = 1;  ///< [pixels]
};

void draw_scale_bar(const ScaleBar& bar, Picture& picture);

}  // namespace matchbox_slam
