// SPDX-License-Identifier: Apache-2.0
#include "majak/io/atomic_file.hpp"

#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <functional>
#include <iterator>

#include "majak/core/error.hpp"

namespace majak::io {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class AtomicFileTest : public testing::Test {
 protected:
  AtomicFileTest() {
    std::string name = (fs::temp_directory_path() / "majak-atomic-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
  }
  ~AtomicFileTest() override { fs::remove_all(folder_); }

  static std::string content(const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  std::ptrdiff_t files() const {
    return std::distance(fs::directory_iterator(folder_), fs::directory_iterator());
  }

  fs::path folder_;
};

std::string message_of(const std::function<void()>& body) {
  try {
    body();
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

TEST_F(AtomicFileTest, IsNotThereBeforeCommitAndWholeAfterIt) {
  AtomicFile file(folder_ / "a.txt");
  file.write("one ");
  EXPECT_FALSE(fs::exists(folder_ / "a.txt"));
  file.write("two");
  file.commit();
  EXPECT_EQ(content(folder_ / "a.txt"), "one two");
  EXPECT_EQ(files(), 1);
}

TEST_F(AtomicFileTest, LargeContentArrivesUnchanged) {
  std::string all;
  AtomicFile file(folder_ / "large");
  for (int i = 0; i < 50000; ++i) {
    const std::string line = std::to_string(i) + "\n";
    all += line;
    file.write(line);
  }
  file.commit();
  EXPECT_EQ(content(folder_ / "large"), all);
}

TEST_F(AtomicFileTest, OldContentSurvivesAnUnfinishedWriterAndNoLitterStays) {
  write_file_atomically(folder_ / "a", "old");
  {
    AtomicFile file(folder_ / "a");
    file.write("new");
  }
  EXPECT_EQ(content(folder_ / "a"), "old");
  EXPECT_EQ(files(), 1);
  write_file_atomically(folder_ / "a", "new");
  EXPECT_EQ(content(folder_ / "a"), "new");
}

TEST_F(AtomicFileTest, TwoWritersOfOnePathDoNotMix) {
  AtomicFile first(folder_ / "a"), second(folder_ / "a");
  first.write("first");
  second.write("second");
  second.commit();
  first.commit();
  EXPECT_EQ(content(folder_ / "a"), "first");
  EXPECT_EQ(files(), 1);
}

TEST_F(AtomicFileTest, KilledWriterLeavesTheOldFileAndTheNextOneClearsUp) {
  write_file_atomically(folder_ / "a", "old");
  for (int i = 0; i < 3; ++i) {
    const pid_t child = ::fork();
    if (child == 0) {
      AtomicFile file(folder_ / "a");
      file.write(std::string(1 << 20, 'x'));
      ::kill(::getpid(), SIGKILL);
    }
    ::waitpid(child, nullptr, 0);
    EXPECT_EQ(content(folder_ / "a"), "old");
    EXPECT_EQ(files(), 2);  // the old file and one temporary file, however often
  }
  write_file_atomically(folder_ / "a", "new");
  EXPECT_EQ(content(folder_ / "a"), "new");
  EXPECT_EQ(files(), 1);
}

TEST_F(AtomicFileTest, LinkIsFollowedAndStaysALink) {
  write_file_atomically(folder_ / "target", "old");
  fs::create_symlink(folder_ / "target", folder_ / "link");
  write_file_atomically(folder_ / "link", "new");
  EXPECT_TRUE(fs::is_symlink(folder_ / "link"));
  EXPECT_EQ(content(folder_ / "target"), "new");
}

TEST_F(AtomicFileTest, MissingFolderAndFolderAsNameAreNamedInTheError) {
  const fs::path lost = folder_ / "nowhere" / "a";
  EXPECT_THAT(message_of([&] { AtomicFile file(lost); }),
              testing::AllOf(HasSubstr(lost.string()), HasSubstr("No such file")));
  EXPECT_THAT(message_of([&] { AtomicFile file(folder_); }),
              testing::AllOf(HasSubstr(folder_.string()), HasSubstr("directory")));
}

TEST_F(AtomicFileTest, FullDeviceIsAnErrorThatNamesIt) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  EXPECT_THAT(message_of([] { write_file_atomically("/dev/full", "x"); }),
              testing::AllOf(HasSubstr("/dev/full"), HasSubstr("No space left")));
  EXPECT_TRUE(fs::is_character_file("/dev/full"));
}

TEST_F(AtomicFileTest, FullDiskLeavesTheOldFile) {
  // A file size limit stands for the full disk: write() fails half way.
  write_file_atomically(folder_ / "a", "old");
  const auto previous = std::signal(SIGXFSZ, SIG_IGN);
  rlimit limit{};
  getrlimit(RLIMIT_FSIZE, &limit);
  const rlimit small{1000, limit.rlim_max};
  setrlimit(RLIMIT_FSIZE, &small);
  const std::string message =
      message_of([&] { write_file_atomically(folder_ / "a", std::string(5000, 'x')); });
  setrlimit(RLIMIT_FSIZE, &limit);
  std::signal(SIGXFSZ, previous);
  EXPECT_THAT(message, HasSubstr((folder_ / "a").string()));
  EXPECT_EQ(content(folder_ / "a"), "old");
  EXPECT_EQ(files(), 1);
}

}  // namespace
}  // namespace majak::io
