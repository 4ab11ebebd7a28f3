// SPDX-License-Identifier: Apache-2.0
#include "majak/map/doors.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <unordered_set>

namespace majak::map {
namespace {

constexpr int kGroupReach = 3;           // cells
constexpr std::size_t kMostCells = 400;  // of a group that is looked at
constexpr std::size_t kMostTried = 60;   // cells that lines are laid through
constexpr double kAround = 0.25;         // m; there is floor so far off a leaf
constexpr double kShrunk = 0.05;         // m; the leaf's ends tell nothing, jambs are there
constexpr double kLongestGap = 0.25;     // m, along a leaf

struct Cell {
  int x, y;
};

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

std::uint64_t key(int x, int y) {
  return (static_cast<std::uint64_t>(static_cast<std::uint32_t>(x)) << 32) |
         static_cast<std::uint32_t>(y);
}

enum class Seen : std::uint8_t { nothing, floor, wall, changed };

/// Cells as doors need them. `changed`: stayed occupied and stayed free.
class Cells {
 public:
  Cells(const DynamicsMap& map, double stay) : map_(map), stay_(stay) {}

  double size() const { return map_.resolution(); }

  Seen at(int ix, int iy) const {
    const CellHistory* cell = map_.history(ix, iy);
    if (!cell || !cell->stated) return Seen::nothing;
    const bool stood = map_.longest_stay(*cell, true) >= stay_;
    if (!stood) return Seen::floor;
    return map_.longest_stay(*cell, false) >= stay_ ? Seen::changed : Seen::wall;
  }
  Seen at(const Vec2& p_map) const {
    return at(static_cast<int>(std::floor(p_map.x() / size())),
              static_cast<int>(std::floor(p_map.y() / size())));
  }

  /// Cells that changed, by rows. Not those beside a wall and those without floor on both sides:
  /// poses that err change a wall's cells too.
  std::vector<Cell> changed() const {
    std::vector<Cell> cells;
    const CellBox box = map_.bounds();
    for (int y = box.y0; y < box.y0 + box.height; ++y)
      for (int x = box.x0; x < box.x0 + box.width; ++x)
        if (at(x, y) == Seen::changed && !beside_wall(x, y) && in_the_open(x, y))
          cells.push_back({x, y});
    return cells;
  }

 private:
  bool beside_wall(int ix, int iy) const {
    for (int y = iy - 1; y <= iy + 1; ++y)
      for (int x = ix - 1; x <= ix + 1; ++x)
        if (at(x, y) == Seen::wall) return true;
    return false;
  }

  bool in_the_open(int ix, int iy) const {
    constexpr int kDirections[4][2] = {{1, 0}, {0, 1}, {1, 1}, {1, -1}};
    return std::any_of(std::begin(kDirections), std::end(kDirections), [&](const auto& d) {
      return leads_to_floor(ix, iy, d[0], d[1]) && leads_to_floor(ix, iy, -d[0], -d[1]);
    });
  }

  bool leads_to_floor(int ix, int iy, int dx, int dy) const {
    const int reach = static_cast<int>(std::lround(kAround / size()));
    for (int k = 1; k < reach; ++k)
      if (at(ix + k * dx, iy + k * dy) == Seen::wall) return false;
    return at(ix + reach * dx, iy + reach * dy) == Seen::floor;
  }

