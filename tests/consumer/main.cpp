// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "majak/eval/ate_rpe.hpp"

int main() {
  const std::vector<majak::eval::PosePair> pairs = {{0, {0.3, 0.4, 0}, {0, 0, 0}, true}};
  const auto error = majak::eval::absolute_error(pairs, majak::eval::Alignment::none);
  std::printf("%.4f\n", error.translation.mean);
  return 0;
}
