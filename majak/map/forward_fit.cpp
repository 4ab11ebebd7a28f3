// SPDX-License-Identifier: Apache-2.0
// build_forward_grid: expectation maximization, docs/MATH.md 17.
#include <algorithm>
#include <cmath>
#include <limits>

#include "majak/core/option_range.hpp"
#include "majak/map/forward_beams.hpp"
#include "majak/map/forward_grid.hpp"
#include "majak/map/scan_choice.hpp"

namespace majak::map {
namespace {

/// To a multiple of 2^-20. Sums of such numbers are exact below 2^33, so that it does not matter
/// which thread adds what first.
double rounded(double probability) {
  constexpr double kLarge = 0x1.8p32;
  return (probability + kLarge) - kLarge;
}

struct ScanSums {
  double log_likelihood = 0, squares = 0, stopped = 0;
  double random = 0, none = 0;
  std::size_t beams = 0;
};

/// Steps in each cell that stopped a beam, and that let one pass.
struct Tally {
  std::vector<double> stops, passes;
  explicit Tally(std::size_t cells) : stops(cells), passes(cells) {}
};

}  // namespace

class ForwardFit {
 public:
  ForwardFit(const Site& site, const ForwardGridOptions& options, Threads threads)
      : site_(site), threads_{std::max(1, threads.count)} {
    require_in_range(options);
    grid_.options_ = options;
    grid_.cells_.resolution = options.resolution;
    grid_.cells_.set(0, options.prior_stop);
    grid_.model_ = {ForwardBeams::largest_sigma(options), options.random, options.none};
    chosen_ = scans_to_draw(
        site, {options.resolution, options.max_range, options.scan_spacing, options.scan_turn});
    grid_.scans_drawn_ = chosen_.size();
    make_tiles();
  }

  /// Cells with the same kind are alike from now on.
  void tie(const OccupancyGrid& log_odds) {
    constexpr float kAlike = 0.25F;
    constexpr int kMiddle = 128;  // log-odds are below 32
    kinds_.assign(grid_.cells_.stop.size(), 0);
    std::size_t cell = 1;
    for (const ForwardCells::Place& place : grid_.cells_.places)
      for (int y = 0; y < ForwardCells::kTileSize; ++y)
        for (int x = 0; x < ForwardCells::kTileSize; ++x, ++cell) {
          const int ix = place.tx * ForwardCells::kTileSize + x,
                    iy = place.ty * ForwardCells::kTileSize + y;
          if (log_odds.known(ix, iy))
            kinds_[cell] = static_cast<std::uint16_t>(
                kMiddle + 1 + std::lround(log_odds.log_odds(ix, iy) / kAlike));
        }
  }

  ForwardGrid run() {
    expect(true);
    maximize();
    for (int round = 1;; ++round) {
      expect(false);
      grid_.posterior_.push_back(log_posterior());
      if (round >= static_cast<int>(grid_.options_.rounds) || settled()) break;
      maximize();
    }
    keep_evidence();
    grid_.score_ = {total_.log_likelihood, total_.beams};
    return std::move(grid_);
  }

 private:
  void make_tiles() {
    constexpr std::size_t kBatch = 256;  // scans of which tiles are kept at a time
    std::vector<std::vector<ForwardCells::Place>> tiles(kBatch);
    for (std::size_t first = 0; first < chosen_.size(); first += kBatch) {
      const std::size_t count = std::min(kBatch, chosen_.size() - first);
      parallel_for(threads_, count,
                   [&](std::size_t i) { tiles_of(site_.scans[chosen_[first + i]], tiles[i]); });
      for (std::size_t i = 0; i < count; ++i)
        for (const auto& place : tiles[i]) grid_.cells_.add_tile(place.tx, place.ty);
    }
    grid_.evidence_.assign(grid_.cells_.stop.size(), 0);
    tallies_.assign(static_cast<std::size_t>(threads_.count), Tally(grid_.cells_.stop.size()));
    sums_.resize(chosen_.size());
  }

