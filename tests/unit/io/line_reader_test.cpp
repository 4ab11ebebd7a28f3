// SPDX-License-Identifier: Apache-2.0
#include "majak/io/line_reader.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace majak::io {
namespace {

LineReader reader_of(std::string text, std::size_t longest = LineReader::kLongestLine) {
  return LineReader(open_bytes_in_memory(std::move(text)).bytes, longest);
}

std::vector<std::string> lines_of(LineReader& reader) {
  std::vector<std::string> lines;
  while (const auto line = reader.next()) {
    EXPECT_EQ(*line->end(), '\n');
    lines.emplace_back(*line);
  }
  return lines;
}

TEST(LineReader, SplitsAtLineEnds) {
  auto reader = reader_of("one\n\nthree\r\nfour");
  EXPECT_EQ(lines_of(reader), (std::vector<std::string>{"one", "", "three\r", "four"}));
  EXPECT_EQ(reader.line(), 4);
  EXPECT_FALSE(reader.terminated());
  EXPECT_FALSE(reader.next().has_value());
}

TEST(LineReader, AnEmptyFileHasNoLine) {
  auto reader = reader_of("");
  EXPECT_FALSE(reader.next().has_value());
  EXPECT_EQ(reader.line(), 0);
}

TEST(LineReader, KeepsLinesWholeAcrossBlocks) {
  std::string text;
  std::vector<std::string> expected;
  for (int i = 0; i < 3000; ++i) {
    expected.push_back(
        std::string(static_cast<std::size_t>(i % 701), static_cast<char>('a' + i % 26)));
    text += expected.back() + "\n";
  }
  auto reader = reader_of(text);
  EXPECT_EQ(lines_of(reader), expected);
  EXPECT_TRUE(reader.terminated());
}

TEST(LineReader, PassesOverLongLinesAndKeepsCountingLines) {
  auto reader =
      reader_of("ok\n" + std::string(101, 'x') + "\n" + std::string(100, 'y') + "\nend\n", 100);
  EXPECT_EQ(lines_of(reader), (std::vector<std::string>{"ok", std::string(100, 'y'), "end"}));
  EXPECT_EQ(reader.line(), 4);
  const auto report = reader.report();
  ASSERT_EQ(report.entries().size(), 1u);
  EXPECT_EQ(report.entries().begin()->second.first_line, 2);
}

TEST(LineReader, PassesOverLinesThatDoNotFitTheBuffer) {
  for (const char* end : {"\n", ""}) {
    auto reader = reader_of("a\n" + std::string(5'000'000, 'x') + end);
    EXPECT_EQ(lines_of(reader), (std::vector<std::string>{"a"}));
    EXPECT_EQ(reader.report().entries().begin()->second.count, 1);
    EXPECT_EQ(reader.line(), 2);
  }
  auto reader =
      reader_of(std::string(5'000'000, 'x') + "\nb\n" + std::string(2'000'000, 'y') + "\nc");
  EXPECT_EQ(lines_of(reader), (std::vector<std::string>{"b", "c"}));
  EXPECT_EQ(reader.report().entries().begin()->second.count, 2);
}

/// 100 MB without a line end, made on the way.
class Endless final : public ByteStream {
 public:
  std::size_t read(char* to, std::size_t size) override {
    largest_ = std::max(largest_, size);
    const std::size_t n = std::min(size, left_);
    std::fill(to, to + n, '7');
    left_ -= n;
    return n;
  }
  static inline std::size_t largest_ = 0;

 private:
  std::size_t left_ = 100'000'000;
};

TEST(LineReader, AHundredMegabytesInOneLineStayInBoundedMemory) {
  LineReader reader(std::make_unique<Endless>());
  EXPECT_FALSE(reader.next().has_value());
  EXPECT_EQ(reader.report().entries().begin()->second.count, 1);
  EXPECT_LE(Endless::largest_, 4u << 20);
}

}  // namespace
}  // namespace majak::io
