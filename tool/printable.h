// Formats texts of files and command lines, and quantities, for people.
#pragma once

#include <cstdint>
#include <optional>
#include <streambuf>
#include <string>
#include <string_view>
#include <vector>

namespace nlg {

// The text in one line of UTF-8, with a space for every control character, those of two bytes among them, and U+FFFD for what is no
// UTF-8: what a file brings must neither steer a terminal nor look like a second line nor stop a reader of lines.
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

// "12,345".
std::string countText(uint64_t count);

// "1 probe", "12,345 probes".
// noun   one of them; its plural adds an s
std::string countText(uint64_t count, const std::string& noun);

// The same of an estimate: two digits of it.
std::string roughCountText(double count, const std::string& noun);

// "45 kB", "3.1 MB", "2.4 GB".
std::string bytesText(double bytes);

// "2.3 s" below ten seconds, then "22 s", "3 min 05 s", "2 h 07 min".
std::string durationText(double seconds);

// What a misspelt name was meant to be: the known one that differs from the given one by the fewest letters, the first of several; none where the fewest are more than
// one, and more than a third of that name's.
std::optional<std::string> nearestName(const std::string& name, const std::vector<std::string>& known);

}  // namespace nlg
