// SPDX-License-Identifier: Apache-2.0
// learn_echo_response: docs/MATH.md 18. What is unknown of each cell is eliminated, so that the
// equations have as many unknowns as the curves have knots.
#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

#include "majak/core/error.hpp"
#include "majak/core/option_range.hpp"
#include "majak/map/intensity.hpp"
#include "majak/map/scan_choice.hpp"

namespace majak::map {
namespace {

constexpr int kRangeKnots = 20, kSlantKnots = 9;
constexpr int kUnknowns = kRangeKnots + kSlantKnots + 1;  // and the mean brightness
constexpr int kRounds = 6;                                // of reweighting
constexpr std::size_t kMostScans = 2000;                  // spread evenly: curves need no more

struct Echo {
  std::uint64_t cell = 0;
  double log_strength = 0;
  std::array<int, 5> at{};  ///< unknowns it hangs on, with ...
  std::array<double, 5> weight{};
  double trust = 1;  ///< of a Huber loss
};

using Unknowns = Eigen::Matrix<double, kUnknowns, 1>;
using Equations = Eigen::Matrix<double, kUnknowns, kUnknowns>;

/// A place between knots, as shares of the two beside it.
void hang(Echo& echo, int slot, int first, int knots, double position) {
  const double at = std::clamp(position, 0.0, knots - 1.0);
  const int i = std::min(static_cast<int>(at), knots - 2);
  const auto s = static_cast<std::size_t>(slot);
  echo.at[s] = first + i, echo.weight[s] = 1 - (at - i);
  echo.at[s + 1] = first + i + 1, echo.weight[s + 1] = at - i;
}

struct RangeAxis {
  double low = 0, step = 1;
  explicit RangeAxis(const IntensityOptions& o)
      : low(std::log(std::max(o.min_range, 0.05))),
        step(std::max(std::log(o.max_range) - low, 0.1) / (kRangeKnots - 1)) {}
};

std::vector<Echo> all_echoes(const Site& site, const IntensityOptions& o) {
  std::vector<Echo> echoes;
  bool any = false;
  const RangeAxis axis(o);
  const auto chosen = scans_to_draw(site, {o.resolution, o.max_range, o.scan_spacing, o.scan_turn});
  const std::size_t each = (chosen.size() + kMostScans - 1) / kMostScans;
  for (std::size_t c = 0; c < chosen.size(); c += each) {
    const std::size_t s = chosen[c];
    const Scan& scan = site.scans[s].scan;
    any |= !scan.intensities.empty();
    const Pose2 T_map_laser = site.scans[s].estimate.T_map_robot * scan.T_robot_laser;
    for (const SurfaceEcho& e : surface_echoes(scan, o)) {
      const double angle = scan.angle(e.beam);
      const Vec2 p =
          T_map_laser * (e.range * Vec2(std::cos(angle), std::sin(angle))) / o.resolution;
      Echo echo;
      echo.cell = (static_cast<std::uint64_t>(
                       static_cast<std::uint32_t>(static_cast<int>(std::floor(p.x()))))
                   << 32) |
                  static_cast<std::uint32_t>(static_cast<int>(std::floor(p.y())));
      echo.log_strength = std::log(e.intensity);
      hang(echo, 0, 0, kRangeKnots, (std::log(e.range) - axis.low) / axis.step);
      hang(echo, 2, kRangeKnots, kSlantKnots, e.cos_slant * (kSlantKnots - 1));
      echo.at[4] = kUnknowns - 1, echo.weight[4] = 1;
      echoes.push_back(echo);
    }
  }
  if (!any)
    throw Error("no usable scan of " + site.source_name +
                " has intensities; the log has to carry remissions beside ranges");
  std::stable_sort(echoes.begin(), echoes.end(),
                   [](const Echo& a, const Echo& b) { return a.cell < b.cell; });
  return echoes;
}

double predicted(const Echo& echo, const Unknowns& x) {
  double sum = 0;
  for (std::size_t k = 0; k < echo.at.size(); ++k) sum += echo.weight[k] * x[echo.at[k]];
  return sum;
}

/// body(first, last) for the echoes of each cell.
template <class Body>
void for_each_cell(std::vector<Echo>& echoes, const Body& body) {
  for (std::size_t i = 0; i < echoes.size();) {
    std::size_t end = i;
    while (end < echoes.size() && echoes[end].cell == echoes[i].cell) ++end;
    body(echoes.data() + i, echoes.data() + end);
    i = end;
  }
}

/// (18.2): normal equations with each cell's own brightness eliminated.
Unknowns solve(std::vector<Echo>& echoes, const IntensityOptions& o) {
  Equations A = Equations::Zero();
  Unknowns b = Unknowns::Zero();
  const double prior = std::pow(o.echo_sigma / o.cell_sigma, 2);
  for_each_cell(echoes, [&](const Echo* first, const Echo* last) {
    Unknowns sum = Unknowns::Zero();
    double strength = 0, trust = prior;
    for (const Echo* e = first; e != last; ++e) {
      for (std::size_t i = 0; i < e->at.size(); ++i) {
        const double w = e->trust * e->weight[i];
        for (std::size_t j = 0; j < e->at.size(); ++j) A(e->at[i], e->at[j]) += w * e->weight[j];
        b[e->at[i]] += w * e->log_strength;
        sum[e->at[i]] += w;
      }
      strength += e->trust * e->log_strength;
      trust += e->trust;
    }
    A -= sum * sum.transpose() / trust;
    b -= sum * (strength / trust);
  });
  const auto bend = [&](int first, int knots) {
    for (int k = first + 1; k + 1 < first + knots; ++k) {
      Unknowns row = Unknowns::Zero();
      row[k - 1] = row[k + 1] = 1, row[k] = -2;
      A += o.smoothness * row * row.transpose();
    }
  };
  bend(0, kRangeKnots), bend(kRangeKnots, kSlantKnots);
  // Neither curve has a level of its own: any will do, it is taken out afterwards.
  A.diagonal().array() += 1e-6;
  return A.ldlt().solve(b);
}

void reweight(std::vector<Echo>& echoes, const Unknowns& x, const IntensityOptions& o) {
  const double prior = std::pow(o.echo_sigma / o.cell_sigma, 2);
  for_each_cell(echoes, [&](Echo* first, Echo* last) {
    double sum = 0, trust = prior;
    for (const Echo* e = first; e != last; ++e)
      sum += e->trust * (e->log_strength - predicted(*e, x)), trust += e->trust;
    for (Echo* e = first; e != last; ++e) {
      const double off = std::abs(e->log_strength - predicted(*e, x) - sum / trust);
      e->trust = std::min(1.0, 2 * o.echo_sigma / std::max(off, 1e-12));
    }
  });
}

}  // namespace

EchoResponse learn_echo_response(const Site& site, const IntensityOptions& options) {
  require_in_range(options);
  std::vector<Echo> echoes = all_echoes(site, options);
  Unknowns x = Unknowns::Zero();
  for (int round = 0; round < kRounds; ++round) {
    x = solve(echoes, options);
    if (round + 1 < kRounds) reweight(echoes, x, options);
  }
  const RangeAxis axis(options);
  EchoResponse response;
  for (int k = 0; k < kRangeKnots; ++k) {
    response.range_knots.push_back(axis.low + k * axis.step);
    response.by_range.push_back(x[k]);
  }
  for (int k = 0; k < kSlantKnots; ++k) response.by_slant.push_back(x[kRangeKnots + k]);
  // Levels: by_slant is 0 at 1, by_range in the mean over the echoes; the rest is brightness.
  const double level = response.by_slant.back();
  double mean = 0;
  for (const Echo& e : echoes)
    mean +=
        (e.weight[0] * x[e.at[0]] + e.weight[1] * x[e.at[1]]) / static_cast<double>(echoes.size());
  for (double& v : response.by_slant) v -= level;
  for (double& v : response.by_range) v -= mean;
  response.brightness = x[kUnknowns - 1] + level + mean;
  return response;
}

}  // namespace majak::map
