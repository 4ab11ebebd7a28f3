// SPDX-License-Identifier: Apache-2.0
#include "majak/map/topology.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "majak/core/option_range.hpp"
#include "majak/map/distance_transform.hpp"
#include "majak/map/door_gaps.hpp"
#include "majak/map/region_outline.hpp"

namespace majak::map {
namespace {

constexpr std::array<std::pair<int, int>, 4> kSides{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};
constexpr std::array<std::pair<int, int>, 8> kAround{
    {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {1, -1}, {-1, 1}, {-1, -1}}};
constexpr double kSmallThing = 0.5;     // m: legs, chairs, people; whatever their shape
constexpr double kCorridor = 6.0;       // times as long as wide in the mean, at least,
constexpr double kCorridorWide = 4.0;   // and as where it is widest
constexpr double kCorridorWidth = 3.5;  // m, at most
constexpr double kHallArea = 45;        // m^2
constexpr double kAhead = 0.35;         // m, before a door one is in the room
constexpr double kLeafOut = 0.2;        // m from a door's line on, things are not of its wall
constexpr double kJambLength = 0.6;     // m beside a gap that are surely wall
constexpr double kLeafThick = 0.2;      // m, no leaf is
constexpr double kCommonWall = 2.5;     // m on both sides of a gap that are looked at
constexpr double kLeastCommon = 0.4;    // m of wall between two rooms, at least, and ...
constexpr double kCommonShare = 0.4;    // ... for each m of gap
constexpr double kFrayed = 0.3;         // share of wall around a room without doors, at least

/// Cells of one kind that hang together; visit(cells) for each, ascending.
template <std::size_t N, class In, class Visit>
void for_each_component(int width, int height, const std::array<std::pair<int, int>, N>& around,
                        const In& in, const Visit& visit) {
  std::vector<std::uint8_t> seen(static_cast<std::size_t>(width) * height, 0);
  std::vector<std::uint32_t> cells;
  for (std::uint32_t start = 0; start < seen.size(); ++start) {
    if (seen[start] || !in(start)) continue;
    cells.assign(1, start);
    seen[start] = 1;
    for (std::size_t k = 0; k < cells.size(); ++k) {
      const int x = static_cast<int>(cells[k] % width), y = static_cast<int>(cells[k] / width);
      for (const auto& [dx, dy] : around) {
        const int nx = x + dx, ny = y + dy;
        if (nx < 0 || ny < 0 || nx >= width || ny >= height) continue;
        const auto next = static_cast<std::uint32_t>(ny * width + nx);
        if (seen[next] || !in(next)) continue;
        seen[next] = 1;
        cells.push_back(next);
      }
    }
    visit(cells);
  }
}

class Builder {
 public:
  Builder(const KnownMap& known, const TopologyOptions& options, Threads threads)
      : known_(known), options_(options), threads_(threads) {
    t_.resolution = known.resolution;
    t_.x0 = known.x0;
    t_.y0 = known.y0;
    t_.width = known.width;
    t_.height = known.height;
    t_.labels.assign(known.cells.size(), -1);
    walls_ = {known.width, known.height, {}};
    walls_.cells.resize(known.cells.size());
    std::transform(known.cells.begin(), known.cells.end(), walls_.cells.begin(),
                   [](CellState s) { return s != CellState::free; });
    surfaces_ = walls_;
    std::transform(known.cells.begin(), known.cells.end(), surfaces_.cells.begin(),
                   [](CellState s) { return s == CellState::occupied; });
  }

  Topology build() {
    clear_small_things();
    gaps_ = find_door_gaps(walls_, surfaces_, known_.resolution, options_, threads_);
    if (take_off_leaves())
      gaps_ = find_door_gaps(walls_, surfaces_, known_.resolution, options_, threads_);
    cut_.assign(walls_.cells.size(), 0);
    for (const DoorGap& gap : gaps_) cut(gap);
    distances_ = squared_distances(walls_, threads_);
    label_cores();
    grow();
    join_over_weak_gaps();
    absorb_small_rooms();
    join_over_weak_gaps();
    join_doors();
    drop_frayed();
    clear_furniture();
    distances_ = squared_distances(walls_, threads_);
    describe_rooms();
    place_furniture();
    return std::move(t_);
  }

