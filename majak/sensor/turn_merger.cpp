// SPDX-License-Identifier: Apache-2.0
#include "majak/sensor/turn_merger.hpp"

#include <algorithm>
#include <cstddef>

namespace majak::sensor {
namespace {

/// Severity of the worst, warnings of all.
std::uint8_t worse(std::uint8_t a, std::uint8_t b) {
  const unsigned severity = std::max(a & 7U, b & 7U);
  return static_cast<std::uint8_t>(((a | b) & ~7U) | severity);
}

/// Beam k is of turn k mod the number of turns.
LmsScan interleave(const std::vector<std::optional<LmsScan>>& turns, const Variant& whole) {
  LmsScan scan = *turns.back();
  scan.partial = false;
  scan.quarter = 0;
  scan.values.clear();
  for (std::size_t beam = 0; beam < static_cast<std::size_t>(whole.beams()); ++beam)
    scan.values.push_back(turns[beam % turns.size()]->values[beam / turns.size()]);
  for (const auto& turn : turns) scan.status = worse(scan.status, turn->status);
  return scan;
}

}  // namespace

// Two scans begin at least two turns apart; one turn is more than a stamp is off. The counter says
// the same more sharply, but comes around after 256 turns.
bool TurnMerger::same(const Set& a, const Set& b) {
  const Duration apart = std::max(a.begin, b.begin) - std::min(a.begin, b.begin);
  return a.whole == b.whole && a.index == b.index && apart < kMirrorTurn;
}

std::optional<LmsScan> TurnMerger::add(const LmsScan& turn, const Variant& variant, Time stamp) {
  const Variant whole = merged_variant(variant);
  const int count = whole.turns();
  if (!turn.partial || !fits(turn, variant) || turn.quarter * count % 4 != 0) return std::nullopt;
  const int part = turn.quarter * count / 4;

  Set set;
  set.whole = whole;
  set.begin = stamp - part * kMirrorTurn;
  if (turn.scan_index) set.index = static_cast<std::uint8_t>(*turn.scan_index - part);
  if (set_.turns.empty() || !same(set, set_)) {
    if (set_.missing > 0) ++incomplete_;
    set.missing = static_cast<std::size_t>(count);
    set.turns.resize(set.missing);
    set_ = std::move(set);
  }

  auto& place = set_.turns[static_cast<std::size_t>(part)];
  if (place) return std::nullopt;
  place = turn;
  if (--set_.missing > 0) return std::nullopt;
  return interleave(set_.turns, whole);
}

}  // namespace majak::sensor
