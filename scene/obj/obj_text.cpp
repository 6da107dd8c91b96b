#include "scene/obj/obj_text.h"

#include <algorithm>
#include <charconv>
#include <iterator>
#include <limits>
#include <set>
#include <unordered_map>
#include <utility>

#include "scene/archive/pk3_archive.h"
#include "scene/archive/scene_file.h"
#include "scene/model/scene_light.h"
#include "tool/error.h"

namespace nlg {
namespace {

// Triangulation of a hostile face takes time with the square of its corners.
constexpr size_t kMaxCorners = 8192;
// A file's bytes bound the memory that they take badly: two may be a triangle's, eight a vertex'.
constexpr size_t kMaxVertices = size_t{1} << 27;
constexpr size_t kMaxLibraries = 1024;  // lines: each is looked for on the disk

constexpr double kLargest = 1e30;  // of a position, in whatever unit

constexpr std::string_view kBlank = " \t\v\f";

// They say nothing of where surfaces are and what diffuse light does there; those of MTL may have images, too ("map_ks").
constexpr std::string_view kPassedByObj[] = {"vn", "s", "p", "l", "mg", "lod", "bevel", "c_interp", "d_interp"};
constexpr std::string_view kPassedByMtl[] = {"ka",   "ks",   "ns",    "ni",     "km",  "illum", "sharpness", "bump",
                                             "disp", "refl", "norm",  "kn",     "pr",  "pm",    "ps",        "pc",
                                             "pcr",  "rma",  "aniso", "anisor", "orm", "aat"};
// A name stands behind them, which may hold " #".
constexpr std::string_view kNamed[] = {"o", "g", "usemtl", "mtllib", "newmtl", "map_kd", "map_ke", "map_d", "map_opacity"};
constexpr std::string_view kImageOptions[] = {"-s",  "-o",      "-t",     "-mm",     "-bm",      "-clamp", "-blendu",
                                              "-cc", "-blendv", "-boost", "-texres", "-imfchan", "-type"};

template <size_t count>
bool isAmong(const std::string_view (&words)[count], std::string_view word) {
  return std::find(std::begin(words), std::end(words), word) != std::end(words);
}

bool readNumber(std::string_view word, double least, double most, double* value) {
  if (word.starts_with('+')) word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), *value);
  return error == std::errc() && end == word.data() + word.size() && *value >= least && *value <= most;
}

void countUnread(const std::string& words, UnreadWords* unread) {
  constexpr size_t kMostWords = 256, kLongest = 40;
  const std::string word = words.substr(0, kLongest);
  ++(*unread)[unread->size() < kMostWords || unread->count(word) > 0 ? word : "others"];
}

// Walks over a text's lines.
class Lines {
 public:
  Lines(const std::string& path, std::string_view text) : path_(path), text_(text) {
    if (text.find('\0') != std::string_view::npos) throw InputError(path_, "file", "text", "a zero byte");
    if (text_.starts_with("\xef\xbb\xbf")) text_.remove_prefix(3);
  }

  // The next one with words; false at the end.
  bool next() {
    while (!text_.empty()) {
      ++number_;
      line_ = takeLine();
      if (isContinued(line_)) line_ = joined_ = wholeLine();
      words_ = wordsOf(line_);
      if (words_.empty() || words_[0][0] == '#') continue;
      keyword_ = lowerCase(words_[0]);
      if (!isAmong(kNamed, keyword_)) {
        const auto comment = std::find_if(words_.begin(), words_.end(), [](std::string_view word) { return word[0] == '#'; });
        words_.erase(comment, words_.end());
      }
      return true;
    }
    return false;
  }

  const std::string& keyword() const { return keyword_; }
  const std::vector<std::string_view>& words() const { return words_; }  // the keyword first
  std::string_view line() const { return line_; }
  uint32_t number() const { return number_; }

  // The words behind the keyword, one blank between them.
  std::string name() const {
    std::string name;
    for (size_t i = 1; i < words_.size(); ++i) name.append(i > 1 ? " " : "").append(words_[i]);
    return name;
  }

