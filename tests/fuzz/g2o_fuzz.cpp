// SPDX-License-Identifier: Apache-2.0
#include "majak/io/g2o.hpp"
#include "tests/fuzz/fuzz.hpp"

/// What is accepted is written and accepted again.
MAJAK_FUZZ(text) {
  majak::Report report;
  const auto graph = majak::io::parse_g2o(text, "fuzz", report);
  majak::io::parse_g2o(majak::io::g2o_text(graph.graph, graph.ids), "again", report);
}
