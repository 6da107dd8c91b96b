#include "scene/interiors/furniture_use.h"

#include <algorithm>
#include <string_view>
#include <vector>

#include "scene/archive/pk3_archive.h"

namespace nlg {
namespace {

using Use = FurnitureUse;

// Bounds on a piece's box in metres: a rule holds for pieces within.
struct SizeRange {
  double least_height = 0.0, most_height = 100.0;
  double least_side = 0.0, most_side = 100.0;  // of the longer side of the footprint
};

// The first rule that fits says what a piece is for.
struct Rule {
  const char* category;  // "": any
  const char* any_of;    // words of the name or the tags, one of which must be there; "": no condition
  const char* none_of;   // words, none of which may be there
  Use use;
  SizeRange size = {};
};

const std::vector<Rule>& rules() {
  // the last rule of a category matches all that is left, mostly to keep it out
  static const std::vector<Rule> table = {
      // what no room of these houses holds
      {"vehicles", "", "", Use::none},
      {"staircases", "", "", Use::none},
      {"", "socket plug switch outlet money smoke detector cctv", "", Use::none},
      {"", "clothes shoes jewelry hanger", "basket rack washing washer dryer laundry cabinet", Use::none},
      {"doors and windows", "door", "garage screen elevator double glass window", Use::front_door},
      {"doors and windows", "", "", Use::none},

      {"characters", "human", "sitting lying", Use::person, {1.4, 2.0, 0.0, 1.0}},
      {"characters", "cat dog bulldog rabbit", "", Use::animal},
      {"characters", "", "", Use::none},

      {"exterior", "road", "", Use::none},
      {"exterior", "hedge bush", "", Use::hedge},
      {"exterior", "tree", "snow", Use::tree, {2.5, 8.0, 0.0, 9.0}},
      {"exterior", "seat bench bank", "", Use::garden_seat, {0.4, 1.5, 0.0, 2.7}},
      {"exterior", "table", "", Use::garden_table, {0.35, 1.0, 0.0, 2.1}},
      {"exterior",
       "fountain rock stone umbrella wheelbarrow mailbox swing seesaw trampoline sandpit house trashcan box hose barnum tent",
       "pool letters",
       Use::garden_thing,
       {0.2, 3.5, 0.0, 3.1}},
      {"exterior", "", "", Use::none},

      {"lights", "outdoor exterior flashlight camping candle", "", Use::none},
      {"lights", "wall spotlight artwork", "", Use::wall_lamp},
      {"lights", "fluorescent track", "", Use::ceiling_lamp},
      {"lights", "ceiling hanging pendant", "", Use::ceiling_lamp, {0.0, 0.2}},
      {"lights", "hanging pendant", "", Use::hanging_lamp, {0.2, 1.3, 0.0, 1.4}},
      {"lights", "", "japanese desk little", Use::hanging_lamp, {0.5, 0.8, 0.5, 0.6}},
      // size tells apart what words do not: a floor lamp from a table lamp
      {"lights", "lamp", "", Use::floor_lamp, {1.0, 2.2}},
      {"lights", "lamp lantern", "", Use::table_lamp, {0.2, 0.85}},
      {"lights", "", "", Use::none},

      {"bathroom", "radiator", "", Use::radiator},
      {"bathroom", "bath bathtub", "", Use::bath, {0.4, 1.2, 1.4, 1.9}},
      {"bathroom", "stall", "", Use::shower},
      {"bathroom", "toilets bidet", "", Use::toilet},
      {"bathroom", "washbasin vanity lavatory", "", Use::washbasin, {0.3, 2.3, 0.3, 1.9}},
      {"bathroom", "rack dispenser", "", Use::wall_thing},
      {"bathroom", "bathmat", "", Use::rug},
      {"bathroom", "basket", "", Use::storage},
      {"bathroom", "flacon bottle box pot soap", "", Use::small_thing},
      {"bathroom", "", "", Use::none},

      {"bedroom", "bedside", "", Use::bedside},
      {"bedroom", "sleeping mattress rack changing opened", "", Use::none},
      {"bedroom", "crib kid baby bunk child mezzanine captain's", "toy game", Use::child_bed, {0.4, 2.1, 0.8, 2.7}},
      {"bedroom", "convertible", "", Use::sofa},
      {"bedroom", "bed futon", "", Use::bed, {0.15, 1.4, 1.8, 2.4}},
      {"bedroom", "wardrobe closet", "", Use::wardrobe},
      {"bedroom", "chest dressing drawers", "", Use::chest, {0.5, 1.5}},
      {"bedroom", "shelves", "", Use::bookcase},
      {"bedroom", "rocking house", "", Use::toy},
      {"bedroom", "toy decoration game clock handbag briefcase", "", Use::small_thing, {0.02, 0.5, 0.0, 0.5}},
      {"bedroom", "", "", Use::none},

      {"kitchen", "refrigerator fridge freezer", "chest", Use::fridge, {1.1, 2.1}},
      {"kitchen", "high", "chair baby", Use::fridge, {1.8, 2.3}},
      {"kitchen", "hood", "cabinet", Use::hood},
      {"kitchen", "corner", "", Use::none},
      {"kitchen", "upper glass", "drink cutlery beer", Use::kitchen_wall, {0.5, 0.9, 0.3, 1.2}},
      {"kitchen", "sink", "", Use::kitchen_sink, {0.7, 1.4}},
      {"kitchen", "washing washer", "", Use::laundry, {0.6, 1.0}},
      {"kitchen", "island", "extension", Use::island, {0.7, 1.0}},
      {"kitchen", "lower drawers", "", Use::kitchen_base, {0.8, 1.0}},
      {"kitchen", "stove oven cooker", "", Use::cooker, {0.55, 1.2, 0.55, 1.1}},
      {"kitchen", "stool chair", "baby", Use::bar_stool, {0.6, 1.2}},
      {"kitchen", "broom cleaning cutlery tool", "", Use::none},
      {"kitchen", "", "", Use::kitchen_thing, {0.03, 0.45, 0.04, 0.62}},
      {"kitchen", "", "", Use::none},

      {"living room", "television tv contemporary", "cabinet stand dvd remote electronics shelves", Use::tv, {0.3, 1.0}},
      {"living room", "wall", "", Use::wall_tv},
      {"living room", "tv", "stand cabinet remote dvd shelves", Use::tv, {0.3, 0.9}},
      {"living room", "stand", "", Use::tv_stand, {0.3, 0.8}},
      {"living room", "contemporary", "", Use::bookcase},
      {"living room", "corner", "", Use::corner_sofa, {0.5, 1.2, 2.2, 3.6}},
      {"living room", "sofa couch", "", Use::sofa, {0.5, 1.3, 1.3, 2.9}},
      {"living room", "rug carpet", "", Use::rug},
      {"living room", "piano", "bench", Use::piano},
      {"living room", "fireplace", "", Use::fireplace},
      {"living room", "stool", "", Use::bar_stool, {0.6, 1.2}},
      {"living room", "armchair puff", "", Use::armchair},
      {"living room", "ryokan children child kid", "", Use::none},
      {"living room", "chair", "bench", Use::chair, {0.7, 1.2, 0.3, 0.85}},
      {"living room", "coffee", "", Use::coffee_table},
      {"living room", "bar", "", Use::none},
      {"living room", "table", "", Use::dining_table, {0.68, 0.95, 0.78, 2.4}},
      {"living room", "table", "", Use::side_table, {0.4, 0.8, 0.0, 0.8}},
      {"living room", "bookcase bookshelf shelves", "", Use::bookcase},
      {"living room", "dresser box aquarium", "", Use::chest},
      {"living room", "bench puff", "", Use::side_table},
      {"living room", "christmas", "", Use::plant, {1.0}},
      {"living room", "plant flowers patio", "deck outdoor", Use::plant, {0.55, 2.2, 0.0, 1.3}},
      {"living room", "plant flowers patio decoration", "deck outdoor", Use::small_plant, {0.08, 0.55, 0.0, 0.5}},
      {"living room", "electronics music", "guitar", Use::small_thing, {0.02, 0.4, 0.1, 0.6}},
      {"living room", "", "", Use::none},

      {"office", "notebook computer", "printer", Use::computer},
      {"office", "desk technical", "", Use::desk, {0.65, 1.2, 0.9, 2.0}},
      {"office", "table", "", Use::dining_table, {0.65, 0.95, 0.9, 2.4}},
      {"office", "seat", "school", Use::office_chair, {0.7, 1.2}},
      {"office", "bookcase", "", Use::bookcase},
      {"office", "box", "letter", Use::bookcase, {1.0}},
      {"office", "filing safe", "", Use::filing},
      {"office", "cooler", "", Use::cooler},
      {"office", "board", "", Use::board},
      {"office", "dustbin", "", Use::storage},
      {"office", "printer phone penbox tray calendar", "", Use::small_thing},
      {"office", "", "", Use::none},

      {"miscellaneous", "radiator", "", Use::radiator, {0.3, 1.0}},
      {"miscellaneous", "clock conditioner dart intercom extinguisher", "external", Use::wall_thing, {0.1, 0.8}},
      {"miscellaneous", "billiard tennis football", "bat", Use::game, {0.7, 1.1, 1.2}},
      {"miscellaneous", "fitness sport", "game tower", Use::fitness, {0.7, 1.6}},
      {"miscellaneous",
       "storage box barrel suitcase ladder wheelchair clothes workbench stereo speaker",
       "heater container electronics hanger",
       Use::storage,
       {0.2, 1.9, 0.2, 1.3}},
      {"miscellaneous",
       "flowers vase picture speaker fan radio stereo photo gift",
       "ceiling",
       Use::small_thing,
       {0.08, 0.6, 0.05, 0.5}},
      {"miscellaneous", "flowers", "", Use::plant, {0.5}},
      {"miscellaneous", "book", "", Use::small_thing},
  };
  return table;
}

// Runs of letters, digits and apostrophes, in lower case.
std::vector<std::string> lowerWords(const std::string& text) {
  std::vector<std::string> words(1);
  for (const char c : lowerCase(text)) {
    const bool is_letter = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '\'';
    if (is_letter) words.back().push_back(c);
    if (!is_letter && !words.back().empty()) words.emplace_back();
  }
  return words;
}

bool hasAny(const std::vector<std::string>& words, std::string_view wanted) {
  size_t at = 0;
  while (at < wanted.size()) {
    const size_t end = std::min(wanted.find(' ', at), wanted.size());
    if (std::find(words.begin(), words.end(), wanted.substr(at, end - at)) != words.end()) return true;
    at = end + 1;
  }
  return false;
}

bool fits(const SizeRange& bounds, const glm::dvec3& size_m) {
  const double side = std::max(size_m.x, size_m.z);
  return size_m.y >= bounds.least_height && size_m.y <= bounds.most_height && side >= bounds.least_side &&
         side <= bounds.most_side;
}

}  // namespace

FurnitureUse furnitureUse(const CatalogueEntry& entry) {
  const std::string category = lowerCase(entry.category);
  const std::vector<std::string> words = lowerWords(entry.name + " " + entry.tags);
  for (const Rule& rule : rules()) {
    const std::string_view wanted = rule.any_of;
    if (rule.category[0] != '\0' && category != rule.category) continue;
    if (!wanted.empty() && !hasAny(words, wanted)) continue;
    if (!hasAny(words, rule.none_of) && fits(rule.size, entry.size_m)) return rule.use;
  }
  return Use::none;
}

}  // namespace nlg
