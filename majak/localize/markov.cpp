// SPDX-License-Identifier: Apache-2.0
#include "majak/localize/markov.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "majak/localize/on_scans.hpp"
#include "majak/motion/path_uncertainty.hpp"

namespace majak::localize {
namespace {

using filter::PoseHistogram;
using filter::PoseLattice;
constexpr std::size_t kLeastReturns = 10;
constexpr double kNearby = 0.5, kNearbyTurn = radians(12);  // m, rad; about the mode
constexpr double kWeak = 0.30;                              // m, sigma of a weak direction
constexpr double kSpread = 0.5, kSpreadTurn = 0.3;          // m, rad; more is as good as anywhere

std::shared_ptr<const PoseLattice> lattice_of(const map::KnownMap& map, const MarkovOptions& o) {
  const auto cells = [&](int n) {
    return static_cast<int>(std::ceil(n * map.resolution / o.cell - 1e-9));
  };
  PoseLattice lattice(map.x0, map.y0, o.cell, cells(map.width), cells(map.height),
                      std::max(4, static_cast<int>(std::lround(2 * kPi / o.turn))));
  // Open where any free cell of the map is in it, or it is in one.
  for (const std::uint32_t i : map.all(map::CellState::free)) {
    const Vec2 p = map.centre(static_cast<int>(i) % map.width, static_cast<int>(i) / map.width);
    lattice.set_open(static_cast<int>((p.x() - map.x0) / o.cell),
                     static_cast<int>((p.y() - map.y0) / o.cell));
  }
  for (int iy = 0; iy < cells(map.height); ++iy)
    for (int ix = 0; ix < cells(map.width); ++ix)
      if (map.at(Vec2(map.x0 + (ix + 0.5) * o.cell, map.y0 + (iy + 0.5) * o.cell)) ==
          map::CellState::free)
        lattice.set_open(ix, iy);
  return std::make_shared<const PoseLattice>(std::move(lattice));
}

}  // namespace

Markov::Markov(PlacePtr place, const MarkovOptions& options, Threads threads)
    : place_(std::move(place)),
      options_(options),
      threads_(threads),
      lattice_(lattice_of(place_->known, options)),
      weighing_(place_, lattice_, options.effective),
      belief_(lattice_),
      elsewhere_(-std::log(options.elsewhere)) {
  belief_.add_uniform(1);
}

Estimate Markov::add(const FedScan& fed) {
  pending_ = pending_.then({fed.T_previous_robot, fed.covariance});
  if (updates_ == 0 || worth_an_update(fed)) {
    if (updates_ > 0) move();
    see(fed.scan);
    lay_to_rest();
    if (resting() > options_.wake) wake();
    estimate_ = about_the_mode();
    ++updates_;
  }
  Estimate now = estimate_;
  now.time = fed.scan.time;
  now.T_map_robot = estimate_.T_map_robot * pending_.T_from_to;
  Mat3 swing = Mat3::Identity();
  swing(0, 2) = estimate_.T_map_robot.y - now.T_map_robot.y;
  swing(1, 2) = now.T_map_robot.x - estimate_.T_map_robot.x;
  now.covariance = swing * estimate_.covariance * swing.transpose() +
                   motion::in_map_axes(pending_.covariance, now.T_map_robot.theta);
  return now;
}

// Wheels that stand still are believed; a habit is not.
bool Markov::worth_an_update(const FedScan& fed) const {
  const double moved = pending_.T_from_to.translation().norm();
  const double spread = std::sqrt(pending_.covariance(0, 0) + pending_.covariance(1, 1));
  return moved >= options_.motion_step ||
         std::abs(pending_.T_from_to.theta) >= options_.motion_turn ||
         (!fed.by_wheels && spread >= options_.motion_step);
}

// Bel-(l) = sum over l' of P(l | a, l') Bel(l'). Into walls nobody moves: what did is shared out.
// What rests and is less likely than that the robot was just carried away needs no memory.
void Markov::move() {
  const double before = belief_.mass();
  belief_.move(pending_, threads_);
  const double after = belief_.mass(), stays = after > 0 ? (1 - options_.carried) * before : 0;
  if (after > 0) belief_.scale(stays / after);
  anywhere_ += before - stays;
  for (Rest& rest : resting_) {
    rest.since = rest.since.then(pending_);
    const Mat3& c = rest.since.covariance;
    if (rest.mass < options_.carried || std::max(c(0, 0), c(1, 1)) > kSpread * kSpread ||
        c(2, 2) > kSpreadTurn * kSpreadTurn)
      anywhere_ += std::exchange(rest.mass, 0);
  }
  std::erase_if(resting_, [](const Rest& rest) { return rest.mass == 0; });
  pending_ = {};
}

// Bel(l) = alpha P(s | l) Bel-(l).
void Markov::see(const Scan& scan) {
  const match::Beams beams = match::beams(scan, {.most = options_.beams});
  if (beams.returns < kLeastReturns) return;
  weighed_ = weighing_.weigh(belief_, beams,
                             {all_ ? 0 : options_.share, options_.share, elsewhere_}, threads_);
  // Where the whole map has nothing better to tell, there is no use in waking for it.
  const double usual = -std::log(options_.elsewhere);
  if (all_ || weighed_.best < usual) elsewhere_ = std::max(usual, weighed_.best);
  all_ = false;
  anywhere_ *= weighed_.elsewhere;
  for (Rest& rest : resting_) rest.mass *= weighed_.elsewhere;
  const double alpha = 1 / (belief_.mass() + resting());
  belief_.scale(alpha);
  anywhere_ *= alpha;
  for (Rest& rest : resting_) rest.mass *= alpha;
}

// Tiles whose likeliest cell is not worth a look; not where they are much together.
void Markov::lay_to_rest() {
  float largest = 0;
  std::vector<std::pair<std::size_t, float>> tiles;
  for (const std::size_t i : belief_.held()) {
    const std::vector<float>& p = belief_.tile(i);
    tiles.emplace_back(i, *std::max_element(p.begin(), p.end()));
    largest = std::max(largest, tiles.back().second);
  }
  Rest rest{PoseHistogram(lattice_), {}, 0};
  for (const auto& [i, most] : tiles)
    if (most < static_cast<float>(options_.share) * largest)
      rest.belief.tile(i).swap(belief_.tile(i));
  rest.mass = rest.belief.mass();
  if (rest.mass == 0) return;
  if (resting() + rest.mass > options_.wake / 2) {
    belief_.add(rest.belief, 1);
  } else if (rest.mass < options_.carried) {  // no more than comes from anywhere anyway
    anywhere_ += rest.mass;
  } else {
    rest.belief.scale(1 / rest.mass);
    resting_.push_back(std::move(rest));
  }
}

void Markov::wake() {
  for (Rest& rest : resting_) {
    rest.belief.move(rest.since, threads_);
    const double left = rest.belief.mass();
    if (left > 0)
      belief_.add(rest.belief, rest.mass / left);
    else
      anywhere_ += rest.mass;
  }
  resting_.clear();
  belief_.add_uniform(std::exchange(anywhere_, 0));
  all_ = true;
}

double Markov::resting() const {
  double sum = anywhere_;
  for (const Rest& rest : resting_) sum += rest.mass;
  return sum;
}

std::size_t Markov::bytes() const {
  std::size_t sum = belief_.bytes();
  for (const Rest& rest : resting_) sum += rest.belief.bytes();
  return sum;
}

// Mean and covariance of the cells about the likeliest one.
Estimate Markov::about_the_mode() const {
  std::size_t tile = 0, cell = 0;
  float largest = -1;
  for (const std::size_t i : belief_.held()) {
    const std::vector<float>& p = belief_.tile(i);
    const auto at = std::max_element(p.begin(), p.end());
    if (*at > largest) largest = *at, tile = i, cell = static_cast<std::size_t>(at - p.begin());
  }
  const auto in_slice = static_cast<int>(cell % PoseLattice::kSlice);
  const int ix = static_cast<int>(tile) % lattice_->tiles_x * PoseLattice::kSide +
                 in_slice % PoseLattice::kSide;
  const int iy = static_cast<int>(tile) / lattice_->tiles_x * PoseLattice::kSide +
                 in_slice / PoseLattice::kSide;
  const int heading = static_cast<int>(cell / PoseLattice::kSlice);
  const Vec3 size(lattice_->cell, lattice_->cell, lattice_->turn());
  const int n = static_cast<int>(std::lround(kNearby / lattice_->cell));
  const int turns = std::min(static_cast<int>(std::lround(kNearbyTurn / lattice_->turn())),
                             (lattice_->headings - 1) / 2);
  double mass = 0;
  Vec3 sum = Vec3::Zero();
  Mat3 squares = Mat3::Zero();
  for (int h = -turns; h <= turns; ++h)
    for (int y = -n; y <= n; ++y)
      for (int x = -n; x <= n; ++x) {
        const double p = belief_.at(ix + x, iy + y, heading + h);
        const Vec3 off = size.cwiseProduct(Vec3(x, y, h));
        mass += p, sum += p * off, squares += p * off * off.transpose();
      }
  Estimate e;
  if (!(mass > 0)) {
    e.health = Health::lost;
    return e;
  }
  const Vec3 mean = sum / mass;
  e.T_map_robot =
      from_vector(Vec3(lattice_->x0 + (ix + 0.5) * lattice_->cell,
                       lattice_->y0 + (iy + 0.5) * lattice_->cell, lattice_->heading(heading)) +
                  mean);
  e.covariance = squares / mass - mean * mean.transpose();
  e.covariance.diagonal() += size.cwiseAbs2() / 12;  // within a cell
  const bool fits = weighed_.best < -std::log(options_.elsewhere);
  e.health = mass < 0.5                      ? Health::lost
             : mass < options_.sure || !fits ? Health::degraded
                                             : Health::ok;
  if (least_known(e.covariance).sigma > kWeak && e.health != Health::lost) degrade(e);
  return e;
}

Localizer markov(const PlacePtr& place, const MarkovOptions& options,
                 const PlausibilityOptions& plausibility, const std::function<double()>& clock) {
  return on_scans([=, markov = Markov(place, options), watch = Plausibility(place, plausibility)](
                      const FedScan& scan, Localization& result) mutable -> Step {
    const double begin = clock ? clock() : 0;
    Estimate estimate = markov.add(scan);
    if (result.phases.empty()) result.phases = {{"update", 0}};
    result.phases[0].seconds += (clock ? clock() : 0) - begin;
    result.belief_bytes.push_back(markov.bytes());
    result.updates = markov.updates();
    // A cell is too wide to judge wheels by; a habit needs whatever there is.
    const bool trusted = !scan.by_wheels && estimate.health == Health::ok;
    watch.add(scan, estimate.T_map_robot);
    watch.limit(estimate);
    if (watch.at_best() == Health::lost) {  // not here: anywhere
      markov = Markov(place, options);
      watch.begin_anew();
    }
    return {estimate, trusted};
  });
}

void describe(OptionFields& f, MarkovOptions& o) {
  f.add("markov.cell", o.cell, {"m", "side of a cell", 0.01, 2});
  f.add("markov.turn", o.turn, {"rad", "heading of a cell", 0.005, 1});
  f.add("markov.motion_step", o.motion_step, {"m", "moved before an update", 0, 10});
  f.add("markov.motion_turn", o.motion_turn, {"rad", "turned before an update", 0, 3});
  f.add("markov.beams", o.beams, {"1", "of a scan", 10, 1000});
  f.add("markov.effective", o.effective, {"1", "beams that err by themselves", 0.1, 1000});
  f.add("markov.share", o.share,
        {"1", "cells below this times the largest are not looked at", 1e-12, 0.5});
  f.add("markov.elsewhere", o.elsewhere,
        {"1", "mean likelihood of a beam, for what is not looked at", 0.01, 1});
  f.add("markov.carried", o.carried, {"1", "probability a step of being carried away", 0, 0.5});
  f.add("markov.wake", o.wake,
        {"1", "probability of what rests from which on all are woken", 0.001, 1});
  f.add("markov.sure", o.sure, {"1", "probability about the estimate to be sure", 0.5, 1});
}

}  // namespace majak::localize