  void tiles_of(const PosedScan& scan, std::vector<ForwardCells::Place>& tiles) const {
    tiles.clear();
    ForwardBeams beams(grid_.cells_, grid_.options_);
    beams.for_each(scan, [&](const BeamLine& line, const BeamReading& reading) {
      for (int ray = 0; ray < beams.rays(); ++ray)
        tiles_on(beams.turned(line, ray), reading.steps, tiles);
    });
    std::sort(tiles.begin(), tiles.end(), [](const auto& a, const auto& b) {
      return a.ty != b.ty ? a.ty < b.ty : a.tx < b.tx;
    });
    tiles.erase(std::unique(tiles.begin(), tiles.end()), tiles.end());
  }

  /// E-step over all scans. `blind`: nothing is known of the map yet, a beam was stopped where it
  /// says.
  void expect(bool blind) {
    parallel_for(threads_, tallies_.size(), [&](std::size_t t) {
      std::fill(tallies_[t].stops.begin(), tallies_[t].stops.end(), 0.0);
      std::fill(tallies_[t].passes.begin(), tallies_[t].passes.end(), 0.0);
      Explainer explainer{*this, tallies_[t]};
      for (std::size_t i = t; i < chosen_.size(); i += tallies_.size())
        sums_[i] = explainer.scan(site_.scans[chosen_[i]], blind);
    });
    for (std::size_t t = 1; t < tallies_.size(); ++t)
      for (std::size_t c = 0; c < tallies_[0].stops.size(); ++c) {
        tallies_[0].stops[c] += tallies_[t].stops[c];
        tallies_[0].passes[c] += tallies_[t].passes[c];
      }
    total_ = {};
    for (const ScanSums& s : sums_) {
      total_.log_likelihood += s.log_likelihood;
      total_.squares += s.squares;
      total_.stopped += s.stopped;
      total_.random += s.random;
      total_.none += s.none;
      total_.beams += s.beams;
    }
    if (!kinds_.empty()) pool();
  }

  struct Explainer {
    ForwardFit& fit;
    Tally& tally;
    std::vector<std::uint32_t> path{};
    std::vector<double> stops{};

    ScanSums scan(const PosedScan& posed, bool blind) {
      ScanSums sums;
      const ForwardGrid& grid = fit.grid_;
      ForwardBeams beams(grid.cells_, grid.options_);
      beams.for_each(posed, [&](const BeamLine& line, const BeamReading& reading) {
        beams.cells_on(line, reading, path);
        const BeamCause cause = blind ? straightforward(reading)
                                      : explain(grid.cells_, grid.model_, reading,
                                                grid.options_.max_range, path, stops);
        add(cause, reading);
        sums.log_likelihood += cause.log_likelihood;
        sums.squares += cause.squares;
        (reading.stopped ? sums.random : sums.none) += 1 - cause.seen;
        if (reading.stopped) sums.stopped += cause.seen;
        ++sums.beams;
      });
      return sums;
    }

    BeamCause straightforward(const BeamReading& reading) {
      const double step = fit.grid_.cells_.step(), sigma = fit.grid_.model_.sigma;
      BeamCause cause{0, 1, 0};
      const auto rays = static_cast<std::size_t>(reading.rays);
      stops.assign(static_cast<std::size_t>(reading.steps - reading.before) * rays, 0);
      double sum = 0;
      for (std::size_t k = 0; k < stops.size(); ++k) {
        const auto at = static_cast<double>(k / rays) + reading.before + 0.5;
        const double off = reading.range - at * step;
        stops[k] = std::exp(-0.5 * off * off / (sigma * sigma));
        sum += stops[k];
        cause.squares += stops[k] * off * off;
      }
      for (double& s : stops) s /= sum;
      if (reading.stopped) cause.squares /= sum;
      return cause;
    }

