// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>

#include "majak/io/byte_codec.hpp"
#include "majak/io/solid_files.hpp"

namespace majak::io {
namespace {

using Json = nlohmann::ordered_json;

// Numbers of the standard (glTF 2.0, 5.1.3, 5.11.5, 5.24.4).
constexpr int kFloat = 5126, kUnsignedShort = 5123, kUnsignedInt = 5125;
constexpr int kVertices = 34962, kIndices = 34963;
constexpr int kPoints = 0, kTriangles = 4;
constexpr std::uint32_t kMagic = 0x46546C67, kVersion = 2, kJsonChunk = 0x4E4F534A,
                        kBinaryChunk = 0x004E4942;

/// sRGB to linear, 16 bits (IEC 61966-2-1).
std::uint16_t linear(std::uint8_t value) {
  const double v = value / 255.0;
  const double light = v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
  return static_cast<std::uint16_t>(std::lround(65535 * light));
}

/// The file while it grows: what the buffer holds, and who reads which part of it as what.
class GltfBuilder {
 public:
  GltfBuilder() : writer_(bytes_) {
    json_ = {{"asset", {{"version", "2.0"}, {"generator", "majak"}}}, {"scene", 0}};
    // The map's z to glTF's y: a quarter turn about x.
    const double half = std::sqrt(0.5);
    json_["scenes"] = Json::array({{{"nodes", {0}}}});
    json_["nodes"] = Json::array({{{"name", "map, z up"}, {"rotation", {-half, 0.0, 0.0, half}}}});
  }

  void add(const map::SolidPart& part) {
    Json primitive{{"attributes",
                    {{"POSITION", vectors(part.vertices, true)},
                     {"NORMAL", vectors(part.normals, false)},
                     {"COLOR_0", colours(part.colours)}}}};
    if (!part.cloud()) primitive["indices"] = faces(part);
    primitive["material"] = 0;
    primitive["mode"] = part.cloud() ? kPoints : kTriangles;
    json_["nodes"][0]["children"].push_back(json_["nodes"].size());
    json_["nodes"].push_back({{"name", part.name}, {"mesh", json_["meshes"].size()}});
    json_["meshes"].push_back({{"name", part.name}, {"primitives", Json::array({primitive})}});
  }

  std::string file() {
    if (!bytes_.empty()) {
      json_["materials"] = Json::array(
          {{{"pbrMetallicRoughness", {{"metallicFactor", 0.0}, {"roughnessFactor", 1.0}}},
            {"doubleSided", true}}});
      json_["buffers"] = Json::array({{{"byteLength", bytes_.size()}}});
    }
    std::string text = json_.dump(-1, ' ', false, Json::error_handler_t::replace);
    text.resize((text.size() + 3) / 4 * 4, ' ');
    const std::size_t binary = bytes_.empty() ? 0 : 8 + bytes_.size();
    std::string out;
    ByteWriter writer(out);
    for (const std::uint32_t word :
         {kMagic, kVersion, static_cast<std::uint32_t>(12 + 8 + text.size() + binary),
          static_cast<std::uint32_t>(text.size()), kJsonChunk})
      writer.u32(word);
    out += text;
    if (binary == 0) return out;
    writer.u32(static_cast<std::uint32_t>(bytes_.size()));
    writer.u32(kBinaryChunk);
    return out + bytes_;
  }

 private:
  /// An accessor on a view of its own: all that was written since `begin`.
  std::size_t accessor(std::size_t begin, int target, Json what) {
    const std::size_t view = json_["bufferViews"].size();
    json_["bufferViews"].push_back({{"buffer", 0},
                                    {"byteOffset", begin},
                                    {"byteLength", bytes_.size() - begin},
                                    {"target", target}});
    what["bufferView"] = view;
    json_["accessors"].push_back(std::move(what));
    return json_["accessors"].size() - 1;
  }

  std::size_t vectors(const std::vector<Eigen::Vector3f>& list, bool with_bounds) {
    const std::size_t begin = bytes_.size();
    Eigen::Vector3f low = list.front(), high = list.front();
    for (const Eigen::Vector3f& v : list) {
      for (const float value : v) writer_.f32(value);
      low = low.cwiseMin(v), high = high.cwiseMax(v);
    }
    Json what{{"componentType", kFloat}, {"count", list.size()}, {"type", "VEC3"}};
    if (with_bounds) {
      what["min"] = {low.x(), low.y(), low.z()};
      what["max"] = {high.x(), high.y(), high.z()};
    }
    return accessor(begin, kVertices, std::move(what));
  }

  void u16(std::uint16_t value) {
    writer_.u8(static_cast<std::uint8_t>(value & 255));
    writer_.u8(static_cast<std::uint8_t>(value >> 8));
  }

  std::size_t colours(const std::vector<map::Rgb>& list) {
    const std::size_t begin = bytes_.size();
    for (const map::Rgb& c : list) {
      for (const std::uint8_t value : {c.r, c.g, c.b}) u16(linear(value));
      u16(65535);
    }
    return accessor(begin, kVertices,
                    {{"componentType", kUnsignedShort},
                     {"normalized", true},
                     {"count", list.size()},
                     {"type", "VEC4"}});
  }

  std::size_t faces(const map::SolidPart& part) {
    const std::size_t begin = bytes_.size();
    const auto triangle = [this](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
      writer_.u32(a), writer_.u32(b), writer_.u32(c);
    };
    for (const auto& q : part.quads) triangle(q[0], q[1], q[2]), triangle(q[0], q[2], q[3]);
    for (const auto& t : part.triangles) triangle(t[0], t[1], t[2]);
    const std::size_t n = 3 * (2 * part.quads.size() + part.triangles.size());
    return accessor(begin, kIndices,
                    {{"componentType", kUnsignedInt}, {"count", n}, {"type", "SCALAR"}});
  }

  Json json_;
  std::string bytes_;
  ByteWriter writer_;
};

}  // namespace

std::string solid_gltf(const map::Solid& solid) {
  GltfBuilder builder;
  for (const map::SolidPart& part : solid.parts)
    if (!part.vertices.empty()) builder.add(part);
  return builder.file();
}

}  // namespace majak::io
