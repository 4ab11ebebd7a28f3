// SPDX-License-Identifier: Apache-2.0
#include "majak/core/report.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace majak {
namespace {

TEST(Report, CountsAndKeepsTheFirstLine) {
  Report report;
  EXPECT_TRUE(report.empty());
  report.count("truncated scan", 4711);
  report.count("truncated scan", 12);
  report.count("unknown message");
  EXPECT_FALSE(report.empty());
  ASSERT_EQ(report.entries().size(), 2U);
  EXPECT_EQ(report.entries().at("truncated scan").count, 2);
  EXPECT_EQ(report.entries().at("truncated scan").first_line, 4711);
  EXPECT_EQ(report.entries().at("unknown message").count, 1);
  EXPECT_EQ(report.entries().at("unknown message").first_line, 0);
}

TEST(Report, AddJoinsTwoReports) {
  Report first, second;
  first.count("damaged", 5);
  second.count("damaged", 3);
  second.count("damaged", 4);
  second.count("late", 9);
  for (const auto& [what, entry] : second.entries()) first.add(what, entry);
  EXPECT_EQ(first.entries().at("damaged").count, 3);
  EXPECT_EQ(first.entries().at("damaged").first_line, 5);
  EXPECT_EQ(first.entries().at("late").count, 1);
  EXPECT_EQ(first.entries().at("late").first_line, 9);
}

TEST(Report, EntriesAreSortedWhateverCameFirst) {
  Report report;
  for (const char* what : {"c", "a", "b"}) report.count(what);
  std::vector<std::string> order;
  for (const auto& [what, entry] : report.entries()) order.push_back(what);
  EXPECT_EQ(order, (std::vector<std::string>{"a", "b", "c"}));
}

}  // namespace
}  // namespace majak