 private:
  // --- What is wall and what stands about -------------------------------------------------------

  struct Bounds {
    int x0, y0, x1, y1;
  };
  Bounds bounds_of(const std::vector<std::uint32_t>& cells) const {
    Bounds b{t_.width, t_.height, -1, -1};
    for (const std::uint32_t cell : cells) {
      const int x = static_cast<int>(cell % t_.width), y = static_cast<int>(cell / t_.width);
      b = {std::min(b.x0, x), std::min(b.y0, y), std::max(b.x1, x), std::max(b.y1, y)};
    }
    return b;
  }

  /// Small islands, whatever they are, become floor.
  void clear_small_things() {
    std::vector<std::uint32_t> cleared;
    for_each_island(kSmallThing, [&](const std::vector<std::uint32_t>& cells, const Bounds& b) {
      note_furniture(b);
      cleared.insert(cleared.end(), cells.begin(), cells.end());
    });
    for (const std::uint32_t cell : cleared) walls_.cells[cell] = 0;
  }

  /// Islands of at most `size` m that touch the map's rim nowhere.
  template <class Visit>
  void for_each_island(double size, const Visit& visit) const {
    for_each_component(
        t_.width, t_.height, kAround, [&](std::uint32_t c) { return walls_.cells[c] != 0; },
        [&](const std::vector<std::uint32_t>& cells) {
          const Bounds b = bounds_of(cells);
          if (b.x0 == 0 || b.y0 == 0 || b.x1 == t_.width - 1 || b.y1 == t_.height - 1) return;
          if (std::max(b.x1 - b.x0 + 1, b.y1 - b.y0 + 1) * t_.resolution <= size) visit(cells, b);
        });
  }

  void note_furniture(const Bounds& b) {
    const Vec2 size = Vec2(b.x1 - b.x0 + 1, b.y1 - b.y0 + 1) * t_.resolution;
    const Vec2 low = Vec2(t_.x0, t_.y0) + Vec2(b.x0, b.y0) * t_.resolution;
    t_.furniture.push_back({low + size / 2, size, -1});
  }

  /// An island around which there is one room and no other stands on its floor; pieces of wall have
  /// different rooms at their sides.
  void clear_furniture() {
    std::vector<std::pair<std::uint32_t, int>> cleared;
    for_each_island(options_.furniture,
                    [&](const std::vector<std::uint32_t>& cells, const Bounds& b) {
                      int room = -1;
                      bool one = true;
                      for (const std::uint32_t c : cells)
                        for_each_side(c, [&](std::uint32_t n) {
                          if (walls_.cells[n] != 0) return;
                          one = one && t_.labels[n] >= 0 && (room < 0 || room == t_.labels[n]);
                          room = t_.labels[n];
                        });
                      if (!one || room < 0) return;
                      note_furniture(b);
                      for (const std::uint32_t c : cells) cleared.emplace_back(c, room);
                    });
    for (const auto& [cell, room] : cleared) {
      walls_.cells[cell] = 0;
      t_.labels[cell] = room;
    }
  }

  /// Thin things that hang on a door's jamb, turned out of the wall and no longer than the door is
  /// wide, become floor. What is the wall of a better gap is no leaf.
  bool take_off_leaves() {
    std::vector<std::uint32_t> leaves;
    std::vector<std::uint8_t> wall(walls_.cells.size(), 0);
    for (const DoorGap& gap : gaps_) {
      if (gap.width <= options_.widest_door) {
        find_leaf(gap, gap.dx0, gap.dy0, wall, leaves);
        find_leaf(gap, gap.dx1, gap.dy1, wall, leaves);
      }
      mark_jambs(gap, wall);
    }
    for (const std::uint32_t cell : leaves) walls_.cells[cell] = 0;
    return !leaves.empty();
  }