  const DynamicsMap& map_;
  double stay_;
};

std::vector<std::vector<Cell>> groups(const std::vector<Cell>& cells) {
  std::unordered_set<std::uint64_t> left;
  for (const Cell& c : cells) left.insert(key(c.x, c.y));
  std::vector<std::vector<Cell>> found;
  for (const Cell& first : cells) {
    if (!left.erase(key(first.x, first.y))) continue;
    std::vector<Cell> group{first};
    for (std::size_t i = 0; i < group.size(); ++i) {
      const Cell c = group[i];
      for (int y = c.y - kGroupReach; y <= c.y + kGroupReach; ++y)
        for (int x = c.x - kGroupReach; x <= c.x + kGroupReach; ++x)
          if (left.erase(key(x, y))) group.push_back({x, y});
    }
    found.push_back(std::move(group));
  }
  return found;
}

/// A run of cells along a line.
struct Stretch {
  DoorSpan ends;
  std::size_t cells = 0;
};

class DoorFinder {
 public:
  DoorFinder(const Cells& cells, const DoorOptions& options)
      : cells_(cells), options_(options), cell_(cells.size()) {}

  /// The stretch with the most cells first; those on it are taken out of the group.
  void find_in(std::vector<Vec2> points, std::vector<DoorSpan>& doors) const {
    while (const auto best = best_stretch(points)) {
      const Vec2 middle = (best->ends.a + best->ends.b) / 2;
      if (std::none_of(doors.begin(), doors.end(), [&](const DoorSpan& d) {
            return ((d.a + d.b) / 2 - middle).norm() < options_.least_width / 2;
          }))
        doors.push_back(best->ends);
      const std::size_t before = points.size();
      std::erase_if(points, [&](const Vec2& p) { return on(best->ends, p); });
      if (points.size() == before) return;
    }
  }

 private:
  std::optional<Stretch> best_stretch(const std::vector<Vec2>& points) const {
    std::optional<Stretch> best;
    const std::size_t step = 1 + points.size() / kMostTried;
    for (std::size_t i = 0; i < points.size(); i += step)
      for (std::size_t k = i + step; k < points.size(); k += step) {
        if ((points[k] - points[i]).norm() < options_.least_width / 2) continue;
        const auto s = stretch(points, points[i], (points[k] - points[i]).normalized());
        if (s && (!best || s->cells > best->cells)) best = s;
      }
    return best;
  }

  bool on(const DoorSpan& door, const Vec2& p) const {
    const Vec2 along = (door.b - door.a).normalized();
    const double t = (p - door.a).dot(along);
    return std::abs(cross(along, p - door.a)) <= options_.tolerance && t >= -2 * cell_ &&
           t <= (door.b - door.a).norm() + 2 * cell_;
  }

  /// Around `through`, as far as cells follow each other on the line.
  std::optional<Stretch> stretch(const std::vector<Vec2>& points, const Vec2& through,
                                 const Vec2& along) const {
    std::vector<double> at;
    for (const Vec2& p : points)
      if (std::abs(cross(along, p - through)) <= options_.tolerance / 2)
        at.push_back((p - through).dot(along));
    std::sort(at.begin(), at.end());
    auto first = std::lower_bound(at.begin(), at.end(), -1e-9), last = first;
    if (first == at.end()) return std::nullopt;
    while (first != at.begin() && *first - *(first - 1) < kLongestGap) --first;
    while (last + 1 != at.end() && *(last + 1) - *last < kLongestGap) ++last;
    const auto cells = static_cast<std::size_t>(last - first) + 1;
    if (static_cast<double>(cells) * cell_ < options_.filled * (*last - *first))
      return std::nullopt;
    const auto a = jamb(through + *first * along, -along), b = jamb(through + *last * along, along);
    if (!a || !b) return std::nullopt;
    const double width = (*b - *a).norm();
    if (width < options_.least_width || width > options_.most_width ||
        static_cast<double>(cells) * cell_ < options_.filled * width || !clear_sides(*a, *b))
      return std::nullopt;
    return Stretch{{*a, *b}, cells};
  }

  bool clear_sides(const Vec2& a, const Vec2& b) const {
    const Vec2 along = (b - a).normalized(), aside(-along.y(), along.x());
    int clear = 0, all = 0;
    for (double t = kShrunk; t < (b - a).norm() - kShrunk; t += cell_, ++all)
      clear += cells_.at(a + t * along + kAround * aside) == Seen::floor &&
               cells_.at(a + t * along - kAround * aside) == Seen::floor;
    return clear >= options_.clear * all;
  }

