// SPDX-License-Identifier: Apache-2.0
#include "majak/io/solid_files.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "majak/io/byte_codec.hpp"

namespace majak::io {
namespace {

using Json = nlohmann::json;

/// A square with a triangle beside it, and a cloud of two points.
map::Solid small() {
  map::Solid solid{{map::SolidPart{.name = "north wall"}, map::SolidPart{.name = "leaves"}}};
  map::SolidPart& wall = solid.parts[0];
  map::add_rectangle(wall, {-1, 2, 0}, {3, 0, 0}, {0, 0, 2.5}, {255, 0, 128});
  wall.vertices.emplace_back(4.25f, 2.0f, 0.0f);
  wall.normals.emplace_back(0.0f, -1.0f, 0.0f);
  wall.colours.push_back({0, 255, 0});
  wall.triangles.push_back({1, 4, 2});
  map::SolidPart& leaves = solid.parts[1];
  leaves.vertices = {{7, 8, 9}, {-7, 8.5f, -0.00001f}};
  leaves.normals = {{0, 0, 1}, {1, 0, 0}};
  leaves.colours = {{1, 2, 3}, {4, 5, 6}};
  return solid;
}

struct Glb {
  Json json;
  std::string binary;
};

Glb parse_glb(const std::string& file) {
  ByteReader head(file);
  EXPECT_EQ(head.u32(), 0x46546C67u);
  EXPECT_EQ(head.u32(), 2u);
  EXPECT_EQ(head.u32(), file.size());
  const std::uint32_t length = head.u32();
  EXPECT_EQ(head.u32(), 0x4E4F534Au);
  EXPECT_EQ(length % 4, 0u);
  Glb glb{Json::parse(file.substr(20, length)), {}};
  if (20 + length == file.size()) return glb;
  ByteReader binary(std::string_view(file).substr(20 + length));
  const std::uint32_t bytes = binary.u32();
  EXPECT_EQ(binary.u32(), 0x004E4942u);
  EXPECT_EQ(binary.left(), bytes);
  glb.binary = file.substr(28 + length);
  return glb;
}

std::string_view view_of(const Glb& glb, const Json& accessor) {
  const Json& view = glb.json["bufferViews"][accessor["bufferView"].get<std::size_t>()];
  return std::string_view(glb.binary).substr(view["byteOffset"], view["byteLength"]);
}

const Json& accessor(const Glb& glb, const Json& number) {
  return glb.json["accessors"][number.get<std::size_t>()];
}

TEST(SolidGltf, HasANodeAndAMeshAPart) {
  const Glb glb = parse_glb(solid_gltf(small()));
  EXPECT_EQ(glb.json["meshes"].size(), 2u);
  EXPECT_EQ(glb.json["nodes"][0]["children"], Json({1, 2}));
  EXPECT_EQ(glb.json["nodes"][1]["name"], "north wall");
  EXPECT_EQ(glb.json["meshes"][0]["primitives"][0]["mode"], 4);
  EXPECT_EQ(glb.json["meshes"][1]["primitives"][0]["mode"], 0);
  EXPECT_EQ(glb.json["buffers"][0]["byteLength"], glb.binary.size());
}

TEST(SolidGltf, PositionsComeBackWithTheirBounds) {
  const map::Solid solid = small();
  const Glb glb = parse_glb(solid_gltf(solid));
  for (std::size_t i = 0; i < 2; ++i) {
    const Json& primitive = glb.json["meshes"][i]["primitives"][0];
    const Json& a = accessor(glb, primitive["attributes"]["POSITION"]);
    ASSERT_EQ(a["count"], solid.parts[i].vertices.size());
    ByteReader reader(view_of(glb, a));
    Eigen::Vector3f low = solid.parts[i].vertices[0], high = low;
    for (const Eigen::Vector3f& v : solid.parts[i].vertices) {
      for (const float value : v) EXPECT_EQ(reader.f32(), value);
      low = low.cwiseMin(v), high = high.cwiseMax(v);
    }
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(a["min"][k].get<float>(), low[k]);
      EXPECT_EQ(a["max"][k].get<float>(), high[k]);
    }
  }
}

TEST(SolidGltf, QuadsAreTwoTrianglesOfTheSameSide) {
  const Glb glb = parse_glb(solid_gltf(small()));
  const Json& a = accessor(glb, glb.json["meshes"][0]["primitives"][0]["indices"]);
  ByteReader reader(view_of(glb, a));
  std::vector<std::uint32_t> indices;
  while (reader.left() > 0) indices.push_back(reader.u32());
  EXPECT_EQ(indices, (std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3, 1, 4, 2}));
  EXPECT_EQ(a["count"], indices.size());
}