  // Reads so many numbers from a word on; false, and some of them read, where one is missing or none.
  bool numbers(size_t first, size_t count, double least, double most, double* to) const {
    if (words_.size() < first + count) return false;
    for (size_t i = 0; i < count; ++i) {
      if (!readNumber(words_[first + i], least, most, &to[i])) return false;
    }
    return true;
  }

  [[noreturn]] void fail(const std::string& expected, std::string_view got) const {
    throw InputError(path_, place(), expected, std::string(got.substr(0, 80)));
  }

  void take(uint64_t amount, SceneBudget& budget) const {
    // there are millions of lines, and one of them at most is told of
    budget.take(amount, path_, amount > budget.left() ? place() : std::string());
  }

 private:
  std::string place() const { return "line " + std::to_string(number_); }

  std::string_view takeLine() {
    const size_t end = std::min(text_.find_first_of("\n\r"), text_.size());
    const std::string_view line = text_.substr(0, end);
    const bool is_pair = text_.substr(end, 2) == "\r\n";
    text_.remove_prefix(std::min(end + (is_pair ? 2 : 1), text_.size()));
    return line;
  }

  static bool isContinued(std::string_view line) { return !line.empty() && line.back() == '\\' && line[0] != '#'; }

  std::string wholeLine() {
    std::string whole(line_);
    while (isContinued(whole)) {
      whole.back() = ' ';
      if (text_.empty()) break;
      whole += takeLine();
      ++number_;
    }
    return whole;
  }

  const std::string& path_;
  std::string_view text_, line_;
  std::string joined_, keyword_;
  std::vector<std::string_view> words_;
  uint32_t number_ = 0;
};

class ObjParser {
 public:
  ObjParser(const std::string& path, std::string_view text) : lines_(path, text) {}

  ObjRecords parse() {
    found_.shapes.emplace_back();
    while (lines_.next()) readLine(lines_.keyword());
    return std::move(found_);
  }

 private:
  void readLine(const std::string& keyword) {
    if (keyword == "v") {
      readVertex();
    } else if (keyword == "vt") {
      readPlace();
    } else if (keyword == "f" || keyword == "fo") {
      readFace();
    } else if (keyword == "o" || keyword == "g") {
      if (found_.shapes.back().first_face < found_.faces.size()) found_.shapes.emplace_back();
      found_.shapes.back() = {lines_.name(), static_cast<uint32_t>(found_.faces.size())};
    } else if (keyword == "usemtl") {
      const auto [entry, is_new] = material_of_.try_emplace(lines_.name(), static_cast<int32_t>(material_of_.size()));
      if (is_new) found_.material_names.push_back(entry->first);
      material_ = entry->second;
    } else if (keyword == "mtllib") {
      // "mtllib" stands before every object in some files
      const bool is_known = libraries_.count(std::string(lines_.line())) > 0;
      if (!is_known && libraries_.size() == kMaxLibraries) countUnread(keyword, &found_.unread);
      if (!is_known && libraries_.size() < kMaxLibraries)
        found_.libraries.push_back(*libraries_.insert(std::string(lines_.line())).first);
    } else if (!isAmong(kPassedByObj, keyword)) {
      countUnread(keyword, &found_.unread);
    }
  }

  void readVertex() {
    const std::vector<std::string_view>& words = lines_.words();
    glm::dvec3 position;
    // faces that have such a vertex are left out; others may be whole
    if (!lines_.numbers(1, 3, -kLargest, kLargest, &position.x)) position = glm::dvec3(NAN);
    if (found_.positions.size() >= kMaxVertices) lines_.fail("at most 2^27 vertices", "more");
    found_.positions.push_back(position);
    glm::dvec3 colour;
    // a fourth number alone is a weight, of curves
    const bool has_colour = lines_.numbers(4, 3, -kLargest, kLargest, &colour.x);
    if (words.size() > 7 || (words.size() > 5 && !has_colour)) countUnread("v: more than three numbers", &found_.unread);
    if (has_colour || !found_.colours.empty()) {
      found_.colours.resize(found_.positions.size(), glm::vec3(NAN));
      if (has_colour) found_.colours.back() = glm::vec3(colour);
    }
  }

