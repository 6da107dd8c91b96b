// The table from names of catalogue pieces to their use in a house.
#pragma once

#include "scene/interiors/catalogue.h"

namespace nlg {

// clang-format off
enum class FurnitureUse {
  none,  // never placed: vehicles, clothes that lie about, sockets, what is too small or too large for a room
  bed, child_bed, bedside, wardrobe, chest, bookcase, desk, filing,
  sofa, corner_sofa, armchair, coffee_table, side_table, tv_stand, tv, wall_tv, piano, fireplace, rug,
  dining_table, chair, office_chair, bar_stool,
  island, kitchen_base, kitchen_sink, kitchen_wall, cooker, hood, fridge, laundry,
  bath, shower, toilet, washbasin,
  plant, small_plant, floor_lamp, table_lamp, hanging_lamp, ceiling_lamp, wall_lamp, radiator,
  wall_thing, computer, kitchen_thing, small_thing, toy, board, cooler, storage, game, fitness,
  person, animal, front_door, tree, hedge, garden_seat, garden_table, garden_thing
};
// clang-format on

FurnitureUse furnitureUse(const CatalogueEntry& entry);

}  // namespace nlg