  void mark_jambs(const DoorGap& gap, std::vector<std::uint8_t>& wall) const {
    const Vec2 along(std::cos(gap.angle), std::sin(gap.angle)), across(-along.y(), along.x());
    const double half = kLeafOut / t_.resolution, length = kJambLength / t_.resolution;
    const double ends[2] = {Vec2(gap.dx0, gap.dy0).norm(), -Vec2(gap.dx1, gap.dy1).norm()};
    for (const double end : ends)
      for (double i = 1; i <= length; ++i)
        for (double k = -half; k <= half; ++k) {
          const Vec2 p = Vec2(gap.ix, gap.iy) + (end + (end > 0 ? i : -i)) * along + k * across;
          const int x = static_cast<int>(std::lround(p.x())),
                    y = static_cast<int>(std::lround(p.y()));
          if (walls_.at(x, y)) wall[walls_.index(x, y)] = 1;
        }
  }

  void find_leaf(const DoorGap& gap, int dx, int dy,
                 const std::vector<std::uint8_t>& wall_of_better,
                 std::vector<std::uint32_t>& leaves) const {
    const Vec2 jamb(gap.ix + dx, gap.iy + dy);  // cells
    const Vec2 across(-std::sin(gap.angle), std::cos(gap.angle));
    const double wall = kLeafOut / t_.resolution, reach = (gap.width + 0.2) / t_.resolution;
    std::vector<std::uint32_t> cells;
    bool ends = true;
    const auto add = [&](int x, int y) {
      if (!walls_.at(x, y) || std::abs((Vec2(x, y) - jamb).dot(across)) < wall) return;
      const auto c = static_cast<std::uint32_t>(walls_.index(x, y));
      if (std::find(cells.begin(), cells.end(), c) != cells.end()) return;
      ends = ends && (Vec2(x, y) - jamb).norm() <= reach && !wall_of_better[c] && !bulky(x, y);
      cells.push_back(c);
    };
    const int near = static_cast<int>(std::ceil(wall)) + 3;
    for (int y = -near; y <= near; ++y)
      for (int x = -near; x <= near; ++x)
        add(static_cast<int>(jamb.x()) + x, static_cast<int>(jamb.y()) + y);
    for (std::size_t k = 0; k < cells.size() && ends; ++k)
      for (const auto& [ax, ay] : kAround)
        add(static_cast<int>(cells[k] % t_.width) + ax, static_cast<int>(cells[k] / t_.width) + ay);
    if (ends) leaves.insert(leaves.end(), cells.begin(), cells.end());
  }

  /// In the middle of a square of wall that no leaf has.
  bool bulky(int x, int y) const {
    const int half = std::max(1, static_cast<int>(std::lround(0.5 * kLeafThick / t_.resolution)));
    for (int dy = -half; dy <= half; ++dy)
      for (int dx = -half; dx <= half; ++dx)
        if (!walls_.at(x + dx, y + dy)) return false;
    return true;
  }

  /// A line of cells that hang together by their corners, so that no side-by-side way crosses it.
  void cut(const DoorGap& gap) {
    const int n = std::max(std::abs(gap.dx1 - gap.dx0), std::abs(gap.dy1 - gap.dy0));
    for (int i = 0; i <= n; ++i) {
      const double f = n == 0 ? 0 : static_cast<double>(i) / n;
      const int x = gap.ix + static_cast<int>(std::lround(gap.dx0 + f * (gap.dx1 - gap.dx0)));
      const int y = gap.iy + static_cast<int>(std::lround(gap.dy0 + f * (gap.dy1 - gap.dy0)));
      cut_[walls_.index(x, y)] = 1;
    }
  }

  // --- Rooms ------------------------------------------------------------------------------------

  double area_of(std::size_t cells) const {
    return static_cast<double>(cells) * t_.resolution * t_.resolution;
  }

