// SPDX-License-Identifier: Apache-2.0
#include "majak/map/room_labels.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

#include "majak/core/error.hpp"

namespace majak::map {
namespace {

constexpr double kSame = 0.5;  // of the old outline's floor

/// By the number of sides to the right of p.
bool inside(const std::vector<Vec2>& polygon, const Vec2& p) {
  bool in = false;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    if ((a.y() > p.y()) == (b.y() > p.y())) continue;
    if (p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x())) in = !in;
  }
  return in;
}

/// How many cells of each room lie within the polygon, and, last, how many cells in all.
std::vector<std::size_t> cells_within(const Topology& t, const std::vector<Vec2>& polygon) {
  std::vector<std::size_t> count(t.rooms.size() + 1, 0);
  Vec2 low = polygon.front(), high = low;
  for (const Vec2& p : polygon) low = low.cwiseMin(p), high = high.cwiseMax(p);
  for (double y = low.y() + t.resolution / 2; y < high.y(); y += t.resolution)
    for (double x = low.x() + t.resolution / 2; x < high.x(); x += t.resolution) {
      if (!inside(polygon, {x, y})) continue;
      ++count.back();
      const int room = t.room_at({x, y});
      if (room >= 0) ++count[room];
    }
  return count;
}

std::string rounded(double value, int digits) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.*f", digits, value);
  return text.data();
}

}  // namespace

const char* name_of(LabelFate fate) {
  return fate == LabelFate::kept ? "kept" : fate == LabelFate::moved ? "moved" : "lost";
}

std::vector<LabelMatch> match_labels(const Topology& t, std::span<const RoomLabel> labels) {
  std::vector<LabelMatch> matches;
  for (const RoomLabel& label : labels) {
    const int here = t.room_at(label.at);
    LabelMatch match;
    if (label.outline.size() < 3) {
      if (here >= 0) match = {here, LabelFate::kept, 0};
      matches.push_back(match);
      continue;
    }
    const auto cells = cells_within(t, label.outline);
    const auto share = [&](int room) {
      return cells.back() == 0
                 ? 0.0
                 : static_cast<double>(cells[room]) / static_cast<double>(cells.back());
    };
    const auto most = std::max_element(cells.begin(), cells.end() - 1);
    const int best = most == cells.end() - 1 ? -1 : static_cast<int>(most - cells.begin());
    if (best >= 0 && share(best) >= kSame)
      match = {best, best == here ? LabelFate::kept : LabelFate::moved, share(best)};
    else if (here >= 0 && share(here) > 0)
      match = {here, here == best ? LabelFate::kept : LabelFate::moved, share(here)};
    matches.push_back(match);
  }
  return matches;
}

std::vector<std::string> room_names(const Topology& t, std::span<const RoomLabel> labels) {
  std::vector<std::string> names;
  std::array<int, 3> count{};
  for (const Room& room : t.rooms)
    names.push_back(std::string(name_of(room.kind)) + " " +
                    std::to_string(++count[static_cast<std::size_t>(room.kind)]));
  const auto matches = match_labels(t, labels);
  for (std::size_t i = 0; i < labels.size(); ++i)
    if (matches[i].room >= 0) names[matches[i].room] = labels[i].text;
  return names;
}

std::string evidence_of(const Room& room) {
  const std::string width = rounded(room.width, 1);
  switch (room.kind) {
    case RoomKind::corridor:
      return width + " m wide and " + rounded(room.area / (room.width * room.width), 0) +
             " times as long";
    case RoomKind::hall:
      return rounded(room.area, 0) + " m2, " + width + " m wide";
    case RoomKind::room:
      break;
  }
  return rounded(room.area, 1) + " m2, " + std::to_string(room.doors) +
         (room.doors == 1 ? " door" : " doors");
}

RoomLabel label_at(const Topology& t, const Vec2& p, std::string text) {
  const int room = t.room_at(p);
  if (room < 0) throw Error("no room at " + rounded(p.x(), 2) + ", " + rounded(p.y(), 2) + " m");
  return {std::move(text), p, t.rooms[room].outline};
}

}  // namespace majak::map
