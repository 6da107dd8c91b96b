#include "render/irradiance_table.h"

#include <gtest/gtest.h>

#include "tests/temporary_folder.h"
#include "tool/atomic_file.h"
#include "tool/error.h"

namespace nlg {
namespace {

const std::string kHeader = "x,y,z,nx,ny,nz\n";

// Nothing shines but an even sky.
BakeOptions underSky(const std::vector<std::string>& colour) {
  BakeOptions options;
  options.scene_light.sky = colour;
  options.scene_light.sun = {"0"};
  return options;
}

TEST(IrradianceTable, ReadsPlacesRelativeToTheOriginAndNormalsOfAnyLength) {
  const std::vector<Receiver> found = receiversFromCsv("p.csv", kHeader + "1,2,3,0,0,-5\r\n-1e3,0.5,7,1,0,0", {1, 1, 1});
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].position_m, glm::dvec3(0, 1, 2));
  EXPECT_EQ(found[0].normal, glm::vec3(0, 0, -1));
  EXPECT_EQ(found[1].position_m, glm::dvec3(-1001, -0.5, 6));
  EXPECT_TRUE(receiversFromCsv("p.csv", kHeader, {0, 0, 0}).empty());
}

TEST(IrradianceTable, WritesPiTimesTheRadianceOfAnEvenSkyHighAboveAScene) {
  const TemporaryFolder folder;
  const IrradianceRequest request{"house:1", folder / "places.csv", folder / "out.csv", 64};
  writeFileAtomically(request.places, kHeader + "1.5,1000,2,0,2,0\n");
  const BakeOptions options = underSky({"1", "2", "0"});
  writeIrradianceTable(request, options);
  const std::string table = readFile(request.out);
  const std::string begin = "x,y,z,nx,ny,nz,r,g,b,dr,dg,db\n1.5,1000,2,0,1,0,";
  ASSERT_EQ(table.substr(0, begin.size()), begin);
  double red = 0.0, green = 0.0, blue = 1.0;
  ASSERT_EQ(std::sscanf(table.c_str() + begin.size(), "%lf,%lf,%lf", &red, &green, &blue), 3) << table;
  // every ray meets the sky: the sum of equal shares of pi, rounded as floats are
  EXPECT_NEAR(red, 3.14159265, 1e-5);
  EXPECT_NEAR(green, 2 * 3.14159265, 2e-5);
  EXPECT_EQ(blue, 0.0);
  EXPECT_THROW(writeIrradianceTable({request.scene, request.places, request.places, 64}, options), UsageError);
}

TEST(IrradianceTable, LightsAPointThatLiesOnASurface) {
  const TemporaryFolder folder;
  // a floor whose height is no float, as exporters write them
  writeFileAtomically(folder / "floor.obj", "v -9 .1 -9\nv 9 .1 -9\nv 9 .1 9\nv -9 .1 9\nf 4 3 2 1\n");
  const IrradianceRequest request{folder / "floor.obj", folder / "places.csv", folder / "out.csv", 64};
  writeFileAtomically(request.places, kHeader + "1.5,.1,2,0,1,0\n1.5,.09999999,2,0,1,0\n");
  writeIrradianceTable(request, underSky({"1", "1", "1"}));
  const std::string table = readFile(request.out);
  size_t row = 0;
  for (int i = 0; i < 2; ++i) {
    row = table.find('\n', row) + 1;
    double red = 0.0;
    ASSERT_EQ(std::sscanf(table.c_str() + row, "%*[^,],%*[^,],%*[^,],%*[^,],%*[^,],%*[^,],%lf", &red), 1) << table;
    EXPECT_NEAR(red, 3.14159265, 1e-4) << i;
  }
}

}  // namespace
}  // namespace nlg