  /// Where a passage is, it is wide enough somewhere; what hangs together without crossing a cut is
  /// one room.
  void label_cores() {
    const double least = 0.5 * (options_.leak / t_.resolution + 1);
    const auto core = [&](std::uint32_t c) {
      return walls_.cells[c] == 0 && cut_[c] == 0 && distances_[c] >= least * least;
    };
    for_each_component(t_.width, t_.height, kSides, core,
                       [&](const std::vector<std::uint32_t>& cells) {
                         if (area_of(cells.size()) < 0.2 * options_.smallest_room) return;
                         for (const std::uint32_t c : cells) t_.labels[c] = count_;
                         ++count_;
                       });
  }

  /// The rest of the floor goes to the room that reaches it first.
  void grow() {
    for (const bool over_cuts : {false, true}) {
      std::vector<std::uint32_t> front;
      for (std::uint32_t c = 0; c < t_.labels.size(); ++c)
        if (t_.labels[c] >= 0) front.push_back(c);
      for (std::size_t k = 0; k < front.size(); ++k)
        for_each_side(front[k], [&](std::uint32_t next) {
          if (t_.labels[next] >= 0 || walls_.cells[next] != 0) return;
          if (cut_[next] != 0 && !over_cuts) return;
          t_.labels[next] = t_.labels[front[k]];
          front.push_back(next);
        });
    }
  }

  template <class Visit>
  void for_each_side(std::uint32_t cell, const Visit& visit) const {
    const int x = static_cast<int>(cell % t_.width), y = static_cast<int>(cell / t_.width);
    for (const auto& [dx, dy] : kSides)
      if (walls_.inside(x + dx, y + dy))
        visit(static_cast<std::uint32_t>(walls_.index(x + dx, y + dy)));
  }

  /// The smallest room that is too small, or -1.
  int too_small() const {
    std::vector<std::size_t> size(count_, 0);
    for (const std::int32_t label : t_.labels)
      if (label >= 0) ++size[label];
    const auto least = std::min_element(size.begin(), size.end());
    return least == size.end() || area_of(*least) >= options_.smallest_room
               ? -1
               : static_cast<int>(least - size.begin());
  }

  /// The room that is least parted from this one: by the worst gap; where there are several by none
  /// at all, the one with the longest border. -1 where there is no other.
  int least_parted(int room) const {
    std::vector<int> border(count_, 0);
    for (std::uint32_t c = 0; c < t_.labels.size(); ++c) {
      if (t_.labels[c] != room) continue;
      for_each_side(c, [&](std::uint32_t n) {
        if (t_.labels[n] >= 0 && t_.labels[n] != room) ++border[t_.labels[n]];
      });
    }
    std::vector<double> score(count_, 0);
    for (const DoorGap& gap : gaps_) {
      const auto [a, b] = sides_of(gap);
      if (a < 0 || b < 0 || a == b || (a != room && b != room)) continue;
      double& s = score[a == room ? b : a];
      s = std::max(s, gap.score);
    }
    int best = -1;
    for (int r = 0; r < count_; ++r)
      if (border[r] > 0 && (best < 0 || score[r] < score[best] ||
                            (score[r] == score[best] && border[r] > border[best])))
        best = r;
    return best;
  }

  /// A room that is too small becomes part of its neighbour, the smallest first; none where there
  /// is no other.
  void absorb_small_rooms() {
    for (int room = too_small(); room >= 0; room = too_small()) join(room, least_parted(room));
  }

  /// becomes[r]: another room (which may become something in turn), itself, or -1.
  void renumber(std::vector<int> becomes) {
    const auto last = [&](int r) {
      while (r >= 0 && becomes[r] != r) r = becomes[r];
      return r;
    };
    std::vector<int> number(becomes.size(), -1);
    int count = 0;
    for (int r = 0; r < static_cast<int>(becomes.size()); ++r)
      if (becomes[r] == r) number[r] = count++;
    for (std::int32_t& label : t_.labels) {
      const int r = label < 0 ? -1 : last(label);
      label = r < 0 ? -1 : number[r];
    }
    count_ = count;
  }

  // --- Doors ------------------------------------------------------------------------------------

