#include "scene/gltf_text.h"

#include <set>
#include <utility>

#include "scene/gltf_rules.h"
#include "tool/error.h"

namespace nlg {
namespace {

constexpr size_t kDeepest = 64;

// One step from the root to a value: a key, or an index when the key is empty.
struct Step {
  std::string key;
  size_t index = 0;
  bool is_index = false;
};

// A walk over the text that checks its grammar, depth and keys, and holds every value against the rules.
class TextChecker {
 public:
  TextChecker(const std::string& path, std::string_view text, bool is_binary) : path_(path), text_(text), is_binary_(is_binary) {}

  GltfText check() {
    checkValue();
    skipSpace();
    if (at_ != text_.size()) failSyntax("the end of the JSON");
    checkExtensions();
    if (!buffer_without_uri_.empty()) throw InputError(path_, buffer_without_uri_, "a uri", "none");
    if (last_indices_ >= accessor_count_) {
      const std::string expected = "an accessor below " + std::to_string(accessor_count_);
      throw InputError(path_, last_indices_place_, expected, std::to_string(last_indices_));
    }
    return std::move(found_);
  }

 private:
  [[noreturn]] void failSyntax(const std::string& expected) const {
    const std::string got = at_ < text_.size() ? "\"" + std::string(text_.substr(at_, 12)) + "\"" : "the end";
    throw InputError(path_, "byte " + std::to_string(at_) + " of the JSON", expected, got);
  }

  std::string currentPlace() const {
    std::string place;
    for (const Step& step : steps_) {
      if (step.is_index) {
        place += "[" + std::to_string(step.index) + "]";
      } else {
        place += (place.empty() ? "" : ".") + step.key.substr(0, 60);
      }
    }
    return place.empty() ? "root" : place;
  }

  [[noreturn]] void fail(const std::string& expected, const std::string& got) const {
    throw InputError(path_, currentPlace(), expected, got.substr(0, 80));
  }

  void skipSpace() {
    while (at_ < text_.size() && std::string_view(" \t\r\n").find(text_[at_]) != std::string_view::npos) ++at_;
  }

  char peek() {
    skipSpace();
    return at_ < text_.size() ? text_[at_] : '\0';
  }

  void take(char expected) {
    if (peek() != expected) failSyntax(std::string("'") + expected + "'");
    ++at_;
  }

  void checkValue() {
    if (steps_.size() > kDeepest) fail("nesting of at most 64", "more");
    switch (peek()) {
      case '{':
        return checkObject();
      case '[':
        return checkArray();
      case '"':
        return checkString();
      case 't':
        return checkWord("true", JsonKind::boolean);
      case 'f':
        return checkWord("false", JsonKind::boolean);
      case 'n':
        return checkWord("null", JsonKind::null);
      default:
        return checkNumber();
    }
  }

  void checkObject() {
    judge(JsonKind::object, "an object");
    take('{');
    std::set<std::string> keys;
    while (peek() != '}') {
      if (!keys.empty()) take(',');
      if (peek() != '"') failSyntax("a key");
      steps_.push_back({takeString()});
      if (!keys.insert(steps_.back().key).second) fail("each key once", "it twice");
      take(':');
      found_.is_packed = found_.is_packed || (steps_[0].key == "meshes" && steps_.back().key == "KHR_draco_mesh_compression");
      checkValue();
      steps_.pop_back();
    }
    take('}');
    if (steps_.size() != 2) return;
    const bool needs_uri = steps_[0].key == "buffers" && (!is_binary_ || steps_[1].index > 0);
    if (needs_uri && keys.count("uri") == 0 && !is_fallback_ && buffer_without_uri_.empty()) buffer_without_uri_ = currentPlace();
    found_.is_packed = found_.is_packed || is_fallback_;
    is_fallback_ = false;
    const bool is_moved = keys.count("translation") + keys.count("rotation") + keys.count("scale") > 0;
    if (steps_[0].key == "nodes" && keys.count("matrix") > 0 && is_moved)
      fail("a matrix or translation, rotation and scale", "both");
  }

