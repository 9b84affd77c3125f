#pragma once
#include "matchbox_slam/matching/hough_search.hpp"
