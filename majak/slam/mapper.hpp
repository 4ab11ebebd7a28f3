// SPDX-License-Identifier: Apache-2.0
// Mapper: what every method of mapping looks like from outside. Whoever runs one hands it events in
// the log's order and asks for the Site at the end; methods/mappers makes them by name.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "majak/core/event.hpp"
#include "majak/core/site.hpp"

namespace majak::slam {

/// That a method found itself at a place it had been to before, and what it made of it.
struct LoopCorrection {
  std::size_t scan = 0;               ///< at which it was found; index into Site::scans
  std::size_t since = 0;              ///< scan at which the loop began: those between were moved
  double way = 0;                     ///< m driven since
  double moved = 0;                   ///< m, by which the newest pose was moved
  std::size_t touched = 0;            ///< key scans that were moved and drawn anew
  std::optional<std::size_t> undone;  ///< scan at which it was taken back
};

/// What a run of a method leaves.
struct Mapping {
  Site site;
  bool posterior = false;  ///< the poses' covariances are the method's own; else it keeps none
  std::vector<LoopCorrection> corrections;
  /// Of methods that climb a likelihood: its logarithm, iteration by iteration; a new series where
  /// the model itself changes (a finer map), since those cannot be compared.
  std::vector<std::vector<double>> log_likelihoods;
  std::size_t landmarks = 0;     ///< of methods that map these
  std::size_t belief_bytes = 0;  ///< at most, of what the method keeps beside the scans
};

class ScanChain;

struct Mapper {
  /// The next event, in the log's order; the newest estimate where it made one. Methods that work
  /// after the run give none.
  std::function<std::optional<Estimate>(Event)> add;
  /// After the last event. Throws Error that says what the method lacks.
  std::function<Mapping()> finish;
  /// The scans so far and where they are by now, for who looks on; until finish().
  std::function<const ScanChain&()> chain;
};

/// A class with add(Event), finish() and chain(), as a Mapper.
template <class Method, class... Arguments>
Mapper mapper_of(const Arguments&... arguments) {
  const auto method = std::make_shared<Method>(arguments...);
  return {[method](Event event) { return method->add(std::move(event)); },
          [method] { return method->finish(); },
          [method]() -> const ScanChain& { return method->chain(); }};
}

}  // namespace majak::slam
