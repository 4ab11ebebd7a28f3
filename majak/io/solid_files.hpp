// SPDX-License-Identifier: Apache-2.0
// A solid for other people's programs: VRML97 for old viewers and CAD, glTF for browsers and
// everything new, PLY for programs that work on points and meshes. Metres, 0.1 mm in VRML.
#pragma once

#include <string>

#include "majak/map/solid.hpp"

namespace majak::io {

/// VRML97 (ISO/IEC 14772-1), a .wrl: an IndexedFaceSet a part, or a PointSet, named by DEF. One
/// Transform turns the map's z up to VRML's y up.
std::string solid_vrml(const map::Solid& solid);

/// glTF 2.0, binary (a .glb): a node and a mesh a part. glTF's y is up: the root node turns z
/// there. Colours become linear, as glTF has it; quads become two triangles.
std::string solid_gltf(const map::Solid& solid);

/// PLY, binary little-endian, all parts as one: z stays up.
std::string solid_ply(const map::Solid& solid);

}  // namespace majak::io
