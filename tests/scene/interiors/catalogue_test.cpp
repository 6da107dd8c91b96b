#include "scene/interiors/catalogue.h"

#include <gtest/gtest.h>

#include <cmath>

#include "scene/interiors/furniture_use.h"
#include "tests/input_error.h"
#include "tests/scene/scene_triangles.h"
#include "tiny_library.h"

namespace nlg {
namespace {

const char* const kChair = "name#7=Chair\ncategory#7=Living room\nmodel#7=/a/chair.obj\nwidth#7=45\ndepth#7=50.5\nheight#7=90\n";

std::string errorOf(const std::string& text) {
  return inputErrorOf([&] { parseCatalogue("test.sh3f", text); });
}

TEST(Catalogue, GivesSizesInMetresOfWidthHeightAndDepth) {
  const std::vector<CatalogueEntry> entries =
      parseCatalogue("test.sh3f", std::string("id=test\n") + kChair + "elevation#7=12.5\n");
  ASSERT_EQ(entries.size(), 1u);
  EXPECT_EQ(entries[0].name, "Chair");
  EXPECT_EQ(entries[0].model, "a/chair.obj");
  expectNear(entries[0].size_m, {0.45, 0.9, 0.505}, "width, height and depth", 1e-12);
  EXPECT_DOUBLE_EQ(entries[0].elevation_m, 0.125);
  EXPECT_DOUBLE_EQ(entries[0].top_m, 0.9) << "what says nothing of it carries things on its top";
  EXPECT_LT(parseCatalogue("", std::string(kChair) + "dropOnTopElevation#7=-1\n")[0].top_m, 0.0);
}

TEST(Catalogue, ReadsPropertiesAsJavaWritesThem) {
  const std::string text =
      "# comment \\\n! another\r\n  name#1 : Caf\\u00e9\\\n    table\r\ncategory#1 Living room\nmodel#1=/m.obj\nwidth#1=1\n"
      "depth#1=1\nheight#1=1\ntags#1=a\\=b\xe9";
  const std::vector<CatalogueEntry> entries = parseCatalogue("test.sh3f", text);
  ASSERT_EQ(entries.size(), 1u);
  EXPECT_EQ(entries[0].name, "Caf\xc3\xa9table");
  EXPECT_EQ(entries[0].category, "Living room");
  EXPECT_EQ(entries[0].tags, "a=b\xc3\xa9") << "ISO-8859-1 becomes UTF-8";
}

// Every prefix, and every single byte replaced: refused, or a piece as the header promises one.
TEST(Catalogue, TakesNothingButPiecesThatCanStand) {
  const auto takes = [](const std::string& text) {
    if (errorOf(text) != "no error") return false;
    for (const CatalogueEntry& entry : parseCatalogue("test.sh3f", text)) {
      EXPECT_FALSE(entry.name.empty() || entry.category.empty() || entry.model.empty()) << text;
      for (int axis = 0; axis < 3; ++axis) EXPECT_TRUE(entry.size_m[axis] > 0.0 && entry.size_m[axis] <= 100.0) << text;
      EXPECT_TRUE(entry.elevation_m >= 0.0 && entry.elevation_m <= 100.0 && std::abs(entry.top_m) <= 100.0) << text;
    }
    return true;
  };
  const std::string text = std::string(kChair) + "modelRotation#7=1 0 0 0 1 0 0 0 1\ntags#7=a\\u00e9\\\n b\n";
  ASSERT_TRUE(takes(text));
  int taken = 0, refused = 0;
  for (size_t i = 0; i < text.size(); ++i) {
    ++(takes(text.substr(0, i)) ? taken : refused);
    for (const char c : {'\0', '\\', '\n', '#', '=', '9', '\xff'}) {
      std::string changed = text;
      changed[i] = c;
      ++(takes(changed) ? taken : refused);
    }
  }
  EXPECT_GT(taken, 100);
  EXPECT_GT(refused, 100);
}

TEST(FurnitureUse, FollowsCategoryNameAndSize) {
  const auto useOf = [](const std::string& category, const std::string& name, const std::string& tags, double width, double depth,
                        double height) {
    CatalogueEntry entry;
    entry.category = category;
    entry.name = name;
    entry.tags = tags;
    entry.size_m = {width, height, depth};
    return furnitureUse(entry);
  };
  EXPECT_EQ(useOf("Bedroom", "Bed", "Double", 1.7, 2.17, 1.1), FurnitureUse::bed);
  EXPECT_EQ(useOf("Bedroom", "Bedside table", "Nightstand", 0.5, 0.5, 0.5), FurnitureUse::bedside);
  EXPECT_EQ(useOf("Living room", "Clear sofa", "Couch, Seat", 1.94, 0.76, 0.8), FurnitureUse::sofa);
  EXPECT_EQ(useOf("Living room", "Corner sofa", "Couch, Seat", 2.5, 1.9, 0.8), FurnitureUse::corner_sofa);
  EXPECT_EQ(useOf("Living room", "TV stand", "Cabinet", 1.35, 0.47, 0.53), FurnitureUse::tv_stand);
  EXPECT_EQ(useOf("Kitchen", "Upper cabinet", "Cupboard", 0.6, 0.41, 0.72), FurnitureUse::kitchen_wall);
  EXPECT_EQ(useOf("Characters", "Sitting male", "Human, People", 0.7, 0.9, 1.4), FurnitureUse::none);
  EXPECT_EQ(useOf("Characters", "Female", "Human, Woman", 0.5, 0.5, 1.65), FurnitureUse::person);
  EXPECT_EQ(useOf("Vehicles", "Bus", "Car", 2.8, 14.0, 3.7), FurnitureUse::none);
  EXPECT_EQ(useOf("Living room", "Table", "", 30.0, 20.0, 0.75), FurnitureUse::none) << "no table is 30 m long";
  EXPECT_EQ(useOf("Something else", "Chair", "", 0.5, 0.5, 0.9), FurnitureUse::none);
}

}  // namespace
}  // namespace nlg
