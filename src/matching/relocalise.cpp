#include "matchbox_slam/matching/relocalise.hpp"
