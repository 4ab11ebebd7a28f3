// SPDX-License-Identifier: Apache-2.0
// A site as a run leaves it that knew at every time where it was.
#pragma once

#include "majak/core/site.hpp"
#include "majak/sim/simulator.hpp"

namespace majak::sim {

/// Drives along the path; every scan with the pose at which it was truly taken. Map frame: the
/// world's. Throws Error as Simulator does.
Site surveyed_site(const World& world, const Path& path, const SimulationOptions& options = {});

}  // namespace majak::sim
