// SPDX-License-Identifier: Apache-2.0
// A method that works scan by scan, as the registry wants it: fed with events, each scan with the
// motion before it, its steps told back to where the motion comes from.
#pragma once

#include <memory>
#include <optional>
#include <utility>

#include "majak/localize/localizer.hpp"
#include "majak/localize/scan_feed.hpp"

namespace majak::localize {

/// An estimate, and whether the step up to it may be learnt from.
struct Step {
  Estimate estimate;
  bool trusted = false;
};

/// add_scan: Step(const FedScan&, Localization&), which may put evidence into the result.
template <class AddScan>
Localizer on_scans(AddScan add_scan) {
  struct Run {
    AddScan add_scan;
    ScanFeed feed{};
    Localization result{};

    std::optional<Estimate> take_scans() {
      std::optional<Estimate> newest;
      while (const auto scan = feed.next()) {
        const Step step = add_scan(*scan, result);
        newest = step.estimate;
        if (!result.estimates.empty())
          feed.observe(between(result.estimates.back().T_map_robot, newest->T_map_robot),
                       step.trusted);
        result.estimates.push_back(*newest);
      }
      return newest;
    }
  };
  const auto run = std::make_shared<Run>(Run{std::move(add_scan)});
  return {[run](const Event& event) {
            run->feed.add(event);
            return run->take_scans();
          },
          [run] {
            run->feed.end();
            run->take_scans();
            return std::move(run->result);
          }};
}

}  // namespace majak::localize
