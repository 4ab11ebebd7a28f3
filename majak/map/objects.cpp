// SPDX-License-Identifier: Apache-2.0
#include "majak/map/objects.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>

#include "majak/core/option_range.hpp"
#include "majak/map/exclusive_assignment.hpp"

namespace majak::map {
namespace {

constexpr double kLeastWeight = 0.01;  // of a sighting that shapes an object
constexpr double kConverged = 0.1;     // nats
constexpr double kLikely = 0.5;

/// What is believed: which pieces there are, how the objects look, which shows which.
struct Belief {
  std::vector<Piece> pieces;  ///< in the order of snapshots
  std::vector<ObjectShape> shapes;
  std::vector<std::vector<ShapeFit>> fits;  ///< [object][piece]
  std::vector<std::vector<double>> chance;  ///< [piece][object]
  double score = 0;
};

template <class T>
void erase_at(std::vector<T>& list, std::size_t i) {
  list.erase(list.begin() + static_cast<std::ptrdiff_t>(i));
}

void remove_object(Belief& b, std::size_t n) {
  erase_at(b.shapes, n);
  erase_at(b.fits, n);
}

double gap_between(const Piece& a, const Piece& b) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Vec2& p : a.points)
    for (const Vec2& q : b.points) nearest = std::min(nearest, (p - q).squaredNorm());
  return std::sqrt(nearest);
}

/// The search for the belief of the greatest score: EM for given objects, and moves that join
/// pieces, add an object or take one away.
class Search {
 public:
  Search(std::span<const KnownMap> snapshots, const ObjectOptions& options, Threads threads)
      : options_(options), threads_(threads) {
    for (const KnownMap& snapshot : snapshots) clear_.push_back(clear_floor(snapshot));
  }

  /// Starts from the fullest snapshot. Shapes of one piece mislead about places; once they are
  /// whole the places are searched anew.
  Belief run(std::vector<Piece> pieces) const {
    Belief best = settled(first(std::move(pieces)));
    search_anew(best);
    best = settled(std::move(best));
    while (join(best) || grow(best) || shrink(best)) {
    }
    search_anew(best);
    return settled(std::move(best));
  }

  /// Which of these objects the pieces are.
  Belief named(std::vector<Piece> pieces, const std::vector<ObjectShape>& shapes) const {
    Belief b;
    b.pieces = std::move(pieces);
    for (const ObjectShape& shape : shapes) append(b, shape);
    expect(b);
    while (join(b, true)) {
    }
    return b;
  }

 private:
  SeenPiece seen(const Piece& piece) const { return {&piece, &clear_[piece.snapshot]}; }

  double none(const Piece& piece) const {
    return options_.shape.point_weight * static_cast<double>(piece.points.size()) *
           std::log(options_.none);
  }

  std::size_t most() const { return static_cast<std::size_t>(options_.most_objects); }

  ObjectShape shape_of(const Piece& piece) const {
    Vec2 middle = Vec2::Zero();
    for (const Vec2& p : piece.points) middle += p;
    middle /= static_cast<double>(piece.points.size());
    const ObjectShape::Sighting alone{seen(piece), {middle.x(), middle.y(), 0}, 1};
    return {std::span(&alone, 1), alone.seen.clear->resolution, options_.shape};
  }

  Belief first(std::vector<Piece> pieces) const {
    std::vector<std::size_t> count(clear_.size());
    for (const Piece& p : pieces) ++count[p.snapshot];
    const auto fullest =
        static_cast<std::size_t>(std::max_element(count.begin(), count.end()) - count.begin());
    Belief b;
    b.pieces = std::move(pieces);
    for (const Piece& p : b.pieces)
      if (p.snapshot == fullest && b.shapes.size() < most()) append(b, shape_of(p));
    expect(b);
    return b;
  }

  void append(Belief& b, ObjectShape shape) const {
    b.shapes.push_back(std::move(shape));
    b.fits.emplace_back(b.pieces.size());
    auto& fits = b.fits.back();
    parallel_for(threads_, b.pieces.size(), [&](std::size_t k) {
      fits[k] = best_fit(b.shapes.back(), seen(b.pieces[k]), options_.shape);
    });
  }

  /// E step (MATH 21.5), snapshot by snapshot.
  void expect(Belief& b) const {
    b.chance.assign(b.pieces.size(), {});
    b.score = -options_.cost * static_cast<double>(b.shapes.size());
    for (std::size_t first = 0, last = 0; first < b.pieces.size(); first = last) {
      std::vector<std::vector<double>> likelihood;
      std::vector<double> log_none;
      for (; last < b.pieces.size() && b.pieces[last].snapshot == b.pieces[first].snapshot;
           ++last) {
        log_none.push_back(none(b.pieces[last]));
        likelihood.emplace_back();
        for (const auto& fits : b.fits) likelihood.back().push_back(fits[last].log_likelihood);
      }
      const auto belief = exclusive_assignment(likelihood, log_none);
      b.score += belief.log_sum;
      for (std::size_t k = first; k < last; ++k) b.chance[k] = belief.chance[k - first];
    }
  }

