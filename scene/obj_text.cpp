#include "scene/obj_text.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstdlib>
#include <utility>

#include "scene/scene_budget.h"
#include "tool/error.h"

namespace nlg {
namespace {

// Triangulation takes time with the square of a face's corners.
constexpr size_t kMaxCorners = 1024;
// A file's bytes bound the memory that they take badly: two may be a triangle's, eight a vertex'.
constexpr int64_t kMaxVertices = int64_t{1} << 27;

constexpr double kLargest = 1e30;    // of a position, in whatever unit
constexpr double kBrightest = 1e12;  // as of glTF

constexpr std::string_view kBlank = " \t";
constexpr char kInnerBlank = '\x1f';  // no name holds it

// The line's words; the views are into it.
std::vector<std::string_view> wordsOf(std::string_view line) {
  std::vector<std::string_view> words;
  size_t at = line.find_first_not_of(kBlank);
  while (at != std::string_view::npos) {
    const size_t end = line.find_first_of(kBlank, at);
    words.push_back(line.substr(at, end == std::string_view::npos ? end : end - at));
    at = line.find_first_not_of(kBlank, end);
  }
  return words;
}

// Walks over lines, calls check(words) for each and keeps those for which it says so.
class LineChecker {
 public:
  explicit LineChecker(const std::string& path) : path_(path) {}

  template <class Check>
  std::string keep(std::string_view text, const Check& check) {
    if (text.find('\0') != std::string_view::npos) throw InputError(path_, "file", "text", "a zero byte");
    std::string kept;
    kept.reserve(text.size());
    std::string joined;
    while (!text.empty()) {
      ++line_number_;
      std::string_view line = takeLine(&text);
      if (isContinued(line)) line = joined = wholeLine(line, &text);
      const std::vector<std::string_view> words = wordsOf(line);
      if (!words.empty() && check(words)) keepLine(line, words, &kept);
    }
    return kept;
  }

  [[noreturn]] void fail(const std::string& expected, std::string_view got) const {
    throw InputError(path_, place(), expected, std::string(got.substr(0, 80)));
  }

  void take(uint64_t amount, SceneBudget& budget) const {
    // there are millions of lines, and one of them at most is told of
    budget.take(amount, path_, amount > budget.left() ? place() : std::string());
  }

  // The numbers behind a line's first word, count of them or more.
  void checkNumbers(const std::vector<std::string_view>& words, size_t count, double least, double most,
                    const std::string& expected) const {
    if (words.size() <= count) fail(expected, std::to_string(words.size() - 1));
    for (size_t i = 1; i <= count; ++i) {
      const std::string word(words[i]);
      char* end = nullptr;
      const double value = std::strtod(word.c_str(), &end);
      const bool is_decimal = word.find_first_not_of("+-.0123456789eE") == std::string::npos;  // tinyobjloader reads no other
      if (!is_decimal || *end != '\0' || !(value >= least && value <= most)) fail(expected, word);
    }
  }

 private:
  std::string place() const { return "line " + std::to_string(line_number_); }

  static std::string_view takeLine(std::string_view* text) {
    const size_t end = std::min(text->find_first_of("\n\r"), text->size());
    const std::string_view line = text->substr(0, end);
    const bool is_pair = text->substr(end, 2) == "\r\n";
    text->remove_prefix(std::min(end + (is_pair ? 2 : 1), text->size()));
    return line;
  }

  static bool isContinued(std::string_view line) { return !line.empty() && line.back() == '\\' && line[0] != '#'; }

  // tinyobjloader does not know that a backslash at its end continues a line.
  std::string wholeLine(std::string_view line, std::string_view* text) {
    std::string whole(line);
    while (isContinued(whole)) {
      whole.back() = ' ';
      if (text->empty()) break;
      whole += takeLine(text);
      ++line_number_;
    }
    return whole;
  }

