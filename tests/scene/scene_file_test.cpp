#include "scene/archive/scene_file.h"

#include <gtest/gtest.h>

#include <fstream>
#include <utility>

#include "tests/temporary_folder.h"

namespace nlg {
namespace {

namespace fs = std::filesystem;

class FilesBeside : public testing::Test {
 protected:
  FilesBeside() {
    for (const char* sub : {"level", "level/textures", "maps"}) fs::create_directory(folder_ / sub);
    for (const char* name :
         {"level/wall.png", "level/textures/Wall 1.png", "level/textures/a+b.png", "level/100%41.png", "maps/secret.png"})
      folder_.write(name, name);
  }
  FileBeside find(const std::string& address) const { return findBeside(folder_ / "level/room.gltf", address); }

  TemporaryFolder folder_;
};

TEST_F(FilesBeside, AreFoundHoweverTheirAddressIsWritten) {
  const std::string wall = folder_ / "level/textures/Wall 1.png";
  for (const char* address : {"textures/Wall 1.png", "./textures/Wall 1.png", "textures/Wall%201.png", "textures\\Wall 1.png",
                              ".\\textures\\Wall%201.png", "textures%5CWall%201.png", "textures%5cWall 1.png",
                              "textures//Wall 1.png", "maps/../textures/Wall 1.png"}) {
    const FileBeside found = find(address);
    EXPECT_TRUE(fs::exists(found.path) && fs::equivalent(found.path, wall)) << address << ": " << found.problem;
    EXPECT_EQ(found.guess, "") << address;
  }
  EXPECT_EQ(find("textures/a+b.png").path, folder_ / "level/textures/a+b.png");
  EXPECT_EQ(find("100%41.png").path, folder_ / "level/100%41.png") << "a name that is there as it is goes before all others";
}

TEST_F(FilesBeside, ThatAreFoundByLessAreSaid) {
  EXPECT_EQ(find("Textures\\wall 1.PNG").guess, "textures/Wall 1.png") << "in other case";
  // accents composed in the file and not on disk, or the other way round; letters beyond ASCII
  std::ofstream(folder_ / "level/Wa\u0308nde.png") << "wall";
  std::ofstream(folder_ / "level/\u0421\u0422\u0415\u041d\u0410.png") << "wall";
  EXPECT_EQ(find("w\u00e4nde.png").guess, "Wa\u0308nde.png");
  EXPECT_EQ(find("W\u00c4NDE.PNG").guess, "Wa\u0308nde.png");
  EXPECT_EQ(find("\u0441\u0442\u0435\u043d\u0430.png").guess, "\u0421\u0422\u0415\u041d\u0410.png");
  EXPECT_EQ(find("C:\\work\\textures\\Wall 1.png").guess, "textures/Wall 1.png");
  EXPECT_EQ(find("file:///D:/work/wall.png").guess, "wall.png");
  EXPECT_EQ(find("/home/me/level/wall.png").guess, "wall.png");
  EXPECT_EQ(find("..\\textures\\Wall 1.png").guess, "textures/Wall 1.png");
}

TEST_F(FilesBeside, ThatAreNotThereOrElsewhereAreNotOpened) {
  EXPECT_EQ(find("none.png").problem, "is not there");
  EXPECT_EQ(find("a\\none.png").problem, "is not there (tried a\\none.png, a/none.png)");
  for (const std::string& address :
       {std::string("../maps/secret.png"), std::string("..%2fmaps%5Csecret.png"), folder_ / "maps/secret.png"}) {
    const FileBeside found = find(address);
    EXPECT_EQ(found.path, "") << address;
    EXPECT_EQ(found.problem.find("lies outside of the scene's folder and is not opened (tried "), 0u) << found.problem;
  }
  fs::create_symlink(folder_ / "maps/secret.png", folder_ / "level/link.png");
  EXPECT_EQ(find("link.png").problem, "is no file in the scene's folder or below: a link out of it");
  // into stores of git-annex and DVC, wherever they are, and to nothing that is only called like one
  const std::string digest = "0123456789abcdef0123456789abcdef", key = "MD5E-s3--" + digest + ".png";
  const std::pair<std::string, bool> stores[] = {{"super/.git/modules/level/annex/objects/aa/bb/" + key + "/" + key, true},
                                                 {"cache/files/md5/01/" + digest.substr(2), true},
                                                 {"annex/objects/aa/bb/" + key + "/other.png", false},
                                                 {"other/" + key + "/" + key, false},
                                                 {"annex/objects/WORM-s3--secret.png/WORM-s3--secret.png", false},
                                                 {"cache/01/secret", false}};
  for (const auto& [path, is_store] : stores) {
    const fs::path file = fs::path(folder_.string()) / "stores" / path;
    fs::create_directories(file.parent_path());
    std::ofstream(file) << "png";
    fs::remove(folder_ / "level/stored.png");
    fs::create_symlink(file, folder_ / "level/stored.png");
    EXPECT_EQ(find("stored.png").problem.empty(), is_store) << path;
  }
  // in a repository a store may hold what the folder links to
  fs::create_directory(folder_ / ".git");
  EXPECT_EQ(find("link.png").path, folder_ / "level/link.png");
  fs::create_symlink(folder_ / "maps/none.png", folder_ / "level/dangling.png");
  EXPECT_NE(find("dangling.png").problem.find("is no file in the scene's folder"), std::string::npos);
  EXPECT_EQ(find("textures").problem, "is no file in the scene's folder or below: a directory");
  for (const char* address : {"", "a\nb", "%00", "a%0Ab"}) EXPECT_FALSE(find(address).problem.empty()) << address;
}

TEST_F(FilesBeside, LieBesideTheFileThatASceneLinksTo) {
  fs::create_directories(folder_ / "library");
  for (const char* name : {"level.gltf", "level.bin", "both.bin"})
    std::ofstream(folder_ / (std::string("library/") + name)) << name;
  std::ofstream(folder_ / "level/both.bin") << "nearer";
  fs::create_symlink(folder_ / "library/level.gltf", folder_ / "level/linked.gltf");
  EXPECT_EQ(findBeside(folder_ / "level/linked.gltf", "level.bin").path, folder_ / "library/level.bin");
  EXPECT_EQ(findBeside(folder_ / "level/linked.gltf", "both.bin").path, folder_ / "level/both.bin");
  EXPECT_EQ(findBeside(folder_ / "level/linked.gltf", "none.bin").problem, "is not there");
  EXPECT_EQ(findBeside(folder_ / "level/linked.gltf", "../secret").path, "");
}

TEST_F(FilesBeside, AreToldOfInFewWords) {
  std::string address = "/elsewhere";
  for (int i = 0; i < 200; ++i) address += "/a folder of a long way";
  const std::string problem = find(address).problem;
  EXPECT_LT(problem.size(), 1000u);
  EXPECT_NE(problem.find("more"), std::string::npos) << problem;
}

}  // namespace
}  // namespace nlg
