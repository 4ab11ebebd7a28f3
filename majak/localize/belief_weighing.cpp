// SPDX-License-Identifier: Apache-2.0
#include "majak/localize/belief_weighing.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

namespace majak::localize {
namespace {

using filter::PoseLattice;
constexpr int kBlock = 4;                // cells, side of a block
constexpr int kPerSlice = 4;             // blocks of a tile in one heading
constexpr std::size_t kReference = 100;  // blocks that tell what the best will be about
constexpr std::size_t kChunk = 2048;     // blocks bounded at a time

// Far enough around that a bound outside is that of nowhere near a wall.
map::KnownMap padded(const map::KnownMap& map) {
  constexpr double kMargin = 2;  // m
  const int n = static_cast<int>(std::ceil(kMargin / map.resolution));
  map::KnownMap wide = map;
  wide.x0 -= n * map.resolution, wide.y0 -= n * map.resolution;
  wide.width += 2 * n, wide.height += 2 * n;
  wide.cells.assign(static_cast<std::size_t>(wide.width) * static_cast<std::size_t>(wide.height),
                    map::CellState::unknown);
  for (int iy = 0; iy < map.height; ++iy)
    std::copy_n(map.cells.begin() + static_cast<std::ptrdiff_t>(map.index(0, iy)), map.width,
                wide.cells.begin() + static_cast<std::ptrdiff_t>(wide.index(n, iy + n)));
  return wide;
}

// From the middle of a block to those of its cells, and from a return to the middle of its cell of
// the map, for both.
match::LikelihoodField bounds(const Place& place, const PoseLattice& lattice) {
  const map::KnownMap wide = padded(place.known);
  match::LikelihoodFieldOptions options = place.likelihood.options();
  options.slack =
      std::sqrt(0.5) * (kBlock - 1) * lattice.cell + std::sqrt(2.0) * place.known.resolution;
  return {wide, map::DistanceField(wide), options};
}

// Cell (0, 0) of a block in its slice.
std::size_t first_cell(int quarter) {
  return static_cast<std::size_t>(quarter / 2 * kBlock * PoseLattice::kSide + quarter % 2 * kBlock);
}

template <class Do>
void each_cell(int quarter, const Do& act) {
  for (std::size_t row = 0; row < kBlock; ++row)
    for (std::size_t column = 0; column < kBlock; ++column)
      act(first_cell(quarter) + row * PoseLattice::kSide + column);
}

}  // namespace

struct BeliefWeighing::Block {
  std::uint32_t tile;
  std::uint16_t heading;
  std::uint8_t quarter;
  float prior;             // of its likeliest cell
  std::uint32_t cost = 0;  // no cell of it has less
  float bound = 0;         // log of what its likeliest cell comes to at most

