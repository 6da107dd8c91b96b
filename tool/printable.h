// Texts of files and command lines as people may be shown them.
#pragma once

#include <streambuf>
#include <string>
#include <string_view>

namespace nlg {

// The text in one line, with a space for every control character, those of two bytes in UTF-8 among them: what a file brings must
// neither steer a terminal nor look like a second line.
std::string printable(std::string_view text);

// The same of what a stream is given, but for ends of lines and tabs. It keeps nothing back, and is as safe among threads as the
// buffer behind it.
class PrintableBuffer : public std::streambuf {
 public:
  explicit PrintableBuffer(std::streambuf* behind) : behind_(behind) {}

 protected:
  int_type overflow(int_type character) override;
  std::streamsize xsputn(const char* text, std::streamsize count) override;
  int sync() override { return behind_->pubsync(); }

 private:
  std::streambuf* behind_;
};

}  // namespace nlg
