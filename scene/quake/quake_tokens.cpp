#include "scene/quake/quake_tokens.h"

#include <algorithm>

namespace nlg {
namespace {

bool isSpace(char c) { return static_cast<unsigned char>(c) <= ' '; }

}  // namespace

void QuakeTokens::skipSpace(bool stays_on_line) {
  while (at_ < text_.size()) {
    const std::string_view rest = text_.substr(at_);
    if (rest.starts_with("//")) {
      at_ = std::min(text_.find('\n', at_), text_.size());
    } else if (rest.starts_with("/*")) {
      const size_t end = text_.find("*/", at_ + 2);
      at_ = end == std::string_view::npos ? text_.size() : end + 2;
    } else if (isSpace(rest[0]) && !(stays_on_line && rest[0] == '\n')) {
      ++at_;
    } else {
      return;
    }
  }
}

bool QuakeTokens::next(std::string_view* word) {
  skipSpace(false);
  if (at_ >= text_.size()) return false;
  if (text_[at_] == '"') {
    const size_t end = std::min(text_.find('"', at_ + 1), text_.size());
    *word = text_.substr(at_ + 1, end - at_ - 1);
    at_ = std::min(end + 1, text_.size());
    return true;
  }
  const size_t start = at_++;
  if (text_[start] != '{' && text_[start] != '}') {
    while (at_ < text_.size() && !isSpace(text_[at_]) && text_[at_] != '"' && text_[at_] != '{' && text_[at_] != '}') {
      ++at_;
    }
  }
  *word = text_.substr(start, at_ - start);
  return true;
}

bool QuakeTokens::nextOnLine(std::string_view* word) {
  skipSpace(true);
  if (at_ >= text_.size() || text_[at_] == '\n') return false;
  return next(word);
}

}  // namespace nlg
