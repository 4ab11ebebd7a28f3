// SPDX-License-Identifier: Apache-2.0
#include "majak/map/objects.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "majak/core/error.hpp"
#include "majak/map/exclusive_assignment.hpp"

namespace majak::map {
namespace {

constexpr double kLeastWeight = 0.01;  // of a sighting that shapes an object
constexpr double kConverged = 0.1;     // nats
constexpr double kLikely = 0.5;

void check(ObjectOptions options) {
  OptionFields fields;
  describe(fields, options);
  for (const OptionField& field : fields.list) {
    const double value = std::holds_alternative<double*>(field.value)
                             ? *std::get<double*>(field.value)
                             : *std::get<int*>(field.value);
    if (!(value >= field.info.min && value <= field.info.max))
      throw Error("option " + field.name + " is out of its range");
  }
}

/// What is believed for a number of objects.
struct Belief {
  std::vector<ObjectShape> shapes;
  std::vector<std::vector<ShapeFit>> fits;  ///< [object][piece]
  std::vector<std::vector<double>> chance;  ///< [piece][object]
  double score = 0;
};

class Search {
 public:
  Search(std::vector<Piece> pieces, std::span<const KnownMap> snapshots,
         const ObjectOptions& options, Threads threads)
      : pieces_(std::move(pieces)), options_(options), threads_(threads) {
    for (const KnownMap& snapshot : snapshots) clear_.push_back(clear_floor(snapshot));
    for (const Piece& piece : pieces_) {
      seen_.push_back({&piece, &clear_[piece.snapshot]});
      none_.push_back(options.shape.point_weight * static_cast<double>(piece.points.size()) *
                      std::log(options.none));
    }
  }

  const std::vector<Piece>& pieces() const { return pieces_; }

  /// Starts from the fullest snapshot, then adds and takes away.
  Belief run() {
    Belief best = settled(first());
    while (grow(best) || shrink(best)) {
    }
    return best;
  }

  /// How sure each piece is to be which of these objects.
  Belief named(std::vector<ObjectShape> shapes) const {
    Belief b;
    for (ObjectShape& shape : shapes) append(b, std::move(shape));
    expect(b);
    return b;
  }

 private:
  ObjectShape shape_of_piece(std::size_t k) const {
    Vec2 middle = Vec2::Zero();
    for (const Vec2& p : pieces_[k].points) middle += p;
    middle /= static_cast<double>(pieces_[k].points.size());
    const ObjectShape::Sighting alone{seen_[k], {middle.x(), middle.y(), 0}, 1};
    return {std::span(&alone, 1), seen_[k].clear->resolution, options_.shape};
  }

  Belief first() const {
    std::vector<std::size_t> count;
    for (const Piece& p : pieces_) {
      count.resize(std::max(count.size(), p.snapshot + 1));
      ++count[p.snapshot];
    }
    Belief b;
    const auto fullest = static_cast<std::size_t>(
        std::max_element(count.begin(), count.end()) - count.begin());
    for (std::size_t k = 0; k < pieces_.size(); ++k)
      if (pieces_[k].snapshot == fullest && b.shapes.size() < most())
        append(b, shape_of_piece(k));
    expect(b);
    return b;
  }

  std::size_t most() const { return static_cast<std::size_t>(options_.most_objects); }

  void append(Belief& b, ObjectShape shape) const {
    b.shapes.push_back(std::move(shape));
    b.fits.emplace_back(pieces_.size());
    auto& fits = b.fits.back();
    parallel_for(threads_, pieces_.size(), [&](std::size_t k) {
      fits[k] = best_fit(b.shapes.back(), seen_[k], options_.shape);
    });
  }

  /// E step: (MATH 21.4), snapshot by snapshot.
  void expect(Belief& b) const {
    b.chance.assign(pieces_.size(), {});
    b.score = -options_.cost * static_cast<double>(b.shapes.size());
    for (std::size_t first = 0, last = 0; first < pieces_.size(); first = last) {
      while (last < pieces_.size() && pieces_[last].snapshot == pieces_[first].snapshot) ++last;
      std::vector<std::vector<double>> likelihood;
      for (std::size_t k = first; k < last; ++k) {
        likelihood.emplace_back();
        for (const auto& fits : b.fits) likelihood.back().push_back(fits[k].log_likelihood);
      }
      const auto belief = exclusive_assignment(
          likelihood, {none_.begin() + static_cast<std::ptrdiff_t>(first),
                       none_.begin() + static_cast<std::ptrdiff_t>(last)});
      b.score += belief.log_sum;
      for (std::size_t k = first; k < last; ++k) b.chance[k] = belief.chance[k - first];
    }
  }