TEST(SolidGltf, ColoursAreLinear) {
  const Glb glb = parse_glb(solid_gltf(small()));
  const Json& a = accessor(glb, glb.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"]);
  const std::string_view bytes = view_of(glb, a);
  const auto u16 = [&](std::size_t i) {
    return static_cast<unsigned char>(bytes[2 * i]) +
           256 * static_cast<unsigned char>(bytes[2 * i + 1]);
  };
  EXPECT_EQ(u16(0), 65535);
  EXPECT_EQ(u16(1), 0);
  EXPECT_NEAR(u16(2) / 65535.0, 0.2158605, 1e-5);  // sRGB 128
  EXPECT_EQ(u16(3), 65535);
}

TEST(SolidGltf, TurnsZUpToYUp) {
  const Glb glb = parse_glb(solid_gltf(small()));
  const auto q = glb.json["nodes"][0]["rotation"].get<std::vector<double>>();
  const Eigen::Quaterniond turn(q[3], q[0], q[1], q[2]);
  EXPECT_LT((turn * Eigen::Vector3d::UnitZ() - Eigen::Vector3d::UnitY()).norm(), 1e-12);
}

TEST(SolidGltf, OfNothingHasNoBuffer) {
  const Glb glb = parse_glb(solid_gltf({}));
  EXPECT_FALSE(glb.json.contains("buffers"));
  EXPECT_FALSE(glb.json.contains("meshes"));
}

TEST(SolidPly, ComesBack) {
  const std::string file = solid_ply(small());
  const std::string end = "end_header\n";
  const std::size_t at = file.find(end);
  ASSERT_NE(at, std::string::npos);
  const std::string head = file.substr(0, at);
  EXPECT_EQ(head.rfind("ply\nformat binary_little_endian 1.0\n", 0), 0u);
  EXPECT_NE(head.find("element vertex 7\n"), std::string::npos);
  EXPECT_NE(head.find("element face 2\n"), std::string::npos);
  ByteReader reader(std::string_view(file).substr(at + end.size()));
  for (const map::SolidPart& part : small().parts)
    for (std::size_t i = 0; i < part.vertices.size(); ++i) {
      for (const float value : part.vertices[i]) EXPECT_EQ(reader.f32(), value);
      for (const float value : part.normals[i]) EXPECT_EQ(reader.f32(), value);
      const map::Rgb c{reader.u8(), reader.u8(), reader.u8()};
      EXPECT_EQ(c, part.colours[i]);
    }
  std::vector<std::uint32_t> faces;
  while (reader.left() > 0)
    for (int n = reader.u8(); n > 0; --n) faces.push_back(reader.u32());
  EXPECT_EQ(faces, (std::vector<std::uint32_t>{0, 1, 2, 3, 1, 4, 2}));
}

TEST(SolidPly, FacesOfLaterPartsPointToTheirOwnVertices) {
  map::Solid twice{{small().parts[1], small().parts[0]}};
  const std::string file = solid_ply(twice);
  ByteReader last(std::string_view(file).substr(file.size() - 12));
  EXPECT_EQ(last.u32(), 2u + 1);
  EXPECT_EQ(last.u32(), 2u + 4);
  EXPECT_EQ(last.u32(), 2u + 2);
}

TEST(SolidVrml, IsThis) {
  EXPECT_EQ(solid_vrml(small()),
            "#VRML V2.0 utf8\n"
            "WorldInfo { info [ \"metres; the map's z up is turned to y up\" ] }\n"
            "Transform {\nrotation 1 0 0 -1.5707963\nchildren [\n"
            "DEF part_1_north_wall Shape {\n"
            "appearance Appearance { material Material { } }\n"
            "geometry IndexedFaceSet {\nsolid FALSE\n"
            "coord Coordinate { point [\n"
            "-1 2 0\n2 2 0\n2 2 2.5\n-1 2 2.5\n4.25 2 0\n] }\n"
            "color Color { color [\n"
            "1 0 0.502\n1 0 0.502\n1 0 0.502\n1 0 0.502\n0 1 0\n] }\n"
            "normal Normal { vector [\n0 -1 0\n0 -1 0\n0 -1 0\n0 -1 0\n0 -1 0\n] }\n"
            "coordIndex [\n0 1 2 3 -1\n1 4 2 -1\n]\n"
            "}\n}\n"
            "DEF part_2_leaves Shape {\n"
            "geometry PointSet {\n"
            "coord Coordinate { point [\n7 8 9\n-7 8.5 0\n] }\n"
            "color Color { color [\n0.00392 0.00784 0.0118\n0.0157 0.0196 0.0235\n] }\n"
            "}\n}\n"
            "]\n}\n");
}

TEST(SolidVrml, NamesAreOnesThatVrmlAllows) {
  map::Solid solid = small();
  solid.parts[0].name = "\"}#,.[] \n\xc3\xa4";
  const std::string file = solid_vrml(solid);
  EXPECT_NE(file.find("DEF part_1____________ Shape {"), std::string::npos) << file;
}

TEST(SolidVrml, OfNothingIsAFile) {
  EXPECT_EQ(solid_vrml({}).rfind("#VRML V2.0 utf8\n", 0), 0u);
  EXPECT_EQ(solid_vrml({{map::SolidPart{.name = "empty"}}}), solid_vrml({}));
}

}  // namespace
}  // namespace majak::io