  void readPlace() {
    glm::dvec2 place(0.0);
    const size_t count = lines_.words().size() == 2 ? 1 : 2;
    if (!lines_.numbers(1, count, -kLargest, kLargest, &place.x)) place.x = std::numeric_limits<double>::quiet_NaN();
    found_.places.push_back(place);
  }

  void readFace() {
    const std::vector<std::string_view>& words = lines_.words();
    const size_t corner_count = words.size() - 1;
    if (corner_count > kMaxCorners) lines_.fail("a face of at most 8192 corners", std::to_string(corner_count));
    const size_t first = found_.corners.size();
    for (size_t i = 1; i <= corner_count; ++i) found_.corners.push_back(cornerOf(words[i]));
    if (corner_count < 3) {
      found_.corners.resize(first);
      ++found_.faces_of_two_corners;
      return;
    }
    lines_.take(corner_count - 2, triangles_);
    found_.faces.push_back({static_cast<uint32_t>(first), static_cast<uint32_t>(corner_count), material_, lines_.number()});
  }

  // V, V/T, V//N or V/T/N, each counted from 1, or from the last one back when negative.
  ObjCorner cornerOf(std::string_view corner) const {
    const size_t slash = std::min(corner.find('/'), corner.size());
    const auto count = static_cast<int64_t>(found_.positions.size());
    const int64_t vertex = std::min<int64_t>(indexOf(corner.substr(0, slash), count), ObjCorner::kNowhere);
    const std::string_view rest = corner.substr(std::min(slash + 1, corner.size()));
    const int64_t place = indexOf(rest.substr(0, rest.find('/')), static_cast<int64_t>(found_.places.size()));
    return {vertex < 0 ? ObjCorner::kNowhere : static_cast<uint32_t>(vertex),
            static_cast<int32_t>(std::min<int64_t>(place, std::numeric_limits<int32_t>::max()))};
  }

  // From 0; below it where there is none.
  static int64_t indexOf(std::string_view word, int64_t count) {
    int64_t index = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), index);
    if (error != std::errc() || end != word.data() + word.size() || index < -count) return -1;
    return index < 0 ? count + index : index - 1;
  }

  Lines lines_;
  std::set<std::string> libraries_;
  std::unordered_map<std::string, int32_t> material_of_;
  int32_t material_ = -1;
  SceneBudget triangles_ = SceneBudgets().triangles;
  ObjRecords found_;
};

class MtlParser {
 public:
  MtlParser(const std::string& path, std::string_view text, UnreadWords* unread) : lines_(path, text), unread_(*unread) {}

  std::vector<MtlMaterial> parse() {
    MtlMaterial before_any;
    while (lines_.next()) {
      const std::string& keyword = lines_.keyword();
      if (keyword == "newmtl") {
        found_.emplace_back().name = lines_.name();
      } else if (!readLine(keyword, found_.empty() ? &before_any : &found_.back())) {
        countUnread(keyword, &unread_);
      }
    }
    return std::move(found_);
  }

 private:
  // False where it is not understood.
  bool readLine(const std::string& keyword, MtlMaterial* material) {
    if (keyword == "kd") return readColour(&material->colour);
    if (keyword == "ke") return readColour(&material->shine);
    if (keyword == "d") return readShare(&material->stops);
    if (keyword == "tr") return readShare(&material->passes);
    if (keyword == "map_kd") return readImage(&material->colour_image);
    if (keyword == "map_ke") return readImage(&material->shine_image);
    if (keyword == "map_d" || keyword == "map_opacity") return readImage(&material->stops_image);
    double filter[3];
    if (keyword == "tf") return lines_.numbers(1, 3, 1.0, 1.0, filter);  // which filters nothing
    return isAmong(kPassedByMtl, std::string_view(keyword).substr(keyword.starts_with("map_") ? 4 : 0));
  }