  /// The rooms to the left and to the right of a gap, -1 where none is.
  std::pair<int, int> sides_of(const DoorGap& gap) const {
    const double ahead = kAhead / t_.resolution;
    const auto room = [&](double distance) {
      const int x = gap.ix - static_cast<int>(std::lround(distance * std::sin(gap.angle)));
      const int y = gap.iy + static_cast<int>(std::lround(distance * std::cos(gap.angle)));
      return walls_.inside(x, y) ? t_.labels[walls_.index(x, y)] : -1;
    };
    return {room(ahead), room(-ahead)};
  }

  /// Is there wall across the line at `at` (cells), with `a` to its left and `b` to its right?
  bool parts(const Vec2& at, const Vec2& left, int a, int b) const {
    const int reach = static_cast<int>(std::lround((options_.thickest_wall + 0.2) / t_.resolution));
    bool behind_a = false, in_wall = false;  // going from left to right
    for (int i = reach; i >= -reach; --i) {
      const int x = static_cast<int>(std::lround(at.x() + i * left.x()));
      const int y = static_cast<int>(std::lround(at.y() + i * left.y()));
      if (!walls_.inside(x, y)) continue;
      const std::size_t c = walls_.index(x, y);
      if (walls_.cells[c] != 0) {
        in_wall = behind_a;
      } else {
        if (in_wall && t_.labels[c] == b) return true;
        behind_a = t_.labels[c] == a;
        in_wall = false;
      }
    }
    return false;
  }

  /// m of wall in line with a gap that part the same two rooms.
  double common_wall(const DoorGap& gap, int a, int b) const {
    const Vec2 along(std::cos(gap.angle), std::sin(gap.angle)), left(-along.y(), along.x());
    const Vec2 middle(gap.ix, gap.iy);
    int cells = 0;
    for (const double sign : {1.0, -1.0}) {
      const double from = sign > 0 ? Vec2(gap.dx0, gap.dy0).norm() : Vec2(gap.dx1, gap.dy1).norm();
      for (int i = 1; i * t_.resolution <= kCommonWall; ++i)
        cells += parts(middle + sign * (from + i) * along, left, a, b);
    }
    return cells * t_.resolution;
  }

  /// Two rooms become one over a gap beside which hardly any wall parts them; the worst gap first,
  /// since what lies behind it may then have more wall in common with others.
  void join_over_weak_gaps() {
    for (;;) {
      const DoorGap* worst = nullptr;
      for (const DoorGap& gap : gaps_) {
        const auto [a, b] = sides_of(gap);
        if (a < 0 || b < 0 || a == b || (worst != nullptr && gap.score >= worst->score)) continue;
        const double least = std::max(kLeastCommon, kCommonShare * gap.width);
        if (common_wall(gap, a, b) < least) worst = &gap;
      }
      if (worst == nullptr) return;
      const auto [a, b] = sides_of(*worst);
      join(std::max(a, b), std::min(a, b));
    }
  }

  void join(int room, int into) {
    std::vector<int> becomes(count_);
    std::iota(becomes.begin(), becomes.end(), 0);
    becomes[room] = into;
    renumber(becomes);
  }

  /// A gap between two rooms is a door.
  void join_doors() {
    for (const DoorGap& gap : gaps_) {
      const auto [a, b] = sides_of(gap);
      if (a < 0 || b < 0 || a == b) continue;
      const Vec2 middle = t_.centre(static_cast<std::uint32_t>(walls_.index(gap.ix, gap.iy)));
      const Vec2 offset = 0.5 * t_.resolution * Vec2(gap.dx0 + gap.dx1, gap.dy0 + gap.dy1);
      t_.doors.push_back({middle + offset,
                          {std::cos(gap.angle), std::sin(gap.angle)},
                          gap.width,
                          std::min(a, b),
                          std::max(a, b),
                          gap.width > options_.widest_door});
    }
  }

