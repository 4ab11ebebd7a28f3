// SPDX-License-Identifier: Apache-2.0
// Movable objects: nine visits to a furnished room, and a tenth in which one thing has moved.
//   run_objects [--seeds N] [--first SEED] [--absent SHARE] [--worse FACTOR] [--verbose]
//               [NAME=VALUE ...]
// FACTOR: of the errors of the poses. Prints how often four objects were found, how often the thing
// that moved was recognized, and the time (one thread).
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <map>
#include <string>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "majak/io/options_file.hpp"
#include "majak/map/objects.hpp"
#include "majak/sim/furnished_room.hpp"

namespace {

using namespace majak;

constexpr std::size_t kVisits = 9;
constexpr double kAtItsPlace = 0.2;  // m

struct Case {
  int seeds = 100, first = 1;
  double absent = 0.1;
  sim::VisitErrors errors;
  bool verbose = false;
  map::ObjectOptions objects;
};

struct Outcome {
  std::size_t objects = 0, pieces = 0, named = 0, wrong = 0;
  bool recognized = false, in_view = false;
  double off = 0;      // m
  double seconds = 0;  // finding objects
};

double cpu() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

map::KnownMap snapshot(const sim::Furnishing& furnishing, std::uint64_t seed,
                       const sim::VisitErrors& errors) {
  return map::known_map(map::build_occupancy_grid(sim::visit_room(furnishing, seed, errors)));
}

/// The movable that stands where the piece is: nearest to its middle.
std::size_t true_of(const map::Piece& piece, const sim::Furnishing& furnishing) {
  Vec2 middle = Vec2::Zero();
  for (const Vec2& p : piece.points) middle += p / static_cast<double>(piece.points.size());
  std::size_t best = sim::kMovables;
  double nearest = 0.8;
  for (std::size_t k = 0; k < sim::kMovables; ++k)
    if (furnishing[k] && (furnishing[k]->translation() - middle).norm() < nearest) {
      nearest = (furnishing[k]->translation() - middle).norm();
      best = k;
    }
  return best;
}

/// What an object that was found truly is: the movable most of its sightings show.
std::vector<std::size_t> names(const map::ObjectMap& found,
                               const std::vector<sim::Furnishing>& furnishings) {
  std::vector<std::map<std::size_t, int>> votes(found.objects.size());
  for (const auto& s : found.sightings) {
    const map::Piece& piece = found.pieces[s.piece];
    ++votes[s.object][true_of(piece, furnishings[piece.snapshot])];
  }
  std::vector<std::size_t> name;
  for (const auto& v : votes)
    name.push_back(v.empty()
                       ? sim::kMovables
                       : std::max_element(v.begin(), v.end(), [](const auto& a, const auto& b) {
                           return a.second < b.second;
                         })->first);
  return name;
}

/// Where the movable's own frame lies in the object's, from the first right sighting.
Pose2 frame_of(const map::ObjectMap& found, std::size_t object, std::size_t movable,
               const std::vector<sim::Furnishing>& furnishings) {
  for (const auto& s : found.sightings) {
    const map::Piece& piece = found.pieces[s.piece];
    const sim::Furnishing& f = furnishings[piece.snapshot];
    if (s.object == object && f[movable] && true_of(piece, f) == movable)
      return between(s.T_map_object, *f[movable]);
  }
  return {};
}

Outcome run(const Case& c, std::uint64_t seed) {
  std::vector<sim::Furnishing> furnishings;
  std::vector<map::KnownMap> snapshots;
  for (std::size_t t = 0; t < kVisits; ++t) {
    furnishings.push_back(sim::furnish(seed, t, c.absent));
    snapshots.push_back(snapshot(furnishings[t], 100 * seed + t, c.errors));
  }
  Outcome o;
  const double begin = cpu();
  const map::ObjectMap found = map::find_objects(snapshots, c.objects);
  o.seconds = cpu() - begin;
  o.objects = found.objects.size();
  o.pieces = found.pieces.size();
  const std::vector<std::size_t> name = names(found, furnishings);
  for (const auto& s : found.sightings) {
    const map::Piece& piece = found.pieces[s.piece];
    ++o.named;
    o.wrong += true_of(piece, furnishings[piece.snapshot]) != name[s.object];
  }

  const auto movable = static_cast<std::size_t>(RandomStream(seed, 99).below(sim::kMovables));
  const sim::Furnishing after = sim::moved_one(furnishings.back(), movable, seed);
  const map::Recognition seen =
      map::recognize(found, snapshot(after, 100 * seed + 50, c.errors), c.objects);
  for (const map::Piece& p : seen.pieces) o.in_view |= true_of(p, after) == movable;
  for (const auto& s : seen.sightings) {
    if (name[s.object] != movable) continue;
    const Pose2 T = s.T_map_object * frame_of(found, s.object, movable, furnishings);
    o.off = (T.translation() - after[movable]->translation()).norm();
    o.recognized = o.off < kAtItsPlace;
  }
  if (c.verbose) {
    fmt::print("seed {}: {} objects, {} pieces, {} named, {} wrong, {} {} ({:.2f} m) {:.2f} s\n",
               seed, o.objects, o.pieces, o.named, o.wrong, sim::movable_name(movable),
               o.recognized ? "recognized" : "missed", o.off, o.seconds);
    for (std::size_t k = 0; k < found.pieces.size(); ++k) {
      const map::Piece& p = found.pieces[k];
      const std::size_t truth = true_of(p, furnishings[p.snapshot]);
      std::string as = "none";
      for (const auto& s : found.sightings)
        if (s.piece == k) as = fmt::format("{} {:.2f}", s.object, s.probability);
      fmt::print("  visit {} {} cells: {} is {}\n", p.snapshot, p.points.size(),
                 truth < sim::kMovables ? sim::movable_name(truth) : "nothing", as);
    }
  }
  return o;
}

void print(const Case& c) {
  std::map<std::size_t, int> counts;
  std::size_t pieces = 0, named = 0, wrong = 0;
  int recognized = 0, in_view = 0;
  double seconds = 0, square = 0;
  for (int i = 0; i < c.seeds; ++i) {
    const Outcome o = run(c, static_cast<std::uint64_t>(c.first + i));
    ++counts[o.objects];
    pieces += o.pieces, named += o.named, wrong += o.wrong;
    recognized += o.recognized, in_view += o.in_view;
    seconds += o.seconds / c.seeds;
    if (o.recognized) square += o.off * o.off;
  }
  fmt::print("objects found:");
  for (const auto& [count, times] : counts) fmt::print("  {} in {}", count, times);
  fmt::print(" of {} seeds\n", c.seeds);
  fmt::print(
      "pieces: {}, named {:.1f} %, of these wrong {:.1f} %\n", pieces,
      100.0 * static_cast<double>(named) / static_cast<double>(pieces),
      100.0 * static_cast<double>(wrong) / static_cast<double>(std::max<std::size_t>(named, 1)));
  fmt::print("the moved thing: recognized in {} of {} (in view in {}), off {:.3f} m rms\n",
             recognized, c.seeds, in_view, std::sqrt(square / std::max(1, recognized)));
  fmt::print("CPU time of finding: {:.2f} s\n", seconds);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    Case c;
    OptionFields fields;
    describe(fields, c.objects);
    for (int i = 1; i < argc; ++i) {
      const std::string arg = argv[i];
      const auto value = [&] {
        if (i + 1 == argc) throw Error(arg + " needs a value");
        return std::stod(argv[++i]);
      };
      if (arg == "--seeds") {
        c.seeds = static_cast<int>(value());
      } else if (arg == "--first") {
        c.first = static_cast<int>(value());
      } else if (arg == "--absent") {
        c.absent = value();
      } else if (arg == "--worse") {
        const double worse = value();
        for (double* e :
             {&c.errors.offset, &c.errors.turn, &c.errors.scan_offset, &c.errors.scan_turn})
          *e *= worse;
      } else if (arg == "--verbose") {
        c.verbose = true;
      } else {
        io::apply_option(fields, arg);
      }
    }
    print(c);
  } catch (const std::exception& e) {
    fmt::print(stderr, "run_objects: {}\n", e.what());
    return 1;
  }
}
