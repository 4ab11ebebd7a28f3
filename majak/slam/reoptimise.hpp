// SPDX-License-Identifier: Apache-2.0
// A map optimised anew from its Site alone, when a person has switched closures off or on again.
// The log is not needed and nothing is matched to local maps or searched again: the front end's
// poses, the key scans' links and the closures are in the Site (docs/MATH.md, "Corrected by hand").
#pragma once

#include <cstddef>

#include "majak/core/parallel.hpp"
#include "majak/core/site.hpp"
#include "majak/slam/graph_slam.hpp"

namespace majak::slam {

/// Is the closure between these scans switched off by an edit?
bool switched_off(const Site& site, std::size_t from, std::size_t to);

/// The site with all poses, covariances and constraints as graph SLAM leaves them with the closures
/// that no edit (nor `options`) switches off. With those that it was made with, it is the same bit
/// by bit. `options`: those that the site was made with. Throws Error where the site does not know
/// enough: made by another method, or kept by a version that did not write the key scans' links.
Site reoptimised(Site site, const GraphSlamOptions& options, Threads threads);

}  // namespace majak::slam
