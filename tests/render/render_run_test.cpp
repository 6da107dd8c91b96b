#include "render/render_run.h"

#include <gtest/gtest.h>
#include <png.h>

#include <filesystem>

#include "tests/input_error.h"
#include "tests/temporary_folder.h"
#include "tool/atomic_file.h"
#include "tool/error.h"

namespace nlg {
namespace {

using Json = nlohmann::ordered_json;

class RenderRun : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return folder_ / name; }

  RenderRequest request(const std::string& name) const {
    RenderRequest r;
    r.scene = "house:1";
    r.out = path(name);
    r.width = 48;
    r.height = 32;
    r.samples = 1;
    r.truth_rays = 8;
    return r;
  }

  static BakeOptions options(int threads = 2) {
    BakeOptions o;
    o.threads = threads;
    return o;
  }

  const TemporaryFolder folder_;
};

#define EXPECT_NAMES(text, part) EXPECT_NE((text).find(part), std::string::npos) << (text)

TEST_F(RenderRun, WritesAPictureThatSaysHowItWasMade) {
  RenderRequest r = request("view.png");
  r.exposure = 2.5;
  const Json said = renderScene(r, options());
  EXPECT_EQ(said["scene"], "house_1");
  EXPECT_EQ(said["exposure"], 2.5);
  EXPECT_EQ(said["exposure_is_automatic"], false);
  EXPECT_EQ(said["pictures"][0]["method"], "truth");
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  ASSERT_NE(png_image_begin_read_from_file(&header, r.out.c_str()), 0) << header.message;
  EXPECT_EQ(header.width, 48u);
  EXPECT_EQ(header.height, 32u);
  header.format = PNG_FORMAT_RGB;
  std::vector<uint8_t> pixels(PNG_IMAGE_SIZE(header));
  // libpng checks every chunk's checksum
  EXPECT_NE(png_image_finish_read(&header, nullptr, pixels.data(), 0, nullptr), 0) << header.message;
  EXPECT_EQ(header.warning_or_error, 0u) << header.message;
  const std::string bytes = readFile(r.out);
  EXPECT_NAMES(bytes, std::string("iTXtExposure") + std::string(5, '\0') + "2.5");
  EXPECT_NAMES(bytes, "\"eye_m\"");
}

TEST_F(RenderRun, LooksFromTheScenesOwnCamerasByNameOrNumber) {
  RenderRequest r = request("view.png");
  r.scene = "two_rooms";
  const Json own = renderScene(r, options())["camera"];
  r.camera = "lit room";
  EXPECT_EQ(renderScene(r, options())["camera"], own);
  r.camera = "1";
  const Json second = renderScene(r, options())["camera"];
  EXPECT_NE(second, own);
  r.camera = "dark room";
  EXPECT_EQ(renderScene(r, options())["camera"], second);
  r.camera = "bath room";
  EXPECT_NAMES(errorOfCall<UsageError>([&] { renderScene(r, options()); }), "--camera: expected one of 'lit room', 'dark room'");
}

TEST_F(RenderRun, ViewFromInsideASolidIsDrawn) {
  RenderRequest r = request("view.png");
  r.eye = {0, -0.05, 0};
  r.look = {1, -0.05, 0};
  renderScene(r, options());
  EXPECT_TRUE(std::filesystem::exists(r.out));
}

}  // namespace
}  // namespace nlg
