#include "viewer/data_script.h"

#include <gtest/gtest.h>

#include <vector>

#include "tool/base64.h"

namespace nlg {
namespace {

TEST(DataScript, BeginsEveryArrayAtAMultipleOfFourBytes) {
  DataScript script("level");
  const std::vector<uint8_t> bytes = {1, 2, 3, 4, 5};
  const std::vector<float> floats = {1.0f, -2.0f};
  script.add("kinds", bytes);
  script.add("places", floats);
  script.add("nothing", std::span<const uint32_t>());
  const std::string text = script.text();
  EXPECT_EQ(text.rfind("nlgReceive(\"level\", ", 0), 0u) << text;
  EXPECT_NE(text.find("\"kinds\":[\"Uint8Array\",0,5]"), std::string::npos) << text;
  EXPECT_NE(text.find("\"places\":[\"Float32Array\",8,2]"), std::string::npos) << text;
  EXPECT_NE(text.find("\"nothing\":[\"Uint32Array\",16,0]"), std::string::npos) << text;
  // 5 bytes, 3 of padding, 1.0f, -2.0f
  EXPECT_NE(text.find(base64(std::string("\1\2\3\4\5\0\0\0\0\0\x80\x3f\0\0\0\xc0", 16))), std::string::npos) << text;
}

// A level's name may be anything: it must neither end the script nor break its encoding.
TEST(DataScript, TakesAnyName) {
  DataScript script("scene");
  script.facts["scene"] = "\"); alert(1); //\n\xff</script>";
  const std::string text = script.text();
  EXPECT_EQ(text.find('\n'), text.size() - 1);
  EXPECT_NE(text.find("\\\"); alert(1); //\\n\\ufffd"), std::string::npos) << text;
}

}  // namespace
}  // namespace nlg
