// SPDX-License-Identifier: Apache-2.0
#include "majak/eval/relations.hpp"
#include "tests/fuzz/fuzz.hpp"

/// Trajectories (first byte t) and relations, evaluated against each other.
MAJAK_FUZZ(text) {
  majak::Report report;
  const auto bytes = [&] {
    return majak::io::open_bytes_in_memory(text.substr(text.empty() ? 0 : 1)).bytes;
  };
  if (!text.empty() && text[0] == 't') {
    const auto trajectory = majak::eval::read_tum(bytes(), "fuzz", report);
    majak::eval::associate(trajectory, trajectory);
  } else {
    const auto relations = majak::eval::read_relations(bytes(), "fuzz", report);
    majak::eval::evaluate_relations({{0, {}}, {majak::kSecond, {1, 0, 0}}}, relations);
  }
}
