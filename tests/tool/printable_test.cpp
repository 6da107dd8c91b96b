#include "tool/printable.h"

#include <gtest/gtest.h>

#include <sstream>

namespace nlg {
namespace {

TEST(Printable, LetsNothingSteerATerminal) {
  EXPECT_EQ(printable("a\033[2Jb"), "a [2Jb");
  EXPECT_EQ(printable("a\rb\x7f"), "a b ");
  EXPECT_EQ(printable(std::string("a\0b", 3)), "a b");
  // U+009B, which begins what ESC [ begins
  EXPECT_EQ(printable("a\xc2\x9b"
                      "2Jb"),
            "a 2Jb");
  EXPECT_EQ(printable("\xc2\x80\xc2\x9f"), "  ");
  // half of a character is no control character, and no text
  EXPECT_EQ(printable("\xc2"), "\xef\xbf\xbd");
  EXPECT_EQ(printable("a\xffz\xc3\xbc"), "a\xef\xbf\xbdz\xc3\xbc");
}

TEST(PrintableBuffer, KeepsLinesAndTabsOnly) {
  std::ostringstream behind;
  PrintableBuffer buffer(behind.rdbuf());
  std::ostream stream(&buffer);
  stream << "a\tb\n" << '\033' << "[2J" << std::string("c\xc2\x9b") << 7 << std::flush;
  EXPECT_TRUE(stream.good());
  EXPECT_EQ(behind.str(), "a\tb\n [2Jc 7");
}

}  // namespace
}  // namespace nlg
