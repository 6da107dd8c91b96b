#include "scene/archive/pk3_archive.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "hand_built_bsp.h"
#include "tests/input_error.h"
#include "tool/error.h"

namespace nlg {
namespace {

class Pk3ArchivesTest : public testing::Test {
 protected:
  // The line of the InputError that mounting path, and reading an entry, gives.
  static std::string errorOf(const std::string& path, const std::string& entry = "a.txt", size_t max_bytes = 1 << 20) {
    return inputErrorOf([&] { Pk3Archives(path).read(entry, max_bytes); });
  }
  static void expectError(const std::string& words, const std::string& error) {
    EXPECT_NE(error.find(words), std::string::npos) << "got: " << error;
  }
  // The archive's bytes with all occurrences of one text replaced by another of the same length.
  static std::string withNames(std::string bytes, const std::string& from, const std::string& to) {
    EXPECT_EQ(from.size(), to.size());
    for (size_t at = bytes.find(from); at != std::string::npos; at = bytes.find(from, at + 1)) bytes.replace(at, from.size(), to);
    return bytes;
  }

  TemporaryFolder folder_;
};

TEST_F(Pk3ArchivesTest, GivesBackWhatWasPacked) {
  std::string large;
  for (int i = 0; i < 100000; ++i) large += static_cast<char>((i % 1009) * (i % 1009) >> 3);
  for (const int method : {ZIP_CM_STORE, ZIP_CM_DEFLATE}) {
    const std::string path = writeZip(
        folder_ / "a.pk3", {{"a.txt", "alpha"}, {"sub/large.bin", large}, {"empty", ""}, {"folder/", ""}}, {false, method});
    const Pk3Archives archives(path);
    EXPECT_EQ(archives.read("a.txt", 5), "alpha");
    EXPECT_EQ(archives.read("sub/large.bin", large.size()), large);
    EXPECT_EQ(archives.read("empty", 0), "");
    EXPECT_FALSE(archives.has("folder"));
    EXPECT_FALSE(archives.has("folder/"));
  }
}

TEST_F(Pk3ArchivesTest, LaterArchivesHideEarlierOnesWithoutRegardToCase) {
  writeZip(folder_ / "pak1.pk3", {{"maps/One.bsp", "old"}, {"maps/two.bsp", "two"}});
  writeZip(folder_ / "PAK2.PK3", {{"MAPS/one.BSP", "new"}});
  writeZip(folder_ / "zz.zip", {{"maps/one.bsp", "no archive of the game"}});
  const Pk3Archives archives(folder_.string());
  EXPECT_EQ(archives.read("maps/ONE.bsp", 10), "new");
  EXPECT_EQ(archives.read("maps/two.bsp", 10), "two");
  EXPECT_EQ(archives.names("maps/", ".bsp"), (std::vector<std::string>{"maps/one.bsp", "maps/two.bsp"}));
  EXPECT_LT(archives.archiveIndex("maps/two.bsp"), archives.archiveIndex("maps/one.bsp"));
}

TEST_F(Pk3ArchivesTest, RefusesPathsWithoutArchives) {
  expectError("no file of this name", errorOf(folder_ / "missing.pk3"));
  expectError(".pk3 files, got none", errorOf(folder_.string()));
  expectError("a device", errorOf("/dev/null"));
  ASSERT_EQ(::mkfifo((folder_ / "pipe.pk3").c_str(), 0600), 0);
  expectError("a pipe", errorOf(folder_ / "pipe.pk3"));
  expectError("archive", errorOf(folder_.write("text.pk3", "this is no archive")));
  expectError("archive", errorOf(folder_.write("empty.pk3", "")));
}

TEST_F(Pk3ArchivesTest, RefusesEntriesThatAreNotThereOrTooLarge) {
  const std::string path = writeZip(folder_ / "a.pk3", {{"a.txt", "alpha"}});
  expectError("\"b.txt\": expected a file of that name", errorOf(path, "b.txt"));
  expectError("at most 4 bytes", errorOf(path, "a.txt", 4));
}

TEST_F(Pk3ArchivesTest, RefusesNamesThatLeaveTheArchive) {
  const std::string whole = fileBytes(writeZip(folder_ / "a.pk3", {{"some/name.txt", "alpha"}}));
  for (const char* name :
       {"some/../a.txt", "/ome/name.txt", "..me/../a.txt", "some\\name.txt", "c:me/name.txt", "some/\name.txt"}) {
    const std::string error = errorOf(folder_.write("hostile.pk3", withNames(whole, "some/name.txt", name)));
    expectError("a name inside the archive", error);
    EXPECT_EQ(error.find('\n'), std::string::npos) << "an error is one line";
  }
  // dots alone are no way out
  const std::string harmless = folder_.write("dots.pk3", withNames(whole, "some/name.txt", "..me/..ame.tx"));
  EXPECT_EQ(Pk3Archives(harmless).read("..me/..ame.tx", 10), "alpha");
}

TEST_F(Pk3ArchivesTest, ChangedContentIsFoundByItsChecksum) {
  std::string bytes = fileBytes(writeZip(folder_ / "a.pk3", {{"a.txt", "alpha"}}, {false, ZIP_CM_STORE}));
  bytes.replace(bytes.find("alpha"), 5, "alphb");
  expectError("a.txt", errorOf(folder_.write("changed.pk3", bytes)));
}

}  // namespace
}  // namespace nlg
