// SPDX-License-Identifier: Apache-2.0
// GpsPieces: which satellite fixes belong together. A receiver that changes its satellites jumps,
// and the fixes before and after the jump err differently; the wheels tell, since whatever the
// heading is, the way between two fixes is as long as the way driven. Pieces of a few fixes are no
// witness, nor is the last fix before an outage.
#pragma once

#include <cstddef>
#include <vector>

#include "majak/core/event.hpp"
#include "majak/core/time.hpp"

namespace majak::localize {

struct GpsPiecesOptions {
  double outage = 5;  ///< s without a fix; what follows is a new piece
  double jump =
      0.35;  ///< m by which steps of fixes and wheels may differ, where no sigma is stated
  double lever = 1.5;  ///< m, how far the antenna may be from the robot's point
  int least = 3;       ///< fixes in a piece that counts
};

struct FixVerdict {
  std::size_t piece = 0;
  bool trusted = false;
};

class GpsPieces {
 public:
  explicit GpsPieces(const GpsPiecesOptions& options = {}) : options_(options) {}

  /// The next fix, in order of time, and the way driven by then (m, backward counted too) and the
  /// turns made (rad, either way): they swing the antenna, wherever it is. The
  /// verdict is that of the moment: whether an outage follows is not known yet.
  FixVerdict add(const GpsFix& fix, double way, double turned = 0);
  /// Of all fixes, with what came after them.
  std::vector<FixVerdict> verdicts() const;

 private:
  struct Seen {
    GpsFix fix;
    double way, turned;
    std::size_t piece;
  };
  bool outage_between(const Seen& a, const GpsFix& b) const;

  GpsPiecesOptions options_;
  std::vector<Seen> seen_;
  std::vector<int> members_;  // of each piece
};

}  // namespace majak::localize
