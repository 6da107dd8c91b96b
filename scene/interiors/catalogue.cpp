#include "scene/interiors/catalogue.h"

#include <charconv>
#include <cmath>
#include <map>

#include "tool/error.h"

namespace nlg {
namespace {

constexpr double kLargestCm = 1e4;
constexpr std::string_view kBlank = " \t\f";

void appendUtf8(std::string* text, unsigned code) {
  if (code < 0x80) {
    text->push_back(static_cast<char>(code));
  } else if (code < 0x800) {
    text->push_back(static_cast<char>(0xc0 | (code >> 6)));
    text->push_back(static_cast<char>(0x80 | (code & 0x3f)));
  } else {
    text->push_back(static_cast<char>(0xe0 | (code >> 12)));
    text->push_back(static_cast<char>(0x80 | ((code >> 6) & 0x3f)));
    text->push_back(static_cast<char>(0x80 | (code & 0x3f)));
  }
}

// Java's properties: ISO-8859-1, comments behind # or !, lines that end in a backslash go on.
class PropertiesReader {
 public:
  PropertiesReader(const std::string& path, std::string_view text) : path_(path), text_(text) {}

  // The next key and value; false at the end.
  bool next(std::string* key, std::string* value) {
    std::string line;
    do {
      if (!nextLine(&line)) return false;
    } while (line.empty() || line[0] == '#' || line[0] == '!');
    const size_t end = keyEnd(line);
    *key = unescaped(std::string_view(line).substr(0, end));
    size_t at = line.find_first_not_of(kBlank, end);
    if (at != std::string::npos && (line[at] == '=' || line[at] == ':')) at = line.find_first_not_of(kBlank, at + 1);
    *value = at == std::string::npos ? "" : unescaped(std::string_view(line).substr(at));
    return true;
  }

 private:
  // A logical line without the blanks before it; comments do not go on.
  bool nextLine(std::string* line) {
    line->clear();
    bool goes_on = true;
    if (at_ >= text_.size()) return false;
    while (goes_on && at_ < text_.size()) {
      const size_t end = std::min(text_.find_first_of("\n\r", at_), text_.size());
      std::string_view part = text_.substr(at_, end - at_);
      at_ = end + (text_.substr(end, 2) == "\r\n" ? 2 : 1);
      ++line_number_;
      part.remove_prefix(std::min(part.find_first_not_of(kBlank), part.size()));
      const bool is_comment = line->empty() && !part.empty() && (part[0] == '#' || part[0] == '!');
      const size_t last = part.find_last_not_of('\\');
      const size_t slashes = part.size() - (last == std::string_view::npos ? 0 : last + 1);
      goes_on = !is_comment && slashes % 2 == 1;
      if (goes_on) part.remove_suffix(1);
      line->append(part);
    }
    return true;
  }

  static size_t keyEnd(const std::string& line) {
    for (size_t i = 0; i < line.size(); ++i) {
      if (line[i] == '\\') {
        ++i;
      } else if (line[i] == '=' || line[i] == ':' || kBlank.find(line[i]) != std::string_view::npos) {
        return i;
      }
    }
    return line.size();
  }

  std::string unescaped(std::string_view raw) const {
    std::string text;
    for (size_t i = 0; i < raw.size(); ++i) {
      if (raw[i] != '\\' || i + 1 == raw.size()) {
        appendUtf8(&text, static_cast<unsigned char>(raw[i]));
      } else if (raw[++i] == 'u') {
        unsigned code = 0;
        const std::string_view digits = raw.substr(i + 1, 4);
        const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), code, 16);
        if (digits.size() != 4 || error != std::errc() || end != digits.data() + 4)
          throw InputError(path_, "line " + std::to_string(line_number_), "four hexadecimal digits behind \\u",
                           std::string(digits));
        appendUtf8(&text, code);
        i += 4;
      } else {
        text.push_back(raw[i] == 't' ? '\t' : raw[i] == 'n' ? '\n' : raw[i] == 'r' ? '\r' : raw[i] == 'f' ? '\f' : raw[i]);
      }
    }
    return text;
  }

  const std::string& path_;
  std::string_view text_;
  size_t at_ = 0, line_number_ = 0;
};

