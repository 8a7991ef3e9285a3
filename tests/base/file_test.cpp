#include "strak/base/file.h"

#include <gtest/gtest.h>

#include <fstream>
#include <random>

#include "strak/base/error.h"

namespace strak {
namespace {

namespace fs = std::filesystem;

// A folder of its own for each test, gone afterwards.
class File : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("strak_file_test_" + std::to_string(std::random_device{}()));
    fs::create_directory(folder_);
  }
  void TearDown() override {
    fs::permissions(folder_, fs::perms::owner_all, fs::perm_options::add);
    fs::remove_all(folder_);
  }
  fs::path in(const char* name) const { return folder_ / name; }
  std::size_t count() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }

  fs::path folder_;
};

TEST_F(File, WritesAndReadsEveryByte) {
  std::string text;
  for (int i = 0; i < 100000; ++i) text.push_back(static_cast<char>(i % 256));
  writeFile(in("bytes.bin"), text);
  EXPECT_EQ(readFile(in("bytes.bin")), text);
  writeFile(in("bytes.bin"), "shorter");
  EXPECT_EQ(readFile(in("bytes.bin")), "shorter");
  EXPECT_EQ(count(), 1U);
}

TEST_F(File, KeepsTheOldFileWhenWritingFails) {
  writeFile(in("part.step"), "the old one");
  EXPECT_THROW(writeBeside(in("part.step"),
                           [](const fs::path& name) {
                             std::ofstream(name) << "half of the new o";
                             throw std::runtime_error("the writer fell over");
                           }),
               std::runtime_error);
  EXPECT_EQ(readFile(in("part.step")), "the old one");
  EXPECT_EQ(count(), 1U);
}

TEST_F(File, LeavesNothingWhenTheFirstWriteFails) {
  EXPECT_THROW(writeBeside(in("part.step"),
                           [](const fs::path& name) {
                             std::ofstream(name) << "half";
                             throw Failure("no");
                           }),
               Failure);
  EXPECT_EQ(count(), 0U);
}

TEST_F(File, ShowsTheNewFileOnlyWhenItIsComplete) {
  writeFile(in("a.txt"), "old");
  writeBeside(in("a.txt"), [&](const fs::path& name) {
    EXPECT_EQ(name.parent_path(), folder_);
    EXPECT_EQ(name.extension(), ".txt");  // writers that go by the ending must see the right one
    std::ofstream(name) << "new";
    EXPECT_EQ(readFile(in("a.txt")), "old");
  });
  EXPECT_EQ(readFile(in("a.txt")), "new");
}

TEST_F(File, FailsWhenTheWriterWroteNoFile) {
  writeFile(in("a.txt"), "old");
  EXPECT_THROW(writeBeside(in("a.txt"), [](const fs::path&) {}), Failure);
  EXPECT_EQ(readFile(in("a.txt")), "old");
}

TEST_F(File, NamesTheFolderThatDoesNotExist) {
  try {
    writeFile(in("nowhere") / "a.txt", "x");
    FAIL();
  } catch (const Failure& error) {
    EXPECT_NE(std::string(error.what()).find("there is no folder"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("nowhere"), std::string::npos);
  }
}

TEST_F(File, DoesNotReplaceAFolder) {
  fs::create_directory(in("here"));
  EXPECT_THROW(writeFile(in("here"), "x"), Error);
  EXPECT_TRUE(fs::is_directory(in("here")));
  EXPECT_EQ(count(), 1U);
}

TEST_F(File, SaysWhatCannotBeRead) {
  EXPECT_THROW(readFile(in("missing")), InvalidInput);
  EXPECT_THROW(readFile(folder_), InvalidInput);
  writeFile(in("empty"), "");
  EXPECT_EQ(readFile(in("empty")), "");
}

#ifdef __linux__
TEST_F(File, ReportsAFullDisk) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "this system has no /dev/full";
  // The name of the new file is the same every time, so a link of that name can lead it to a device that is always
  // full.
  fs::path beside;
  writeBeside(in("a.txt"), [&](const fs::path& name) {
    beside = name;
    std::ofstream(name) << "old";
  });
  fs::create_symlink("/dev/full", beside);
  try {
    writeFile(in("a.txt"), std::string(100000, 'x'));
    FAIL();
  } catch (const Failure& error) {
    EXPECT_NE(std::string(error.what()).find("disk"), std::string::npos);
  }
  EXPECT_EQ(readFile(in("a.txt")), "old");
  EXPECT_EQ(count(), 1U);
}
#endif

}  // namespace
}  // namespace strak
