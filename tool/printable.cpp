#include "tool/printable.h"

namespace nlg {
namespace {

// kept   control characters that stay
std::string withoutControls(std::string_view text, std::string_view kept) {
  std::string shown;
  shown.reserve(text.size());
  for (size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    const auto next = i + 1 < text.size() ? static_cast<unsigned char>(text[i + 1]) : 0u;
    const bool is_control = (byte < 0x20 || byte == 0x7f) && kept.find(text[i]) == std::string_view::npos;
    // U+0080 to U+009F: what ESC and a letter say, in one character
    const bool is_long_control = byte == 0xc2 && next >= 0x80 && next < 0xa0;
    shown += is_control || is_long_control ? ' ' : text[i];
    i += is_long_control ? 1 : 0;
  }
  return shown;
}

}  // namespace

std::string printable(std::string_view text) { return withoutControls(text, ""); }

PrintableBuffer::int_type PrintableBuffer::overflow(int_type character) {
  if (traits_type::eq_int_type(character, traits_type::eof())) return traits_type::not_eof(character);
  const char one = traits_type::to_char_type(character);
  return xsputn(&one, 1) == 1 ? character : traits_type::eof();
}

std::streamsize PrintableBuffer::xsputn(const char* text, std::streamsize count) {
  const std::string shown = withoutControls({text, static_cast<size_t>(count)}, "\n\t");
  const auto size = static_cast<std::streamsize>(shown.size());
  return behind_->sputn(shown.data(), size) == size ? count : 0;
}

}  // namespace nlg
