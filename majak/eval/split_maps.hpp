// SPDX-License-Identifier: Apache-2.0
// Split-half repeatability of a map of landmarks without truth: the landmark graph is solved twice,
// once with what was seen in the even minutes and once with the odd ones. Wheels and satellites are
// the same in both, and which sighting is which landmark; path and map are not.
#pragma once

#include "majak/eval/landmarks.hpp"
#include "majak/slam/landmark_graph.hpp"

namespace majak::eval {

/// `map`: by the graph. Nothing is aligned. Landmarks seen at least `options.least` times in each
/// half are compared.
SplitHalf split_maps(const slam::LandmarkMap& map, const slam::EkfSlamOptions& ekf,
                     slam::LandmarkGraphOptions graph, const SplitHalfOptions& options = {});

/// The same after one rigid alignment of the two maps: their shape alone.
SplitHalf aligned(SplitHalf split);

}  // namespace majak::eval