  /// What was seen through windows: no doors, and little wall around it.
  void drop_frayed() {
    std::vector<int> wall(count_, 0), open(count_, 0), doors(count_, 0), becomes(count_);
    for (const Doorway& d : t_.doors) ++doors[d.from], ++doors[d.to];
    for (std::uint32_t c = 0; c < t_.labels.size(); ++c) {
      const int r = t_.labels[c];
      if (r < 0) continue;
      for_each_side(c, [&](std::uint32_t n) {
        if (walls_.cells[n] == 0) return;
        ++(known_.cells[n] == CellState::occupied ? wall : open)[r];
      });
    }
    for (int r = 0; r < count_; ++r)
      becomes[r] = doors[r] == 0 && wall[r] < kFrayed * (wall[r] + open[r]) ? -1 : r;
    std::vector<int> number(count_);
    for (int r = 0, count = 0; r < count_; ++r) number[r] = becomes[r] == r ? count++ : -1;
    for (Doorway& d : t_.doors) d.from = number[d.from], d.to = number[d.to];
    renumber(becomes);
  }

  // --- What is known of them --------------------------------------------------------------------

  void describe_rooms() {
    t_.rooms.resize(count_);
    for (std::uint32_t c = 0; c < t_.labels.size(); ++c)
      if (t_.labels[c] >= 0) t_.rooms[t_.labels[c]].cells.push_back(c);
    for (const Doorway& d : t_.doors) ++t_.rooms[d.from].doors, ++t_.rooms[d.to].doors;
    for (int r = 0; r < count_; ++r) describe_room(r);
  }

  void describe_room(int number) {
    Room& room = t_.rooms[number];
    room.area = area_of(room.cells.size());
    std::uint32_t widest = room.cells.front();
    Vec2 sum = Vec2::Zero();
    double to_wall = 0;                                           // cells, in the mean
    const double half_map = 0.5 * std::min(t_.width, t_.height);  // beyond it nothing is known
    for (const std::uint32_t c : room.cells) {
      sum += t_.centre(c);
      to_wall += std::min(std::sqrt(distances_[c]), half_map) - 0.5;
      if (distances_[c] > distances_[widest]) widest = c;
    }
    const auto n = static_cast<double>(room.cells.size());
    room.centroid = sum / n;
    room.widest_spot = t_.centre(widest);
    room.clearance = (std::min(std::sqrt(distances_[widest]), half_map) - 0.5) * t_.resolution;
    room.width = 4 * to_wall / n * t_.resolution;
    room.kind = is_corridor(room)        ? RoomKind::corridor
                : room.area >= kHallArea ? RoomKind::hall
                                         : RoomKind::room;
    room.outline = region_outline(t_, number);
  }

  /// Long by both widths: what stands along its walls makes a room narrow by one of them alone.
  static bool is_corridor(const Room& room) {
    return room.doors >= 2 && room.width <= kCorridorWidth &&
           room.area >= kCorridor * room.width * room.width &&
           room.area >= kCorridorWide * std::pow(2 * room.clearance, 2);
  }

  void place_furniture() {
    for (Furniture& f : t_.furniture) f.room = t_.room_at(f.centre);
    std::erase_if(t_.furniture, [](const Furniture& f) { return f.room < 0; });
  }

  const KnownMap& known_;
  const TopologyOptions& options_;
  Threads threads_;
  Topology t_;
  CellMask walls_;     ///< all that is no floor
  CellMask surfaces_;  ///< where something was seen
  std::vector<DoorGap> gaps_;
  std::vector<std::uint8_t> cut_;
  std::vector<std::int32_t> distances_;
  int count_ = 0;
};

}  // namespace

const char* name_of(RoomKind kind) {
  return kind == RoomKind::room ? "room" : kind == RoomKind::corridor ? "corridor" : "hall";
}

int Topology::room_at(const Vec2& p) const {
  const double x = std::floor((p.x() - x0) / resolution), y = std::floor((p.y() - y0) / resolution);
  if (!(x >= 0 && y >= 0 && x < width && y < height)) return -1;
  return labels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                static_cast<std::size_t>(x)];
}

Topology build_topology(const KnownMap& known, const TopologyOptions& options, Threads threads) {
  require_in_range(options);
  return Builder(known, options, threads).build();
}

}  // namespace majak::map