  void checkArray() {
    judge(JsonKind::array, "an array");
    take('[');
    steps_.push_back({"", 0, true});
    while (peek() != ']') {
      if (steps_.back().index > 0) take(',');
      checkValue();
      ++steps_.back().index;
    }
    const size_t length = steps_.back().index;
    steps_.pop_back();
    take(']');
    judgeLength(length);
  }

  void judgeLength(size_t length) {
    if (steps_.size() == 1 && steps_[0].key == "accessors") accessor_count_ = static_cast<int64_t>(length);
    if (steps_.size() < 3 || steps_.back().is_index || isForeign()) return;
    for (const GltfLengthRule& rule : kLengths) {
      if (rule.section != steps_[0].key || rule.key != steps_.back().key || rule.length == length) continue;
      fail(std::to_string(rule.length) + " numbers", std::to_string(length));
    }
  }

  // Before whatever else a file lacks: that may be what the extension provides for.
  void checkExtensions() const {
    for (const auto& [place, name] : required_extensions_) {
      if (mayBeRequired(name)) continue;
      std::string readable;
      for (const std::string_view known : kReadExtensions) readable += std::string(known) + ", ";
      throw InputError(path_, place, readable + "or an extension of materials, textures or lights", name.substr(0, 80));
    }
  }

  // tinygltf looks an index accessor up before we can, and does not say whose it was.
  void noteIndices(const std::string& text) {
    const int64_t idx = std::stoll(text);
    if (idx <= last_indices_) return;
    last_indices_ = idx;
    last_indices_place_ = currentPlace();
  }

  void checkString() {
    const std::string value = takeString();
    judge(JsonKind::string, "\"" + value + "\"");
    if (steps_.size() == 3 && steps_[0].key == "buffers" && steps_[2].key == "uri") checkUri(value);
    if (steps_.size() == 2 && steps_[0].key == "extensionsRequired") required_extensions_.emplace_back(currentPlace(), value);
  }

  void checkWord(std::string_view word, JsonKind kind) {
    if (text_.substr(at_, word.size()) != word) failSyntax("a value");
    at_ += word.size();
    judge(kind, std::string(word));
    // its bytes are nowhere: views into it are unpacked from elsewhere
    const bool is_fallback = steps_.size() == 5 && steps_[0].key == "buffers" && steps_[2].key == "extensions" &&
                             steps_[3].key == "EXT_meshopt_compression" && steps_[4].key == "fallback" && word == "true";
    is_fallback_ = is_fallback_ || is_fallback;
  }

  void checkNumber() {
    const size_t start = at_;
    while (at_ < text_.size() && std::string_view("+-.0123456789eE").find(text_[at_]) != std::string_view::npos) ++at_;
    const std::string_view number = text_.substr(start, at_ - start);
    if (number.empty()) failSyntax("a value");
    JsonKind kind = JsonKind::number;
    if (number.find_first_not_of("0123456789") == std::string_view::npos && number.size() <= 16) {
      const uint64_t value = std::stoull(std::string(number));
      if (value < uint64_t{1} << 53) kind = value < uint64_t{1} << 31 ? JsonKind::index : JsonKind::integer;
    }
    judge(kind, std::string(number));
  }

  // Holds a value's kind against what stands at the current place in glTF.
  void judge(JsonKind got, const std::string& text) {
    if (steps_.empty()) {
      if (got != JsonKind::object) fail("an object", text);
      return;
    }
    const std::string& section = steps_[0].key;
    if (steps_.size() == 1) {
      if (isSection(section)) require(got, JsonKind::array, text);
      if (section == "scene") require(got, JsonKind::index, text);
    }
    if (!isSection(section) || isForeign()) return;
    if (steps_.size() == 2) return require(got, JsonKind::object, text);
    const Step& last = steps_.back();
    const std::string& key = last.is_index ? steps_[steps_.size() - 2].key : last.key;
    for (const GltfRule& rule : kRules) {
      if (rule.section != section || rule.key != key) continue;
      if (last.is_index) return requireElement(rule, got, text);
      // inside of "sparse" and of extensions, tinygltf keeps sizes in an int
      const bool is_narrow =
          rule.kind == JsonKind::integer && steps_.size() > 3 && (section == "accessors" || section == "bufferViews");
      require(got, is_narrow ? JsonKind::index : rule.kind, text);
      if (rule.key == "indices") noteIndices(text);
      return;
    }
  }

