#include "scene/scene_file.h"

#include <gtest/gtest.h>

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
  EXPECT_EQ(find("textures").problem, "is no file in the scene's folder or below: a directory");
  for (const char* address : {"", "a\nb", "%00", "a%0Ab"}) EXPECT_FALSE(find(address).problem.empty()) << address;
}

}  // namespace
}  // namespace nlg
