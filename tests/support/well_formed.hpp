// SPDX-License-Identifier: Apache-2.0
// Whether a page of HTML is well formed.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace majak::test {

/// Elements that are opened are closed, in order; void elements and <.../> aside.
inline void expect_well_formed(const std::string& html) {
  std::vector<std::string> open;
  for (std::size_t i = html.find('<'); i != std::string::npos; i = html.find('<', i)) {
    const std::size_t end = html.find('>', i);
    ASSERT_NE(end, std::string::npos);
    const std::string tag = html.substr(i + 1, end - i - 1);
    i = end;
    const std::string name = tag.substr(0, tag.find_first_of(" /", 1));
    if (name == "!DOCTYPE" || name == "meta" || name == "input" || name == "img" ||
        tag.back() == '/')
      continue;
    if (tag[0] == '/') {
      ASSERT_FALSE(open.empty()) << tag;
      ASSERT_EQ("/" + open.back(), tag) << "before position " << i;
      open.pop_back();
    } else {
      open.push_back(name);
      if (name == "script") i = html.find("</script>", i);
      if (name == "style") i = html.find("</style>", i);
    }
  }
  EXPECT_TRUE(open.empty());
}

}  // namespace majak::test