  /// Where what stays begins, from a leaf's end outwards.
  std::optional<Vec2> jamb(const Vec2& end, const Vec2& outwards) const {
    const Vec2 aside(-outwards.y(), outwards.x());
    for (double t = -cell_; t <= options_.jamb_reach; t += cell_ / 2)
      for (const double s : {0.0, 1.0, -1.0}) {
        if (cells_.at(end + t * outwards + s * options_.tolerance * aside) == Seen::wall)
          return end + t * outwards;
      }
    return std::nullopt;
  }

  const Cells& cells_;
  DoorOptions options_;
  double cell_;
};

struct Told {
  int passed = 0, stopped = 0;
};

/// What the beams of a scan say about a doorway.
Told look_at(const DoorSpan& door, const Scan& scan, const Pose2& T_map_laser,
             const DoorOptions& options) {
  Told told;
  const Vec2 origin = T_map_laser.translation(), leaf = door.b - door.a;
  const double width = leaf.norm();
  const Vec2 along = leaf / width;
  const double aside = cross(along, origin - door.a);
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const auto range = static_cast<double>(scan.ranges[i]);
    if (!std::isfinite(range) || range < 0) continue;
    const double angle = T_map_laser.theta + scan.angle(i);
    const Vec2 beam(std::cos(angle), std::sin(angle));
    const double slope = cross(along, beam);
    if (std::abs(slope) < options.least_incidence) continue;
    const double crossing = -aside / slope;
    if (crossing <= 0) continue;
    // Before and behind the leaf it must be clear of the jambs, else a jamb may have stopped it.
    const double at = (origin + crossing * beam - door.a).dot(along);
    const double spread = options.tolerance * std::abs(beam.dot(along) / slope);
    if (at - spread < kShrunk || at + spread > width - kShrunk) continue;
    const double beyond = (range - crossing) * std::abs(slope);
    told.stopped += std::abs(beyond) <= options.tolerance;
    told.passed += beyond > options.tolerance;
  }
  return told;
}

}  // namespace

void describe(OptionFields& fields, DoorOptions& o) {
  fields.add("doors.least_width", o.least_width, {"m", "narrower ones are none", 0.1, 10});
  fields.add("doors.most_width", o.most_width, {"m", "wider ones are none", 0.1, 10});
  fields.add("doors.tolerance", o.tolerance, {"m", "so near to the leaf's line is on it", 0.01, 1});
  fields.add("doors.jamb_reach", o.jamb_reach,
             {"m", "something that stays is so near to either end", 0, 2});
  fields.add("doors.stay", o.stay, {"s", "each state was seen for so long", 0, 1e6});
  fields.add("doors.clear", o.clear, {"1", "share of the leaf with floor on both sides", 0, 1});
  fields.add("doors.filled", o.filled, {"1", "share of the leaf that its cells cover", 0, 1});
  fields.add("doors.change_time", o.change_time, {"s", "between changes of a door", 0.1, 1e9});
  fields.add("doors.pass_open", o.pass_open, {"1", "beams go on, door open", 0.01, 0.99});
  fields.add("doors.pass_closed", o.pass_closed, {"1", "beams go on, door closed", 0.01, 0.99});
  fields.add("doors.beam_weight", o.beam_weight, {"1", "of an independent beam", 0.01, 1});
  fields.add("doors.scan_limit", o.scan_limit, {"nat", "the most that a scan tells", 0.01, 100});
  fields.add("doors.log_odds_limit", o.log_odds_limit,
             {"1", "belief stays within +- this", 0.1, 20});
  fields.add("doors.sure", o.sure, {"1", "belief from which on a state is stated", 0.5, 0.999});
  fields.add("doors.least_beams", o.least_beams, {"1", "a door in sight takes so many", 1, 1000});
  fields.add("doors.least_incidence", o.least_incidence,
             {"1", "sine; beams that meet the leaf flatter tell nothing", 0, 1});
}