  // "r g b", "r" alone for a grey, or "xyz x y z".
  bool readColour(std::optional<glm::dvec3>* colour) {
    const bool is_xyz = lines_.words().size() > 1 && lowerCase(lines_.words()[1]) == "xyz";
    const size_t first = is_xyz ? 2 : 1;
    const bool is_grey = lines_.words().size() == first + 1;
    glm::dvec3 three;
    if (!lines_.numbers(first, is_grey ? 1 : 3, 0.0, kBrightest, &three.x)) return false;
    if (is_grey) three = glm::dvec3(three.x);
    const glm::dmat3 srgb_of_xyz(3.2404542, -0.9692660, 0.0556434, -1.5371385, 1.8760108, -0.2040259, -0.4985314, 0.0415560,
                                 1.0572252);
    *colour = is_xyz ? glm::max(srgb_of_xyz * three, glm::dvec3(0.0)) : three;
    return true;
  }

  // "-halo" counts as without: from all sides the same.
  bool readShare(std::optional<double>* share) {
    const size_t first = lines_.words().size() == 3 && lowerCase(lines_.words()[1]) == "-halo" ? 2 : 1;
    double number = 0.0;
    if (lines_.words().size() != first + 1 || !lines_.numbers(first, 1, 0.0, 1.0, &number)) return false;
    *share = number;
    return true;
  }

  // Options, each with numbers, "on" or "off" or one word of its own, then the name. Programs write the keyword alone where there is no
  // image.
  bool readImage(MtlImage* image) {
    const std::vector<std::string_view>& words = lines_.words();
    MtlImage read;
    size_t at = 1;
    while (at + 1 < words.size() && isAmong(kImageOptions, lowerCase(words[at]))) {
      const std::string option = lowerCase(words[at++]);
      std::vector<double> numbers;
      double number = 0.0;
      for (; numbers.size() < 3 && at + 1 < words.size() && readNumber(words[at], -kLargest, kLargest, &number); ++at)
        numbers.push_back(number);
      const std::string word = lowerCase(words[at]);
      const bool has_word = word == "on" || word == "off" || option == "-imfchan" || option == "-type";
      if (numbers.empty() && has_word) ++at;
      glm::dvec2* const pair = option == "-s" ? &read.scale : &read.offset;
      for (size_t i = 0; (option == "-s" || option == "-o") && i < std::min<size_t>(numbers.size(), 2); ++i)
        (*pair)[static_cast<int>(i)] = numbers[i];
      if (option == "-clamp") read.clamp = word == "on";
      // they change what is seen, but for noughts and a gain of 1
      const bool is_plain = option == "-mm" ? numbers == std::vector{0.0, 1.0} : numbers == std::vector(numbers.size(), 0.0);
      const bool has_none = option == "-imfchan" || option == "-type";
      if (has_none || ((option == "-t" || option == "-mm") && !is_plain)) countUnread(lines_.keyword() + " " + option, &unread_);
    }
    if (at < words.size()) read.name = namedBy(words[at], words.back());
    *image = read;
    return true;
  }

  Lines lines_;
  UnreadWords& unread_;
  std::vector<MtlMaterial> found_;
};

}  // namespace

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

// Of one line, with slashes for backslashes; it may be quoted.
std::string namedBy(std::string_view first, std::string_view last) {
  const bool is_quoted = first.front() == '"' && last.back() == '"' && last.end() - first.begin() > 2;
  return withSlashes({first.begin() + (is_quoted ? 1 : 0), last.end() - (is_quoted ? 1 : 0)});
}

ObjRecords readObjRecords(const std::string& path, std::string_view text) { return ObjParser(path, text).parse(); }

std::vector<MtlMaterial> readMtlRecords(const std::string& path, std::string_view text, UnreadWords* unread) {
  return MtlParser(path, text, unread).parse();
}

}  // namespace nlg
