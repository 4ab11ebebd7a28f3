// SPDX-License-Identifier: Apache-2.0
#include "majak/io/landmark_file.hpp"

#include <fmt/format.h>

#include <memory>
#include <utility>

#include "majak/core/error.hpp"
#include "majak/io/byte_stream.hpp"
#include "majak/io/line_reader.hpp"
#include "majak/io/number.hpp"

namespace majak::io {
namespace {

constexpr std::size_t kMost = 1'000'000;
constexpr double kFarthest = 2e7;  // m

std::vector<Vec2> read_lines(std::unique_ptr<ByteStream> bytes, const std::string& name) {
  LineReader lines(std::move(bytes));
  std::vector<Vec2> places;
  while (const auto line = lines.next()) {
    const std::string text(line->substr(0, line->find('#')));
    Fields fields(text);
    if (fields.at_end()) continue;
    const std::string where = fmt::format("{}:{}: ", name, lines.line());
    Vec2 p;
    double radius = 0;
    if (!fields.number(p.x()) || !fields.number(p.y()) || !fields.number(radius) ||
        !fields.at_end())
      throw Error(where + "a landmark is `x y radius`, metres");
    if (!(p.norm() < kFarthest)) throw Error(where + "a landmark's place is too far off");
    if (places.size() == kMost) throw Error(where + "more than 1000000 landmarks");
    places.push_back(p);
  }
  const Report damage = lines.report();
  if (!damage.empty()) throw Error(name + ": " + damage.entries().begin()->first);
  if (places.empty()) throw Error(name + ": no landmark; a line is `x y radius`");
  return places;
}

}  // namespace

std::vector<Vec2> parse_landmarks(std::string_view text, const std::string& name) {
  return read_lines(open_bytes_in_memory(std::string(text)).bytes, name);
}

std::vector<Vec2> read_landmarks(const std::filesystem::path& path) {
  return read_lines(open_bytes(path).bytes, path.string());
}

}  // namespace majak::io
