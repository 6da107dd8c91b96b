// Parses a Quake III level's entities: positions of its submodels (doors, platforms), and all other keys.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

namespace nlg {

// Tokeniser of the text of entities and shader scripts of Quake III-family games. Words are parted by white space; "quoted words" may hold it; { and } are words of their own; // and /* */ are comments.
// Never fails: what ends too early ends there.
class QuakeTokens {
 public:
  explicit QuakeTokens(std::string_view text) : text_(text) {}

  // false at the end of the text
  bool next(std::string_view* word);
  // The same, but false also at the end of the line; the word that follows on another line is still to be read.
  bool nextOnLine(std::string_view* word);

 private:
  void skipSpace(bool stays_on_line);

  std::string_view text_;
  size_t at_ = 0;
};

// Values by key, as written; of a key that comes twice the last one. Views into the entities' text.
using BspEntity = std::map<std::string_view, std::string_view>;

// The text of a key; empty when the entity has none.
std::string_view textOf(const BspEntity& entity, std::string_view key);
// Three numbers within 2^20; nothing when the text is anything else.
std::optional<glm::dvec3> threeNumbers(std::string_view text);
// A number within 2^20, read as far as one goes, as the game's tools do ("300 " and "300x" are 300); nothing when none is there.
std::optional<double> leadingNumber(std::string_view text);

// path     only named in errors
// text     must outlive what is returned
// throws   InputError naming the entity on: more than 2^16 entities, text between them
std::vector<BspEntity> readEntities(const std::string& path, std::string_view text);

// Where players begin, of either kind that single and team levels have; those without an origin are left out.
struct BspStart {
  std::string name;              // the class, and how many of it came before: "info_player_deathmatch 2"
  glm::dvec3 origin_units{0.0};  // of the player's body
  double turn_degrees = 0.0;     // from x towards y
};
std::vector<BspStart> playerStarts(const std::vector<BspEntity>& entities);

struct BspPlacement {
  std::string classname;         // of the entity that shows the model: "func_door"; empty when none does
  glm::dvec3 origin_units{0.0};  // its vertices are relative to this, in the game's units
};

// One for each model of the level; of several entities that name a model the first one counts. Model 0 stands at the origin.
//
// path     only named in errors
// throws   InputError naming the entity on: a model that is not there, an origin that is no three numbers within 2^20 units
std::vector<BspPlacement> readPlacements(const std::string& path, const std::vector<BspEntity>& entities, size_t model_count);

}  // namespace nlg
