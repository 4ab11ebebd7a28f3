// SPDX-License-Identifier: Apache-2.0
#include "majak/methods/mappers.hpp"

#include <algorithm>
#include <iterator>
#include <string>

#include "majak/core/error.hpp"

namespace majak::methods {
namespace {

const MappingMethod kMappers[] = {
    {"graph-slam", "", "simultaneous localization and mapping, p. 34; a pose graph as of today",
     "scans; odometry helps", "poses with covariance, loops closed, map",
     [](const MappingOptions& o, Threads threads) {
       return slam::mapper_of<slam::GraphSlam>(o.graph_slam, threads);
     }},
    {"ekf-slam", "stochastic-map",
     "Kalman filter, p. 35; the stochastic map of Smith, Self and Cheeseman, p. 32",
     "scans that show corners, trunks or poles; odometry",
     "poses with covariance as known at each time, landmarks",
     [](const MappingOptions& o, Threads threads) {
       return slam::mapper_of<slam::EkfMapper>(o.graph_slam.chain, o.ekf_slam, threads);
     }},
    {"lu-milios", "", "Lu and Milios, table 2", "scans that overlap; odometry helps",
     "poses with covariance, map; no loop is closed that drift has opened",
     [](const MappingOptions& o, Threads threads) {
       return slam::mapper_of<slam::LuMilios>(o.graph_slam.chain, o.lu_milios, threads);
     }},
    {"em", "", "expectation maximisation, p. 36", "scans, odometry; after the run",
     "poses without covariance, map; rings close",
     [](const MappingOptions& o, Threads threads) {
       return slam::mapper_of<slam::ExpectationMaximization>(o.graph_slam.chain, o.em, threads);
     }},
    {"incremental-ml", "", "incremental maximum likelihood, p. 36", "scans; odometry helps",
     "poses without covariance, map; no loop is closed",
     [](const MappingOptions& o, Threads threads) {
       return slam::mapper_of<slam::IncrementalMl>(o.graph_slam.chain, o.incremental_ml, threads);
     }},
    {"hybrid", "", "incremental maximum likelihood with pose samples, p. 36",
     "scans; odometry helps",
     "poses without covariance, map; a loop is closed by relocalizing and corrected backwards",
     [](const MappingOptions& o, Threads threads) {
       return slam::mapper_of<slam::Hybrid>(o.graph_slam.chain, o.hybrid, threads);
     }},
    {"particles", "", "beyond the thesis: Rao-Blackwellised particles, today's GMapping",
     "scans; odometry helps", "poses without covariance, map; rings close where particles suffice",
     [](const MappingOptions& o, Threads threads) {
       return slam::mapper_of<slam::RaoBlackwellized>(o.graph_slam.chain, o.particles, threads);
     }},
};

}  // namespace

void describe(OptionFields& fields, MappingOptions& o) {
  slam::describe(fields, o.graph_slam);
  slam::describe(fields, o.ekf_slam);
  slam::describe(fields, o.incremental_ml);
  slam::describe(fields, o.hybrid);
  slam::describe(fields, o.particles);
  slam::describe(fields, o.lu_milios);
  slam::describe(fields, o.em);
}

std::span<const MappingMethod> mapping_methods() { return kMappers; }

const MappingMethod& mapping_method(std::string_view name) {
  const auto found = std::find_if(
      std::begin(kMappers), std::end(kMappers),
      [&](const MappingMethod& m) { return name == m.name || (*m.after && name == m.after); });
  if (found != std::end(kMappers)) return *found;
  std::string names;
  for (const MappingMethod& m : kMappers) names += std::string(names.empty() ? "" : ", ") + m.name;
  throw Error("no method " + std::string(name) + " makes a map; there are: " + names);
}

}  // namespace majak::methods
