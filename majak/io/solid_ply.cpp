// SPDX-License-Identifier: Apache-2.0
#include "majak/io/byte_codec.hpp"
#include "majak/io/solid_files.hpp"

namespace majak::io {
namespace {

std::string header(const map::SolidCount& n) {
  std::string out =
      "ply\nformat binary_little_endian 1.0\n"
      "comment metres, z up\n"
      "element vertex " +
      std::to_string(n.vertices) + "\n";
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz"})
    out += std::string("property float ") + name + "\n";
  for (const char* name : {"red", "green", "blue"})
    out += std::string("property uchar ") + name + "\n";
  out += "element face " + std::to_string(n.quads + n.triangles) + "\n";
  return out + "property list uchar int vertex_indices\nend_header\n";
}

void write_vertices(ByteWriter& writer, const map::SolidPart& part) {
  for (std::size_t i = 0; i < part.vertices.size(); ++i) {
    for (const float value : part.vertices[i]) writer.f32(value);
    for (const float value : part.normals[i]) writer.f32(value);
    for (const std::uint8_t c : {part.colours[i].r, part.colours[i].g, part.colours[i].b})
      writer.u8(c);
  }
}

template <class Faces>
void write_faces(ByteWriter& writer, const Faces& faces, std::uint32_t first) {
  for (const auto& face : faces) {
    writer.u8(static_cast<std::uint8_t>(face.size()));
    for (const std::uint32_t vertex : face) writer.u32(first + vertex);
  }
}

}  // namespace

std::string solid_ply(const map::Solid& solid) {
  std::string out = header(count(solid));
  ByteWriter writer(out);
  for (const map::SolidPart& part : solid.parts) write_vertices(writer, part);
  std::uint32_t first = 0;
  for (const map::SolidPart& part : solid.parts) {
    write_faces(writer, part.quads, first);
    write_faces(writer, part.triangles, first);
    first += static_cast<std::uint32_t>(part.vertices.size());
  }
  return out;
}

}  // namespace majak::io