  // Names of materials may hold blanks; tinyobjloader would take their first words.
  static void keepLine(std::string_view line, const std::vector<std::string_view>& words, std::string* kept) {
    if (words[0] == "usemtl" || words[0] == "newmtl") {
      kept->append(words[0]);
      for (size_t i = 1; i < words.size(); ++i) kept->append(1, i == 1 ? ' ' : kInnerBlank).append(words[i]);
    } else {
      kept->append(line);
    }
    kept->push_back('\n');
  }

  const std::string& path_;
  uint64_t line_number_ = 0;
};

class ObjChecker {
 public:
  explicit ObjChecker(const std::string& path) : lines_(path) {}

  ObjText check(std::string_view text) {
    found_.lines = lines_.keep(text, [&](const std::vector<std::string_view>& words) { return checkLine(words); });
    return std::move(found_);
  }

 private:
  bool checkLine(const std::vector<std::string_view>& words) {
    const std::string_view kind = words[0];
    if (kind == "v") {
      lines_.checkNumbers(words, 3, -kLargest, kLargest, "three numbers of -1e30 to 1e30");
      if (++vertex_count_ > kMaxVertices) lines_.fail("at most 2^27 vertices", "more");
    } else if (kind == "f") {
      return checkFace(words);
    }
    return kind == "v" || kind == "vt" || kind == "vn" || kind == "g" || kind == "o" || kind == "usemtl" || kind == "mtllib";
  }

  // Whether it has an inside.
  bool checkFace(const std::vector<std::string_view>& words) {
    const size_t corner_count = words.size() - 1;
    if (corner_count > kMaxCorners) lines_.fail("a face of at most 1024 corners", std::to_string(corner_count));
    for (size_t i = 1; i <= corner_count; ++i) checkCorner(words[i]);
    if (corner_count < 3) {
      ++found_.faces_of_two_corners;
      return false;
    }
    lines_.take(corner_count - 2, triangles_);
    return true;
  }

  // V, V/T, V//N or V/T/N, each counted from 1, or from the last one back when negative.
  void checkCorner(std::string_view corner) const {
    const std::string_view index = corner.substr(0, corner.find('/'));
    int64_t vertex = 0;
    const auto [end, error] = std::from_chars(index.data(), index.data() + index.size(), vertex);
    const bool is_number = error == std::errc() && end == index.data() + index.size();
    const bool is_known = is_number && vertex != 0 && vertex <= vertex_count_ && vertex >= -vertex_count_;
    if (!is_known) lines_.fail("a vertex of 1 to " + std::to_string(vertex_count_) + ", or one counted back", corner);
  }

  LineChecker lines_;
  int64_t vertex_count_ = 0;
  SceneBudget triangles_ = SceneBudgets().triangles;
  ObjText found_;
};

bool isOpacity(const std::vector<std::string_view>& words) {
  if ((words[0] != "d" && words[0] != "Tr") || words.size() != 2) return false;
  double share = -1.0;
  const auto [end, error] = std::from_chars(words[1].data(), words[1].data() + words[1].size(), share);
  return error == std::errc() && end == words[1].data() + words[1].size() && share >= 0.0 && share <= 1.0;
}

}  // namespace

ObjText checkedObjText(const std::string& path, std::string_view text) { return ObjChecker(path).check(text); }

std::string checkedMtlText(const std::string& path, std::string_view text) {
  LineChecker lines(path);
  return lines.keep(text, [&](const std::vector<std::string_view>& words) {
    const bool is_colour = words[0] == "Kd" || words[0] == "Ke";
    if (is_colour) lines.checkNumbers(words, 3, 0.0, kBrightest, "three numbers of 0 to 1e12");
    const bool is_image = words[0] == "map_Kd" || words[0] == "map_Ke" || words[0] == "map_d";
    return is_colour || is_image || isOpacity(words) || words[0] == "newmtl";
  });
}

}  // namespace nlg
