// SPDX-License-Identifier: Apache-2.0
// The registry of methods that make a map: one row a method, read by `majak map --method` and by
// everything that compares them. A new method is one new file in slam/ and one new row.
#pragma once

#include <span>
#include <string_view>

#include "majak/core/options.hpp"
#include "majak/core/parallel.hpp"
#include "majak/slam/ekf_mapper.hpp"
#include "majak/slam/expectation_maximization.hpp"
#include "majak/slam/graph_slam.hpp"
#include "majak/slam/hybrid.hpp"
#include "majak/slam/incremental_ml.hpp"
#include "majak/slam/lu_milios.hpp"
#include "majak/slam/mapper.hpp"
#include "majak/slam/rao_blackwellized.hpp"

namespace majak::methods {

/// The options of all methods together, so that one options.toml serves them all. What they are fed
/// by is graph_slam.chain, the same for each.
struct MappingOptions {
  slam::GraphSlamOptions graph_slam;
  slam::IncrementalMlOptions incremental_ml;
  slam::EkfSlamOptions ekf_slam = slam::ekf_for_rooms();
  slam::HybridOptions hybrid;
  slam::RaoBlackwellizedOptions particles;
  slam::LuMiliosOptions lu_milios;
  slam::ExpectationMaximizationOptions em;
};
void describe(OptionFields& fields, MappingOptions& options);

struct MappingMethod {
  const char* name;           ///< on the command line: "incremental-ml"
  const char* after;          ///< an other name for it, or empty
  const char* in_the_thesis;  ///< what it is called there, and where
  const char* needs;          ///< for people
  const char* yields;         ///< for people
  slam::Mapper (*make)(const MappingOptions& options, Threads threads);
};

/// The main one first.
std::span<const MappingMethod> mapping_methods();

/// Throws Error that lists the names there are.
const MappingMethod& mapping_method(std::string_view name);

}  // namespace majak::methods