  bool before(const Block& o) const {
    return std::tie(tile, heading, quarter) < std::tie(o.tile, o.heading, o.quarter);
  }
};

BeliefWeighing::BeliefWeighing(PlacePtr place, std::shared_ptr<const PoseLattice> lattice,
                               double effective)
    : place_(std::move(place)),
      lattice_(std::move(lattice)),
      effective_(effective),
      coarse_(bounds(*place_, *lattice_)) {
  for (int h = 0; h < lattice_->headings; ++h) {
    cos_.push_back(static_cast<float>(std::cos(lattice_->heading(h))));
    sin_.push_back(static_cast<float>(std::sin(lattice_->heading(h))));
  }
}

void BeliefWeighing::place(match::PoseArrays& poses, std::size_t i, const Vec2& at,
                           int heading) const {
  poses.x[i] = static_cast<float>(at.x()), poses.y[i] = static_cast<float>(at.y());
  poses.cos[i] = cos_[static_cast<std::size_t>(heading)];
  poses.sin[i] = sin_[static_cast<std::size_t>(heading)];
}

// Tile by tile, so that they stand in order.
std::vector<BeliefWeighing::Block> BeliefWeighing::blocks_that_matter(
    const filter::PoseHistogram& belief, const std::vector<std::size_t>& held, double least,
    Threads threads) const {
  std::vector<float> largest(held.size());
  parallel_for(threads, held.size(), [&](std::size_t t) {
    const std::vector<float>& p = belief.tile(held[t]);
    largest[t] = *std::max_element(p.begin(), p.end());
  });
  const float limit =
      held.empty() ? 0
                   : static_cast<float>(least) * *std::max_element(largest.begin(), largest.end());
  std::vector<std::vector<Block>> of_tile(held.size());
  parallel_for(threads, held.size(), [&](std::size_t t) {
    if (largest[t] < limit) return;
    const std::vector<float>& p = belief.tile(held[t]);
    for (int h = 0; h < lattice_->headings; ++h)
      for (int q = 0; q < kPerSlice; ++q) {
        const float* slice = p.data() + static_cast<std::size_t>(h) * PoseLattice::kSlice;
        float most = 0;
        each_cell(q, [&](std::size_t c) { most = std::max(most, slice[c]); });
        if (most > 0 && most >= limit)
          of_tile[t].push_back({static_cast<std::uint32_t>(t), static_cast<std::uint16_t>(h),
                                static_cast<std::uint8_t>(q), most});
      }
  });
  std::vector<Block> blocks;
  for (const auto& some : of_tile) blocks.insert(blocks.end(), some.begin(), some.end());
  return blocks;
}

// No cell of a block has less cost than its middle where each return is forgiven the way there.
void BeliefWeighing::bound(std::vector<Block>& blocks, const std::vector<std::size_t>& held,
                           const match::Beams& beams, double nat, Threads threads) const {
  constexpr double kMiddle = (kBlock - 1) / 2.0;
  parallel_for(threads, (blocks.size() + kChunk - 1) / kChunk, [&](std::size_t chunk) {
    const std::size_t begin = chunk * kChunk, n = std::min(kChunk, blocks.size() - begin);
    match::PoseArrays poses;
    poses.resize(n);
    std::vector<std::uint32_t> costs(n);
    for (std::size_t i = 0; i < n; ++i) {
      const Block& b = blocks[begin + i];
      const Vec2 middle(b.quarter % 2 * kBlock + kMiddle, b.quarter / 2 * kBlock + kMiddle);
      place(poses, i, lattice_->corner(held[b.tile]) + lattice_->cell * middle, b.heading);
    }
    coarse_.costs(beams, poses, 0, n, costs.data());
    for (std::size_t i = 0; i < n; ++i) {
      Block& b = blocks[begin + i];
      b.cost = costs[i];
      b.bound = static_cast<float>(std::log(b.prior) - nat * b.cost);
    }
  });
}

// Blocks of one tile, cell by cell.
BeliefWeighing::Cells BeliefWeighing::look_at(const std::vector<float>& belief, std::size_t tile,
                                              const std::vector<Block>& blocks,
                                              const match::Beams& beams) const {
  Cells cells;
  for (const Block& b : blocks)
    each_cell(b.quarter, [&](std::size_t c) {
      const std::size_t at = b.heading * PoseLattice::kSlice + c;
      if (belief[at] > 0) cells.at.push_back(at);
    });
  match::PoseArrays poses;
  poses.resize(cells.at.size());
  cells.cost.resize(cells.at.size());
  for (std::size_t i = 0; i < cells.at.size(); ++i) {
    const std::size_t c = cells.at[i] % PoseLattice::kSlice;
    place(poses, i,
          lattice_->corner(tile) +
              lattice_->cell * Vec2(c % PoseLattice::kSide, c / PoseLattice::kSide),
          static_cast<int>(cells.at[i] / PoseLattice::kSlice));
  }
  place_->likelihood.costs(beams, poses, 0, poses.size(), cells.cost.data());
  return cells;
}

// What the best comes to about: the best cell of the most promising blocks.
BeliefWeighing::Best BeliefWeighing::best_of(const filter::PoseHistogram& belief,
                                             const std::vector<std::size_t>& held,
                                             std::vector<Block> blocks, const match::Beams& beams,
                                             double nat) const {
  const std::size_t few = std::min(kReference, blocks.size());
  std::partial_sort(blocks.begin(), blocks.begin() + static_cast<std::ptrdiff_t>(few), blocks.end(),
                    [](const Block& a, const Block& b) {
                      return a.bound != b.bound ? a.bound > b.bound : a.before(b);
                    });
  Best best;
  for (std::size_t i = 0; i < few; ++i) {
    const std::size_t tile = held[blocks[i].tile];
    const Cells cells = look_at(belief.tile(tile), tile, {blocks[i]}, beams);
    for (std::size_t k = 0; k < cells.at.size(); ++k) {
      const double log_p = std::log(belief.tile(tile)[cells.at[k]]) - nat * cells.cost[k];
      if (log_p > best.log_p) best = {log_p, cells.cost[k]};
    }
  }
  return best;
}

Weighed BeliefWeighing::weigh(filter::PoseHistogram& belief, const match::Beams& beams,
                              const Look& look, Threads threads) const {
  const std::vector<std::size_t> held = belief.held();
  std::vector<Block> blocks = blocks_that_matter(belief, held, look.least, threads);
  if (blocks.empty() || beams.returns == 0) return {};
  const double nat = effective_ * match::LikelihoodField::kUnit /
                     static_cast<double>(beams.returns);  // of a unit of cost
  bound(blocks, held, beams, nat, threads);
  const Best best = best_of(belief, held, blocks, beams, nat);
  const double limit = best.log_p + std::log(look.share);
  const auto likelihood = [&](std::uint32_t cost) {  // against that of the best
    return static_cast<float>(
        std::exp(nat * (static_cast<double>(best.cost) - static_cast<double>(cost))));
  };
  Weighed done;
  done.best = nat * best.cost / effective_;
  done.elsewhere = std::exp(effective_ * (done.best - look.elsewhere));
  if (look.least == 0) done.elsewhere = std::min(done.elsewhere, 1.0);  // all is looked at
  done.blocks = blocks.size();
  std::vector<std::size_t> first(held.size() + 1), looked_at(held.size());  // of each tile
  for (const Block& b : blocks) ++first[b.tile + 1];
  for (std::size_t t = 0; t < held.size(); ++t) first[t + 1] += first[t];
  parallel_for(threads, held.size(), [&](std::size_t t) {
    std::vector<float>& p = belief.tile(held[t]);
    std::vector<float> times(p.size(), static_cast<float>(done.elsewhere));
    std::vector<Block> fine;
    for (std::size_t i = first[t]; i < first[t + 1]; ++i) {
      const Block& b = blocks[i];
      const float most = likelihood(b.cost);
      each_cell(b.quarter,
                [&](std::size_t c) { times[b.heading * PoseLattice::kSlice + c] = most; });
      if (b.bound >= limit) fine.push_back(b);
    }
    const Cells cells = look_at(p, held[t], fine, beams);
    for (std::size_t k = 0; k < cells.at.size(); ++k)
      times[cells.at[k]] = likelihood(cells.cost[k]);
    looked_at[t] = cells.at.size();
    for (std::size_t c = 0; c < p.size(); ++c) p[c] *= times[c];
  });
  for (const std::size_t n : looked_at) done.cells += n;
  return done;
}

}  // namespace majak::localize
