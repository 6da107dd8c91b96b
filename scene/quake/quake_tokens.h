// Tokeniser of the text of entities and shader scripts of Quake III-family games.
#pragma once

#include <string_view>

namespace nlg {

// Words are parted by white space; "quoted words" may hold it; { and } are words of their own; // and /* */ are comments.
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

}  // namespace nlg
