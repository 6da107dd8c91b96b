#include "runtime_eval/weights_file/header_parser.h"

#include <limits>
#include <utility>

namespace nlg {
namespace {

constexpr const char* kMetadataKey = "__metadata__";

// Bytes of the UTF-8 sequence at the start of text; 0 when it is none (overlong forms and surrogates are none).
size_t utf8Length(std::string_view text) {
  const auto byte = [&](size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
  const auto continues = [&](size_t i) { return (byte(i) & 0xc0) == 0x80; };
  const unsigned first = byte(0), second = byte(1);
  if (first < 0x80) return 1;
  if (first >= 0xc2 && first <= 0xdf) return continues(1) ? 2 : 0;
  if (first >= 0xe0 && first <= 0xef) {
    const bool overlong = first == 0xe0 && second < 0xa0, surrogate = first == 0xed && second > 0x9f;
    return continues(1) && continues(2) && !overlong && !surrogate ? 3 : 0;
  }
  if (first < 0xf0 || first > 0xf4) return 0;
  const bool overlong = first == 0xf0 && second < 0x90, too_large = first == 0xf4 && second > 0x8f;
  return continues(1) && continues(2) && continues(3) && !overlong && !too_large ? 4 : 0;
}

void appendUtf8(uint32_t code, std::string* text) {
  const auto put = [&](uint32_t byte) { *text += static_cast<char>(byte); };
  if (code < 0x80) return put(code);
  if (code < 0x800) {
    put(0xc0 | code >> 6);
  } else if (code < 0x10000) {
    put(0xe0 | code >> 12);
    put(0x80 | (code >> 6 & 0x3f));
  } else {
    put(0xf0 | code >> 18);
    put(0x80 | (code >> 12 & 0x3f));
    put(0x80 | (code >> 6 & 0x3f));
  }
  put(0x80 | (code & 0x3f));
}

// Every parse function returns false after the first fault; fault_ then says which.
class HeaderParser {
 public:
  explicit HeaderParser(std::string_view text) : text_(text) {}
  const std::string& fault() const { return fault_; }

  bool parse(WeightsHeader* header) {
    if (text_.empty() || text_[0] != '{') return expected("'{'");
    bool has_metadata = false;
    // each name once, so that no two readers disagree
    const auto parseEntry = [&](const std::string& name) {
      if (name == kMetadataKey) {
        if (std::exchange(has_metadata, true)) return expected("__metadata__ once");
        return parseMetadata(header);
      }
      const auto [entry, is_new] = header->tensors.try_emplace(name);
      if (!is_new) return expected("each tensor once");
      return parseTensor(&entry->second);
    };
    if (!parseObject(parseEntry)) return false;
    while (at_ < text_.size() && text_[at_] == ' ') ++at_;
    return at_ == text_.size() || expected("spaces up to the end of the header");
  }

 private:
  bool expected(const std::string& what) {
    if (fault_.empty()) fault_ = "byte " + std::to_string(at_) + ": expected " + what;
    return false;
  }

  void skipBlanks() {
    while (at_ < text_.size() && std::string_view(" \t\n\r").find(text_[at_]) != std::string_view::npos) ++at_;
  }

  bool takeIf(char c) {
    skipBlanks();
    if (at_ >= text_.size() || text_[at_] != c) return false;
    ++at_;
    return true;
  }

  bool take(char c) { return takeIf(c) || expected(std::string("'") + c + "'"); }

  // An object; parseValue(key) takes each value.
  template <class ParseValue>
  bool parseObject(const ParseValue& parseValue) {
    if (!take('{')) return false;
    if (takeIf('}')) return true;
    do {
      std::string key;
      if (!parseText(&key) || !take(':') || !parseValue(key)) return false;
    } while (takeIf(','));
    return take('}');
  }

  bool parseMetadata(WeightsHeader* header) {
    return parseObject([&](const std::string& key) {
      const auto [entry, is_new] = header->metadata.try_emplace(key);
      if (!is_new) return expected("each key of __metadata__ once");
      skipBlanks();
      if (key == kDigestKey) header->digest_offset = at_ + 1;  // behind the quote
      return parseText(&entry->second);
    });
  }

  bool parseTensor(TensorEntry* tensor) {
    bool has_dtype = false, has_shape = false, has_offsets = false;
    std::vector<uint64_t> offsets;
    const auto parseField = [&](const std::string& key) {
      if (key == "dtype" && !std::exchange(has_dtype, true)) return parseText(&tensor->dtype);
      if (key == "shape" && !std::exchange(has_shape, true)) return parseIntegers(kMaxTensorDimensions, &tensor->shape);
      if (key == "data_offsets" && !std::exchange(has_offsets, true)) return parseIntegers(2, &offsets);
      return expected("dtype, shape and data_offsets, each once");
    };
    if (!parseObject(parseField)) return false;
    if (!has_dtype || !has_shape || offsets.size() != 2) return expected("dtype, shape and two data_offsets before here");
    tensor->begin = offsets[0];
    tensor->end = offsets[1];
    return true;
  }

  bool parseIntegers(size_t max_count, std::vector<uint64_t>* values) {
    if (!take('[')) return false;
    if (takeIf(']')) return true;
    do {
      uint64_t value = 0;
      if (values->size() == max_count) return expected("at most " + std::to_string(max_count) + " numbers");
      if (!parseInteger(&value)) return false;
      values->push_back(value);
    } while (takeIf(','));
    return take(']');
  }

  bool parseInteger(uint64_t* value) {
    skipBlanks();
    const size_t first = at_;
    const auto isDigit = [&] { return at_ < text_.size() && text_[at_] >= '0' && text_[at_] <= '9'; };
    for (; isDigit(); ++at_) {
      const auto digit = static_cast<uint64_t>(text_[at_] - '0');
      if (*value > (std::numeric_limits<uint64_t>::max() - digit) / 10) return expected("an integer below 2^64");
      *value = 10 * *value + digit;
    }
    const bool leading_zero = at_ - first > 1 && text_[first] == '0';
    return (at_ > first && !leading_zero) || expected("an unsigned integer");
  }

  bool parseText(std::string* text) {
    if (!take('"')) return false;
    while (at_ < text_.size() && text_[at_] != '"') {
      if (text_[at_] == '\\') {
        if (!parseEscape(text)) return false;
        continue;
      }
      const size_t length = utf8Length(text_.substr(at_));
      if (length == 0 || static_cast<unsigned char>(text_[at_]) < 0x20) return expected("UTF-8 without control characters");
      text->append(text_.substr(at_, length));
      at_ += length;
    }
    return at_ < text_.size() ? take('"') : expected("'\"'");
  }

  bool parseEscape(std::string* text) {
    constexpr std::string_view kEscapes = "\"\\/bfnrt", kMeanings = "\"\\/\b\f\n\r\t";
    ++at_;
    if (at_ < text_.size() && text_[at_] == 'u') return parseCodePoint(text);
    const size_t which = at_ < text_.size() ? kEscapes.find(text_[at_]) : std::string_view::npos;
    if (which == std::string_view::npos) return expected("a JSON escape");
    *text += kMeanings[which];
    ++at_;
    return true;
  }

  // \uXXXX, or two of them that make a surrogate pair; at_ stands on the first 'u'.
  bool parseCodePoint(std::string* text) {
    uint32_t code = 0, low = 0;
    if (!parseHexadecimal(&code)) return false;
    if (code >= 0xdc00 && code <= 0xdfff) return expected("no second half of a surrogate pair");
    if (code >= 0xd800 && code <= 0xdbff) {
      if (text_.substr(at_, 2) != "\\u") return expected("the second half of a surrogate pair");
      ++at_;
      if (!parseHexadecimal(&low)) return false;
      if (low < 0xdc00 || low > 0xdfff) return expected("the second half of a surrogate pair");
      code = 0x10000 + ((code - 0xd800) << 10) + (low - 0xdc00);
    }
    appendUtf8(code, text);
    return true;
  }

  bool parseHexadecimal(uint32_t* code) {
    ++at_;
    for (int i = 0; i < 4; ++i, ++at_) {
      const char c = at_ < text_.size() ? text_[at_] : '\0';
      const char lower = static_cast<char>(c | 0x20);
      if (c >= '0' && c <= '9') {
        *code = *code << 4 | static_cast<uint32_t>(c - '0');
      } else if (lower >= 'a' && lower <= 'f') {
        *code = *code << 4 | static_cast<uint32_t>(lower - 'a' + 10);
      } else {
        return expected("four hexadecimal digits");
      }
    }
    return true;
  }

  std::string_view text_;
  size_t at_ = 0;
  std::string fault_;
};

}  // namespace

std::string parseWeightsHeader(std::string_view text, WeightsHeader* header) {
  HeaderParser parser(text);
  parser.parse(header);
  return parser.fault();
}

std::string jsonQuoted(std::string_view text) {
  std::string json = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      json += '\\';
      json += c;
    } else if (static_cast<unsigned char>(c) < 0x20) {
      json += "\\u00";
      json += "0123456789abcdef"[c >> 4];
      json += "0123456789abcdef"[c & 15];
    } else {
      json += c;
    }
  }
  return json + '"';
}

}  // namespace nlg