    void add(const BeamCause& cause, const BeamReading& reading) {
      double* passes = tally.passes.data();
      const double all = rounded(cause.seen);
      for (int k = 0; k < reading.before * reading.rays; ++k)
        passes[path[static_cast<std::size_t>(k)]] += all;
      if (!reading.stopped) return;
      double on = cause.seen;
      const std::uint32_t* cells = path.data() + reading.before * reading.rays;
      for (std::size_t k = 0; k < stops.size(); ++k) {
        const std::uint32_t cell = cells[k];
        on -= stops[k];
        tally.stops[cell] += rounded(stops[k]);
        passes[cell] += rounded(std::max(on, 0.0));
      }
    }
  };

  void pool() {
    Tally& tally = tallies_[0];
    std::vector<double> stops(kKinds), passes(kKinds);
    for (std::size_t c = 0; c < kinds_.size(); ++c) {
      stops[kinds_[c]] += tally.stops[c];
      passes[kinds_[c]] += tally.passes[c];
    }
    for (std::size_t c = 0; c < kinds_.size(); ++c) {
      tally.stops[c] = stops[kinds_[c]];
      tally.passes[c] = passes[kinds_[c]];
    }
  }

  /// M-step: (17.4), (17.5).
  void maximize() {
    const ForwardGridOptions& o = grid_.options_;
    const double steps = prior_steps();
    const Tally& tally = tallies_[0];
    for (std::size_t c = 0; c < tally.stops.size(); ++c)
      grid_.cells_.set(
          c, (tally.stops[c] + o.prior_stop * steps) / (tally.stops[c] + tally.passes[c] + steps));
    const double beams = static_cast<double>(total_.beams) + 3;
    grid_.model_.random = (total_.random + 1) / beams;
    grid_.model_.none = (total_.none + 1) / beams;
    if (total_.stopped > 0)
      grid_.model_.sigma = std::clamp(std::sqrt(total_.squares / total_.stopped),
                                      0.5 * grid_.cells_.step(), ForwardBeams::largest_sigma(o));
  }

  double prior_steps() const { return grid_.options_.prior_weight * ForwardCells::kStepsPerCell; }

  /// Of map, shares and sigma, but for a constant.
  double log_posterior() const {
    const double stop = grid_.options_.prior_stop * prior_steps();
    const double pass = prior_steps() - stop;
    const ForwardCells& cells = grid_.cells_;
    const ForwardModel& m = grid_.model_;
    double prior = 0;
    std::vector<bool> counted(kKinds);
    for (std::size_t c = 0; c < cells.stop.size(); ++c) {
      if (!kinds_.empty()) {
        if (counted[kinds_[c]]) continue;
        counted[kinds_[c]] = true;
      }
      prior += stop * std::log(cells.stop[c]) + pass * cells.log_pass[c];
    }
    prior += std::log(m.random) + std::log(m.none) + std::log(1 - m.random - m.none);
    return total_.log_likelihood + prior;
  }

  bool settled() const {
    const std::vector<double>& p = grid_.posterior_;
    return p.size() > 1 && p.back() - p[p.size() - 2] <=
                               grid_.options_.tolerance * static_cast<double>(total_.beams);
  }

  void keep_evidence() {
    const Tally& tally = tallies_[0];
    for (std::size_t c = 1; c < tally.stops.size(); ++c)
      grid_.evidence_[c] =
          static_cast<float>((tally.stops[c] + tally.passes[c]) / ForwardCells::kStepsPerCell);
  }

  static constexpr std::size_t kKinds = 260;
  const Site& site_;
  Threads threads_;
  ForwardGrid grid_;
  std::vector<std::size_t> chosen_;
  std::vector<std::uint16_t> kinds_;  ///< empty: each cell is its own
  std::vector<Tally> tallies_;        ///< one a thread
  std::vector<ScanSums> sums_;        ///< one a scan
  ScanSums total_;
};

ForwardGrid build_forward_grid(const Site& site, const ForwardGridOptions& options,
                               Threads threads) {
  return ForwardFit(site, options, threads).run();
}

ForwardGrid fit_to_log_odds(const OccupancyGrid& log_odds, const Site& site,
                            const ForwardGridOptions& options, Threads threads) {
  ForwardFit fit(site, options, threads);
  fit.tie(log_odds);
  return fit.run();
}

}  // namespace majak::map