// The properties of one number.
class PieceProperties {
 public:
  PieceProperties(const std::string& path, uint32_t number, const std::map<std::string, std::string>& properties)
      : path_(path), place_("piece " + std::to_string(number)), properties_(properties) {}

  CatalogueEntry read() const {
    CatalogueEntry entry;
    entry.name = text("name");
    entry.category = text("category");
    entry.model = text("model");
    entry.model.erase(0, std::min(entry.model.find_first_not_of('/'), entry.model.size()));
    if (entry.model.empty()) fail("a model", "a path of slashes alone");
    const auto tags = properties_.find("tags");
    if (tags != properties_.end()) entry.tags = tags->second;
    entry.size_m = {metres("width"), metres("height"), metres("depth")};
    for (int axis = 0; axis < 3; ++axis) {
      if (!(entry.size_m[axis] > 0.0)) fail("sizes above 0", std::to_string(entry.size_m[axis]) + " m");
    }
    if (properties_.count("elevation") > 0) entry.elevation_m = std::max(0.0, metres("elevation"));
    entry.top_m = properties_.count("dropOnTopElevation") > 0 ? metres("dropOnTopElevation") : entry.size_m.y;
    if (properties_.count("modelRotation") > 0) entry.rotation = rotation(text("modelRotation"));
    return entry;
  }

 private:
  [[noreturn]] void fail(const std::string& expected, const std::string& got) const {
    throw InputError(path_, place_, expected, got.substr(0, 80));
  }

  const std::string& text(const std::string& key) const {
    const auto found = properties_.find(key);
    if (found == properties_.end() || found->second.empty()) fail("a " + key, "none");
    return found->second;
  }

  double number(const std::string& key, std::string_view word) const {
    double value = 0.0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value))
      fail(key + " of decimal numbers", std::string(word));
    return value;
  }

  double metres(const std::string& key) const {
    std::string_view word = text(key);
    word = word.substr(0, word.find_last_not_of(kBlank) + 1);
    const double centimetres = number(key, word);
    if (!(std::abs(centimetres) <= kLargestCm)) fail(key + " within 10000 cm", std::string(word));
    return 0.01 * centimetres;
  }

  glm::dmat3 rotation(std::string_view words) const {
    constexpr size_t kNumbers = 9;
    glm::dmat3 rows(0.0);
    size_t count = 0;
    for (size_t at = words.find_first_not_of(kBlank); at != std::string_view::npos; ++count) {
      const size_t end = std::min(words.find_first_of(kBlank, at), words.size());
      if (count == kNumbers) fail("a modelRotation of nine numbers", "more");
      rows[static_cast<int>(count) / 3][static_cast<int>(count) % 3] = number("modelRotation", words.substr(at, end - at));
      at = words.find_first_not_of(kBlank, end);
    }
    if (count != kNumbers) fail("a modelRotation of nine numbers", std::to_string(count));
    double deviation = std::abs(glm::dot(glm::cross(rows[0], rows[1]), rows[2]) - 1.0);
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) deviation = std::max(deviation, std::abs(glm::dot(rows[i], rows[k]) - (i == k ? 1.0 : 0.0)));
    }
    if (!(deviation < 0.02)) fail("a modelRotation that only turns", std::string(words));
    return rows;
  }

  const std::string& path_;
  const std::string place_;
  const std::map<std::string, std::string>& properties_;
};

}  // namespace

std::vector<CatalogueEntry> parseCatalogue(const std::string& path, std::string_view text) {
  std::map<uint32_t, std::map<std::string, std::string>> pieces;
  PropertiesReader reader(path, text);
  std::string key, value;
  while (reader.next(&key, &value)) {
    const size_t mark = key.find('#');
    if (mark == std::string::npos) continue;  // of the library as a whole
    uint32_t number = 0;
    const auto [end, error] = std::from_chars(key.data() + mark + 1, key.data() + key.size(), number);
    // as Sweet Home 3D, which asks for the keys of piece 1, 2, 3, …: others are of nothing (Scopia has "dropOnTopElevation#-1")
    if (error != std::errc() || end != key.data() + key.size()) continue;
    pieces[number][key.substr(0, mark)] = value;
  }
  std::vector<CatalogueEntry> entries;
  for (const auto& [number, properties] : pieces) entries.push_back(PieceProperties(path, number, properties).read());
  return entries;
}

}  // namespace nlg