  void requireElement(const GltfRule& rule, JsonKind got, const std::string& text) {
    if (rule.kind != JsonKind::array) return;
    const bool holds_indices = rule.key == "children" || rule.key == "nodes";
    const bool holds_objects = rule.key == "primitives";
    require(got, holds_indices ? JsonKind::index : holds_objects ? JsonKind::object : JsonKind::number, text);
  }

  void require(JsonKind got, JsonKind expected, const std::string& text) {
    if (!satisfies(got, expected)) fail(std::string("a JSON ") + kindName(expected), text);
  }

  // Extras are anybody's, and so are extensions but for those that are read.
  bool isForeign() const {
    for (size_t i = 0; i < steps_.size(); ++i) {
      if (steps_[i].key == "extras") return true;
      if (steps_[i].key != "extensions") continue;
      return i + 1 >= steps_.size() || !isChecked(steps_[i + 1].key);
    }
    return false;
  }

  // The string's characters; those beyond ASCII that are written as \u are not needed in any key or URI and become '?'.
  std::string takeString() {
    take('"');
    std::string value;
    while (at_ < text_.size() && text_[at_] != '"') {
      if (text_[at_] != '\\') {
        value += text_[at_++];
      } else {
        value += takeEscape();
      }
    }
    if (at_ >= text_.size()) failSyntax("'\"'");
    ++at_;
    return value;
  }

  char takeEscape() {
    if (at_ + 1 >= text_.size()) failSyntax("an escape");
    const char letter = text_[at_ + 1];
    at_ += 2;
    constexpr std::string_view kLetters = "bfnrt";
    constexpr std::string_view kMeanings = "\b\f\n\r\t";
    if (const size_t i = kLetters.find(letter); i != std::string_view::npos) return kMeanings[i];
    if (letter != 'u') return letter;
    if (text_.size() - at_ < 4) failSyntax("four hexadecimal digits");
    unsigned code = 0;
    for (int digit = 0; digit < 4; ++digit) code = code * 16 + hexValue(text_[at_++]);
    return code < 128 ? static_cast<char>(code) : '?';
  }

  unsigned hexValue(char digit) const {
    constexpr std::string_view kDigits = "0123456789abcdef0123456789ABCDEF";
    const size_t i = kDigits.find(digit);
    if (i == std::string_view::npos) failSyntax("a hexadecimal digit");
    return static_cast<unsigned>(i % 16);
  }

  static bool isHex(char c) { return std::string_view("0123456789abcdefABCDEF").find(c) != std::string_view::npos; }

  void checkUri(const std::string& uri) {
    if (uri.rfind("data:", 0) == 0) return;
    std::string name;
    for (size_t i = 0; i < uri.size(); ++i) {
      if (uri[i] != '%') {
        name += uri[i];
        continue;
      }
      if (i + 2 >= uri.size() || !isHex(uri[i + 1]) || !isHex(uri[i + 2])) fail("two hexadecimal digits after %", uri);
      name += static_cast<char>(hexValue(uri[i + 1]) * 16 + hexValue(uri[i + 2]));
      i += 2;
    }
    if (name.empty()) fail("a file name", "an empty uri");
    for (const char c : name) {
      if (static_cast<unsigned char>(c) < 32 || c == '\\' || c == ':') fail("a file in the folder, or data:", uri);
    }
    if (name[0] == '/' || ("/" + name + "/").find("/../") != std::string::npos) fail("a file in the folder or below", uri);
    found_.buffer_files.push_back(name);
  }

  const std::string& path_;
  std::string_view text_;
  bool is_binary_;
  size_t at_ = 0;
  std::vector<Step> steps_;
  GltfText found_;
  bool is_fallback_ = false;                                              // the buffer being read
  std::vector<std::pair<std::string, std::string>> required_extensions_;  // place, name
  std::string buffer_without_uri_;                                        // the first one's place
  int64_t accessor_count_ = 0, last_indices_ = -1;
  std::string last_indices_place_;
};

}  // namespace

GltfText checkGltfText(const std::string& path, std::string_view text, bool is_binary) {
  return TextChecker(path, text, is_binary).check();
}

}  // namespace nlg