  /// M step (MATH 21.2): shapes from their sightings; then each piece looks for its place again.
  void reshape(Belief& b) const {
    for (std::size_t n = 0; n < b.shapes.size(); ++n) {
      std::vector<ObjectShape::Sighting> sightings;
      for (std::size_t k = 0; k < b.pieces.size(); ++k)
        if (b.chance[k][n] > kLeastWeight)
          sightings.push_back({seen(b.pieces[k]), b.fits[n][k].T_map_object, b.chance[k][n]});
      b.shapes[n] = {sightings, b.shapes[n].resolution(), options_.shape};
    }
    const std::size_t pieces = b.pieces.size();
    parallel_for(threads_, b.shapes.size() * pieces, [&](std::size_t i) {
      ShapeFit& fit = b.fits[i / pieces][i % pieces];
      fit = refined_fit(b.shapes[i / pieces], seen(b.pieces[i % pieces]), fit.T_map_object,
                        options_.shape);
    });
  }

  void search_anew(Belief& b) const {
    const std::vector<ObjectShape> shapes = std::move(b.shapes);
    b.shapes.clear();
    b.fits.clear();
    for (const ObjectShape& shape : shapes) append(b, shape);
    expect(b);
  }

  /// EM until nothing changes.
  Belief settled(Belief b) const {
    double before = b.score - 1;
    for (int i = 0; i < options_.iterations && std::abs(b.score - before) > kConverged; ++i) {
      before = b.score;
      reshape(b);
      expect(b);
    }
    return b;
  }

  /// The object that the piece most likely is; the number of objects when none is likely.
  static std::size_t likely(const Belief& b, std::size_t k) {
    for (std::size_t n = 0; n < b.shapes.size(); ++n)
      if (b.chance[k][n] > kLikely) return n;
    return b.shapes.size();
  }

  double explained(const Belief& b, std::size_t k) const {
    const std::size_t n = likely(b, k);
    return n < b.shapes.size() ? b.fits[n][k].log_likelihood : none(b.pieces[k]);
  }

  static bool seen_elsewhere(const Belief& b, std::size_t n, std::size_t i, std::size_t j) {
    for (std::size_t k = 0; k < b.pieces.size(); ++k)
      if (k != i && k != j && b.chance[k][n] > kLikely) return true;
    return false;
  }

  /// Two pieces of a snapshot that together are one object, which something before it has cut.
  bool join(Belief& best, bool shapes_stay = false) const {
    for (std::size_t i = 0; i < best.pieces.size(); ++i)
      for (std::size_t j = i + 1;
           j < best.pieces.size() && best.pieces[j].snapshot == best.pieces[i].snapshot; ++j)
        if (gap_between(best.pieces[i], best.pieces[j]) < options_.join &&
            join_two(best, i, j, shapes_stay))
          return true;
    return false;
  }

  bool join_two(Belief& best, std::size_t i, std::size_t j, bool shapes_stay) const {
    Belief joined = best;
    std::vector<Vec2>& points = joined.pieces[i].points;
    points.insert(points.end(), best.pieces[j].points.begin(), best.pieces[j].points.end());
    erase_at(joined.pieces, j);
    double whole = -std::numeric_limits<double>::infinity();
    for (std::size_t n = 0; n < joined.shapes.size(); ++n) {
      erase_at(joined.fits[n], j);
      joined.fits[n][i] = best_fit(joined.shapes[n], seen(joined.pieces[i]), options_.shape);
      whole = std::max(whole, joined.fits[n][i].log_likelihood);
    }
    // An object that only the parts have shown goes with them.
    double spared = 0;
    for (std::size_t n = joined.shapes.size(); !shapes_stay && n-- > 0;) {
      if ((likely(best, i) != n && likely(best, j) != n) || seen_elsewhere(best, n, i, j)) continue;
      if (joined.fits[n][i].log_likelihood == whole) continue;
      remove_object(joined, n);
      spared += options_.cost;
    }
    if (whole + spared <= explained(best, i) + explained(best, j)) return false;
    expect(joined);
    if (!shapes_stay) joined = settled(std::move(joined));
    if (joined.score <= best.score + kConverged) return false;
    best = std::move(joined);
    return true;
  }