std::vector<DoorSpan> find_doors(const DynamicsMap& dynamics, const DoorOptions& options) {
  std::vector<DoorSpan> doors;
  const Cells cells(dynamics, options.stay);
  const DoorFinder finder(cells, options);
  const double cell = dynamics.resolution();
  for (const auto& group : groups(cells.changed())) {
    if (static_cast<double>(group.size()) * cell < options.filled * options.least_width ||
        group.size() > kMostCells)
      continue;
    std::vector<Vec2> points;
    for (const Cell& c : group) points.emplace_back((c.x + 0.5) * cell, (c.y + 0.5) * cell);
    finder.find_in(std::move(points), doors);
  }
  return doors;
}

DoorWatch::DoorWatch(std::vector<DoorSpan> doors, const DoorOptions& options) : options_(options) {
  for (const DoorSpan& door : doors) doors_.push_back({door, 0, false});
}

void DoorWatch::add(const PosedScan& posed) {
  const Pose2& pose = posed.estimate.T_map_robot;
  const double dt = begun_ ? std::max(0.0, to_seconds(posed.scan.time - last_)) : 0;
  begun_ = true;
  last_ = posed.scan.time;
  const double kept = std::exp(-2 * dt / options_.change_time);
  const double beam = options_.beam_weight, limit = options_.scan_limit;
  const double on_pass = beam * std::log(options_.pass_open / options_.pass_closed);
  const double on_stop = beam * std::log((1 - options_.pass_open) / (1 - options_.pass_closed));
  const bool tells = posed.estimate.health != Health::lost && pose.finite();
  for (Watched& door : doors_) {
    const double p = 0.5 + kept * (1 / (1 + std::exp(-door.log_odds)) - 0.5);
    double l = std::log(p / (1 - p));
    const Told told =
        tells ? look_at(door.where, posed.scan, pose * posed.scan.T_robot_laser, options_) : Told{};
    door.in_sight = told.passed + told.stopped >= options_.least_beams;
    l += std::clamp(told.passed * on_pass + told.stopped * on_stop, -limit, limit);
    door.log_odds = std::clamp(l, -options_.log_odds_limit, options_.log_odds_limit);
  }
}

double DoorWatch::open_chance(std::size_t i) const {
  return 1 / (1 + std::exp(-doors_[i].log_odds));
}

DoorState DoorWatch::state(std::size_t i) const {
  const double p = open_chance(i);
  return p >= options_.sure       ? DoorState::open
         : p <= 1 - options_.sure ? DoorState::closed
                                  : DoorState::unknown;
}

std::vector<DoorHistory> door_histories(const Site& site, const std::vector<DoorSpan>& doors,
                                        const DoorOptions& options) {
  std::vector<DoorHistory> histories;
  for (const DoorSpan& door : doors) histories.push_back({door, {}});
  DoorWatch watch(doors, options);
  for (const PosedScan& scan : site.scans) {
    watch.add(scan);
    for (std::size_t i = 0; i < doors.size(); ++i) {
      auto& stays = histories[i].stays;
      if (stays.empty()) stays.push_back({scan.scan.time, DoorState::unknown, 0.5});
      const DoorState now = watch.state(i);
      if (now != DoorState::unknown && now != stays.back().state)
        stays.push_back({scan.scan.time, now, watch.open_chance(i)});
    }
  }
  return histories;
}

std::vector<DoorHistory> doors_that_moved(const Site& site, const DynamicsMap& dynamics,
                                          const DoorOptions& options) {
  auto histories = door_histories(site, find_doors(dynamics, options), options);
  // Unknown, one state, the other.
  std::erase_if(histories, [](const DoorHistory& h) { return h.stays.size() < 3; });
  return histories;
}

}  // namespace majak::map