  /// M step: shapes from their sightings; then each piece looks for its place again.
  void reshape(Belief& b) const {
    for (std::size_t n = 0; n < b.shapes.size(); ++n) {
      std::vector<ObjectShape::Sighting> sightings;
      for (std::size_t k = 0; k < pieces_.size(); ++k)
        if (b.chance[k][n] > kLeastWeight)
          sightings.push_back({seen_[k], b.fits[n][k].T_map_object, b.chance[k][n]});
      b.shapes[n] = {sightings, b.shapes[n].resolution(), options_.shape};
    }
    const std::size_t all = b.shapes.size() * pieces_.size();
    parallel_for(threads_, all, [&](std::size_t i) {
      const std::size_t n = i / pieces_.size(), k = i % pieces_.size();
      b.fits[n][k] =
          refined_fit(b.shapes[n], seen_[k], b.fits[n][k].T_map_object, options_.shape);
    });
  }

  void search_anew(Belief& b) const {
    std::vector<ObjectShape> shapes = std::move(b.shapes);
    b = {};
    for (ObjectShape& shape : shapes) append(b, std::move(shape));
    expect(b);
  }

  /// EM until nothing changes; once the shapes are whole the places are searched anew.
  Belief settled(Belief b) const {
    for (const bool again : {true, false}) {
      double before = b.score - 1;
      for (int i = 0; i < options_.iterations && std::abs(b.score - before) > kConverged; ++i) {
        before = b.score;
        reshape(b);
        expect(b);
      }
      if (again) search_anew(b);
    }
    return b;
  }

  /// One more object, from the pieces that are explained worst.
  bool grow(Belief& best) const {
    constexpr std::size_t kTried = 3;
    if (best.shapes.size() >= most()) return false;
    std::vector<std::pair<double, std::size_t>> worst;
    for (std::size_t k = 0; k < pieces_.size(); ++k) {
      double l = none_[k];
      for (std::size_t n = 0; n < best.shapes.size(); ++n)
        if (best.chance[k][n] > kLikely) l = best.fits[n][k].log_likelihood;
      worst.emplace_back(l, k);
    }
    std::stable_sort(worst.begin(), worst.end());
    for (std::size_t i = 0; i < std::min(kTried, worst.size()); ++i) {
      Belief more = best;
      append(more, shape_of_piece(worst[i].second));
      expect(more);
      more = settled(std::move(more));
      if (more.score <= best.score + kConverged) continue;
      best = std::move(more);
      return true;
    }
    return false;
  }

  bool shrink(Belief& best) const {
    for (std::size_t n = 0; n < best.shapes.size(); ++n) {
      Belief less = best;
      less.shapes.erase(less.shapes.begin() + static_cast<std::ptrdiff_t>(n));
      less.fits.erase(less.fits.begin() + static_cast<std::ptrdiff_t>(n));
      expect(less);
      less = settled(std::move(less));
      if (less.score <= best.score + kConverged) continue;
      best = std::move(less);
      return true;
    }
    return false;
  }

  std::vector<Piece> pieces_;
  std::vector<KnownMap> clear_;  ///< by snapshot
  std::vector<SeenPiece> seen_;
  std::vector<double> none_;
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
  fields.add("objects.most_objects", o.most_objects, {"1", "objects at most", 1, 16});
  fields.add("objects.iterations", o.iterations, {"1", "of EM, at most", 1, 1000});
}

ObjectMap find_objects(std::span<const KnownMap> snapshots, const ObjectOptions& options,
                       Threads threads) {
  check(options);
  ObjectMap map{still_map(snapshots), {}, {}, {}, 0};
  for (std::size_t t = 0; t < snapshots.size(); ++t)
    for (Piece& piece : pieces_of(map.still, snapshots[t], t, options.pieces))
      map.pieces.push_back(std::move(piece));
  if (map.pieces.empty()) return map;
  Search search(map.pieces, snapshots, options, threads);
  Belief best = search.run();
  map.sightings = sightings_of(best);
  map.objects = std::move(best.shapes);
  map.score = best.score;
  most_seen_first(map);
  return map;
}

Recognition recognize(const ObjectMap& objects, const KnownMap& snapshot,
                      const ObjectOptions& options, Threads threads) {
  check(options);
  Recognition r{pieces_of(objects.still, snapshot, 0, options.pieces), {}};
  const Search search(r.pieces, std::span(&snapshot, 1), options, threads);
  r.sightings = sightings_of(search.named(objects.objects));
  return r;
}

}  // namespace majak::map