  /// One more object, from the pieces that are explained worst.
  bool grow(Belief& best) const {
    constexpr std::size_t kTried = 3;
    if (best.shapes.size() >= most()) return false;
    std::vector<std::pair<double, std::size_t>> worst;
    for (std::size_t k = 0; k < best.pieces.size(); ++k) worst.emplace_back(explained(best, k), k);
    std::stable_sort(worst.begin(), worst.end());
    for (std::size_t i = 0; i < std::min(kTried, worst.size()); ++i) {
      Belief more = best;
      append(more, shape_of(best.pieces[worst[i].second]));
      expect(more);
      more = settled(std::move(more));
      if (more.score <= best.score + kConverged) continue;
      best = std::move(more);
      return true;
    }
    return false;
  }

  /// One object less. What showed it may be parts of others.
  bool shrink(Belief& best) const {
    for (std::size_t n = 0; n < best.shapes.size(); ++n) {
      Belief less = best;
      remove_object(less, n);
      expect(less);
      while (join(less, true)) {
      }
      less = settled(std::move(less));
      if (less.score <= best.score + kConverged) continue;
      best = std::move(less);
      return true;
    }
    return false;
  }

  std::vector<KnownMap> clear_;  ///< by snapshot
  ObjectOptions options_;
  Threads threads_;
};

std::vector<ObjectSighting> sightings_of(const Belief& b) {
  std::vector<ObjectSighting> sightings;
  for (std::size_t k = 0; k < b.chance.size(); ++k)
    for (std::size_t n = 0; n < b.shapes.size(); ++n)
      if (b.chance[k][n] > kLikely)
        sightings.push_back({k, n, b.fits[n][k].T_map_object, b.chance[k][n]});
  return sightings;
}

/// In the order they were; returns how many are gone.
std::size_t keep_largest(std::vector<Piece>& pieces, std::size_t most) {
  if (pieces.size() <= most) return 0;
  std::vector<std::size_t> sizes;
  for (const Piece& p : pieces) sizes.push_back(p.points.size());
  std::nth_element(sizes.begin(), sizes.begin() + static_cast<std::ptrdiff_t>(most), sizes.end(),
                   std::greater<>());
  const std::size_t before = pieces.size(), too_small = sizes[most];
  std::erase_if(pieces, [&](const Piece& p) { return p.points.size() <= too_small; });
  return before - pieces.size();
}

void most_seen_first(ObjectMap& map) {
  std::vector<std::size_t> count(map.objects.size()), order(count.size()), place(count.size());
  for (const ObjectSighting& s : map.sightings) ++count[s.object];
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return count[a] > count[b]; });
  std::vector<ObjectShape> objects;
  for (std::size_t i = 0; i < order.size(); ++i) {
    objects.push_back(std::move(map.objects[order[i]]));
    place[order[i]] = i;
  }
  map.objects = std::move(objects);
  for (ObjectSighting& s : map.sightings) s.object = place[s.object];
}

}  // namespace

void describe(OptionFields& fields, ObjectOptions& o) {
  describe(fields, o.pieces);
  describe(fields, o.shape);
  fields.add("objects.cost", o.cost, {"nat", "that an object must explain to be one", 0, 1e6});
  fields.add("objects.none", o.none, {"1", "chance of a cell of no object", 1e-6, 1});
  fields.add("objects.join", o.join, {"m", "parts of one object may be so far apart", 0, 10});
  fields.add("objects.most_objects", o.most_objects, {"1", "objects at most", 1, 16});
  fields.add("objects.most_pieces", o.most_pieces, {"1", "pieces at most", 1, 10000});
  fields.add("objects.iterations", o.iterations, {"1", "of EM, at most", 1, 1000});
}

ObjectMap find_objects(std::span<const KnownMap> snapshots, const ObjectOptions& options,
                       Threads threads) {
  require_in_range(options);
  ObjectMap map{still_map(snapshots), {}, {}, {}, 0, 0};
  for (std::size_t t = 0; t < snapshots.size(); ++t)
    for (Piece& piece : pieces_of(map.still, snapshots[t], t, options.pieces))
      map.pieces.push_back(std::move(piece));
  if (map.pieces.empty()) return map;
  map.left_out = keep_largest(map.pieces, static_cast<std::size_t>(options.most_pieces));
  Belief best = Search(snapshots, options, threads).run(std::move(map.pieces));
  map.sightings = sightings_of(best);
  map.pieces = std::move(best.pieces);
  map.objects = std::move(best.shapes);
  map.score = best.score;
  most_seen_first(map);
  return map;
}

Recognition recognize(const ObjectMap& objects, const KnownMap& snapshot,
                      const ObjectOptions& options, Threads threads) {
  require_in_range(options);
  const Search search(std::span(&snapshot, 1), options, threads);
  Belief b = search.named(pieces_of(objects.still, snapshot, 0, options.pieces), objects.objects);
  Recognition r{{}, sightings_of(b)};
  r.pieces = std::move(b.pieces);
  return r;
}

}  // namespace majak::map
